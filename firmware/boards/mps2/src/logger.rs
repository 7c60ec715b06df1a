//! defmt's global logger on the log's UART.
//!
//! A message is copied into the UART's ring, which takes some microseconds; an interrupt of low priority sends it. A message
//! that does not fit is cut off, and the decoder continues with the next one.
#![allow(unsafe_code, reason = "defmt's contract of acquire and release")]

use crate::uart::LOG;
use core::cell::UnsafeCell;
use critical_section::RestoreState;
use defmt::{Encoder, Logger, global_logger};

#[global_logger]
struct UartLogger;

struct State(UnsafeCell<(Encoder, RestoreState)>);

// SAFETY: used between `acquire` and `release` only, that is, in a critical section.
unsafe impl Sync for State {}

static STATE: State = State(UnsafeCell::new((Encoder::new(), RestoreState::invalid())));

// SAFETY: `acquire` opens a critical section that `release` closes.
unsafe impl Logger for UartLogger {
    fn acquire() {
        // SAFETY: `release` is called for each `acquire`.
        let restore = unsafe { critical_section::acquire() };
        // SAFETY: in the critical section nobody else uses the state.
        let (encoder, kept) = unsafe { &mut *STATE.0.get() };
        *kept = restore;
        encoder.start_frame(|bytes| LOG.try_write(bytes));
    }

    unsafe fn write(bytes: &[u8]) {
        // SAFETY: called between `acquire` and `release`.
        let (encoder, _) = unsafe { &mut *STATE.0.get() };
        encoder.write(bytes, |bytes| LOG.try_write(bytes));
    }

    unsafe fn flush() {}

    unsafe fn release() {
        // SAFETY: called between `acquire` and the release below.
        let (encoder, kept) = unsafe { &mut *STATE.0.get() };
        encoder.end_frame(|bytes| LOG.try_write(bytes));
        LOG.kick();
        // SAFETY: this is the state that `acquire` got.
        unsafe { critical_section::release(*kept) }
    }
}
