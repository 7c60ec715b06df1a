//! Counts the frames that the driver's interrupt takes out of the FIFOs of FDCAN1, by their state before and after it.
#![allow(unsafe_code, reason = "the contract of Embassy's interrupt handlers")]

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};
use embassy_stm32::interrupt::typelevel::{FDCAN1_IT0, Handler};
use embassy_stm32::pac::FDCAN1 as REGISTERS;
use softdock_app::can_queue::Fifo;

const FIFOS: usize = 2;

/// Fill level and next element of each FIFO when the interrupt began.
static BEGUN: [[AtomicU8; 2]; FIFOS] = [const { [const { AtomicU8::new(0) }; 2] }; FIFOS];
/// Frames taken out since boot; wraps.
static TAKEN: AtomicU32 = AtomicU32::new(0);

/// Frames taken out since boot.
pub(crate) fn frames_taken() -> u32 {
    TAKEN.load(Ordering::Relaxed)
}

/// To be called before the driver's handler.
pub(crate) struct Before;

impl Handler<FDCAN1_IT0> for Before {
    unsafe fn on_interrupt() {
        for (number, [fill, next]) in BEGUN.iter().enumerate() {
            let fifo = look(number);
            fill.store(fifo.fill, Ordering::Relaxed);
            next.store(fifo.next, Ordering::Relaxed);
        }
    }
}

/// To be called after the driver's handler.
pub(crate) struct Behind;

impl Handler<FDCAN1_IT0> for Behind {
    unsafe fn on_interrupt() {
        for (number, [fill, next]) in BEGUN.iter().enumerate() {
            let before = Fifo {
                fill: fill.load(Ordering::Relaxed),
                next: next.load(Ordering::Relaxed),
            };
            // Nothing else writes it.
            let taken = frames_taken().wrapping_add(before.frames_taken_until(look(number)));
            TAKEN.store(taken, Ordering::Relaxed);
        }
    }
}

/// RM0433, FDCAN_RXF0S and FDCAN_RXF1S.
fn look(number: usize) -> Fifo {
    let status = REGISTERS.rxfs(number).read();
    Fifo {
        fill: status.ffl(),
        next: status.fgi(),
    }
}
