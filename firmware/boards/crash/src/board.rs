//! Resets and hangs of the board.

use crate::{RETAINED_BYTES, message, retained};
use core::panic::PanicInfo;
use cortex_m::peripheral::SCB;

/// Resets the board, and hands bytes over to the next start if there are any.
pub fn restart(retained: Option<[u8; RETAINED_BYTES]>) -> ! {
    if let Some(bytes) = retained {
        retained::retain(bytes);
    }
    SCB::sys_reset()
}

/// Hangs with interrupts off; only a watchdog ends it.
pub fn hang() -> ! {
    cortex_m::interrupt::disable();
    loop {
        cortex_m::asm::nop();
    }
}

/// Resets the board and keeps the reason as a message for the next start.
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
