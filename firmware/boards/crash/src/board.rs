//! The ways out.

use crate::{RETAINED_BYTES, message, retained};
use core::panic::PanicInfo;
use cortex_m::peripheral::SCB;

/// Starts over, and hands bytes over to the next start if there are any.
pub fn restart(retained: Option<[u8; RETAINED_BYTES]>) -> ! {
    if let Some(bytes) = retained {
        retained::retain(bytes);
    }
    SCB::sys_reset()
}

/// Does nothing any more, whatever comes: only a watchdog helps.
pub fn hang() -> ! {
    cortex_m::interrupt::disable();
    loop {
        cortex_m::asm::nop();
    }
}

/// Starts over because of something that a message tells at the next start.
pub fn give_up(reason: &str) -> ! {
    cortex_m::interrupt::disable();
    message::keep(format_args!("{reason}"));
    SCB::sys_reset()
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    message::keep(format_args!("{info}"));
    SCB::sys_reset()
}
