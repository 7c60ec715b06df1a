//! What a Cortex-M board does when the firmware cannot go on: it keeps a message in memory whose content survives a reset,
//! resets, and reads the message at the next boot.
//!
//! - A **panic** leaves its source position and text (of `core::panic!`).
//! - A **fault** leaves the processor's fault registers and the address of the instruction.
//! - A **stack overflow** is a fault: the board's linker script puts the stack at the lower end of a memory, so a stack that
//!   grows too far does not overwrite data, and the processor's memory protection guards the addresses below. The handler
//!   does not use the exhausted stack.
//!
//! The same memory hands a few bytes over to the next start (`restart`).
//!
//! The firmware calls `arm` first, and `take_message` as soon as it can log. The linker script must define `_stack_start` and
//! `_stack_end`, the upper and lower end of the stack (the lower one aligned to 64 KiB, with as many unused addresses below),
//! and a section `.retained` that is not loaded, in memory that keeps its content over a reset and that is not cached.
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
