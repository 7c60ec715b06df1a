//! What a Cortex-M board does when the firmware cannot go on: it keeps a message in memory that
//! outlives a reset, resets, and has the message at the next boot.
//!
//! - A **panic** leaves its place and text (of `core::panic!`).
//! - A **fault** leaves the processor's fault registers and the address of the instruction.
//! - A **stack overflow** is a fault: the board's linker script puts the stack at the lower end of a
//!   memory, so that growing too far leaves it instead of overwriting data, and the processor's
//!   memory protection guards what lies below. The handler does not use the exhausted stack.
//!
//! The same memory hands a few bytes over from one start to the next (`restart`).
//!
//! The firmware calls `arm` first of all, and `take_message` when it can log. Needed in the
//! linker script: `_stack_start` and `_stack_end`, the upper and lower end of the stack (the lower one
//! aligned to 64 KiB, with as much of unused addresses below), and a section `.retained` that is not
//! loaded, in memory that keeps its content over a reset and that no data cache stands before.
#![cfg_attr(not(test), no_std)]

#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod fault;
#[cfg(target_os = "none")]
mod memory;
#[cfg(target_os = "none")]
mod message;
#[cfg(target_os = "none")]
mod retained;
#[cfg(any(target_os = "none", test))]
mod words;

#[cfg(target_os = "none")]
pub use {
    board::{give_up, hang, restart},
    fault::arm,
    message::{MESSAGE_BYTES, Message, take_message},
    retained::{RETAINED_BYTES, count_start, take_retained},
};
