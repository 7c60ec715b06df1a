//! What a Cortex-M board does when the firmware cannot go on: it keeps a message in memory that
//! outlives a reset, resets, and has the message at the next boot.
//!
//! - A **panic** leaves its place and text ([`panic`](core::panic)).
//! - A **fault** leaves the processor's fault registers and the address of the instruction.
//! - A **stack overflow** is a fault: the board's linker script puts the stack at the lower end of a
//!   memory, so that growing too far leaves it instead of overwriting data, and the processor's
//!   memory protection guards what lies below. The handler does not use the exhausted stack.
//!
//! The same memory hands a few bytes over from one start to the next ([`restart`]).
//!
//! The firmware calls [`arm`] first of all, and [`take_message`] when it can log. Needed in the
//! linker script: `_stack_start` and `_stack_end`, the upper and lower end of the stack (the lower one
//! aligned to 64 KiB, with as much of unused addresses below), and cortex-m-rt's section `.uninit`
//! in memory that keeps its content over a reset.
#![no_std]

mod fault;
mod message;
mod retained;

pub use fault::arm;
pub use message::{MESSAGE_BYTES, Message, take_message};
pub use retained::{RETAINED_BYTES, count_start, take_retained};

use core::panic::PanicInfo;
use cortex_m::peripheral::SCB;

/// Starts over, and hands bytes over to the next start if there are any.
pub fn restart(retained: Option<[u8; RETAINED_BYTES]>) -> ! {
    if let Some(bytes) = retained {
        retained::retain(bytes);
    }
    SCB::sys_reset()
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    message::keep(format_args!("{info}"));
    SCB::sys_reset()
}
