//! The loop-back test of a CAN controller: frames of all lengths, each of which has to come back.

use crate::board::{Clock, IoError, SensorBus};
use embassy_futures::select::{Either, select};
use softdock_link::can::{Frame, Id};
use softdock_link::service::LoopBack;

/// Longest time for a frame, µs: on the bus it would take 0.13 ms.
const PATIENCE_US: u64 = 2_000;
/// Most frames and losses that may precede the expected frame: no board's queue is longer.
const BEFORE: usize = 64;

/// Sends frames of 0 to 8 bytes, with identifiers of 11 and of 29 bits alternately, through a controller whose output is its
/// input.
pub async fn loop_back(bus: &mut impl SensorBus<Frame = Frame>, clock: &impl Clock) -> LoopBack {
    let mut outcome = LoopBack::default();
    for length in 0..=Frame::MAX_BYTES {
        let Some(frame) = frame(length) else { continue };
        outcome.sent += 1;
        let too_late = clock.wait_until(clock.now_us() + PATIENCE_US);
        if let Either::First(true) = select(comes_back(bus, &frame), too_late).await {
            outcome.back += 1;
        }
    }
    outcome
}

/// Whether a frame comes back unchanged; others were already on their way.
async fn comes_back(bus: &mut impl SensorBus<Frame = Frame>, frame: &Frame) -> bool {
    if bus.send(frame).await.is_err() {
        return false;
    }
    for _ in 0..BEFORE {
        match bus.receive().await {
            Ok(received) if received == *frame => return true,
            Ok(_) | Err(IoError::Lost) => {}
            Err(_) => return false,
        }
    }
    false
}

/// A frame of this length in which neighbouring bits differ.
fn frame(length: usize) -> Option<Frame> {
    const BITS: [u8; Frame::MAX_BYTES] = [0x55, 0xaa, 0x33, 0xcc, 0x0f, 0xf0, 0x00, 0xff];
    let id = match length % 2 {
        0 => Id::Standard(0x555),
        _ => Id::Extended(0x1555_5555),
    };
    Frame::new(id, BITS.get(..length)?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::cell::Cell;
    use core::future::pending;
    use embassy_futures::block_on;
    use std::collections::VecDeque;

    /// A controller whose frames come back as changed by `spoil`, after a loss and a frame of the sensor.
    struct Controller<F> {
        frames: VecDeque<Result<Frame, IoError>>,
        spoil: F,
    }

    impl<F: FnMut(Frame) -> Option<Result<Frame, IoError>>> SensorBus for Controller<F> {
        type Frame = Frame;

        async fn send(&mut self, frame: &Frame) -> Result<(), IoError> {
            let sensors = Frame::new(Id::Standard(0x200), &[1, 2]).unwrap();
            self.frames.extend([Err(IoError::Lost), Ok(sensors)]);
            self.frames.extend((self.spoil)(*frame));
            Ok(())
        }

        async fn receive(&mut self) -> Result<Frame, IoError> {
            match self.frames.pop_front() {
                Some(frame) => frame,
                None => pending().await,
            }
        }

        async fn recover(&mut self) -> Result<(), IoError> {
            Ok(())
        }
    }

    /// Time that passes as soon as somebody waits for it.
    struct Quick(Cell<u64>);

    impl Clock for Quick {
        fn now_us(&self) -> u64 {
            self.0.get()
        }

        async fn wait_until(&self, at_us: u64) {
            self.0.set(at_us);
        }
    }

    fn back(spoil: impl FnMut(Frame) -> Option<Result<Frame, IoError>>) -> (u8, u64) {
        let mut controller = Controller {
            frames: VecDeque::new(),
            spoil,
        };
        let clock = Quick(Cell::new(0));
        let outcome = block_on(loop_back(&mut controller, &clock));
        assert_eq!(outcome.sent, 9);
        (outcome.back, clock.now_us())
    }

    #[test]
    fn a_controller_that_hears_itself_gets_all_of_them_back() {
        let mut lengths = Vec::new();
        let all = back(|frame| {
            lengths.push(frame.data().len());
            Some(Ok(frame))
        });
        assert_eq!(all, (9, 0));
        assert_eq!(lengths, [0, 1, 2, 3, 4, 5, 6, 7, 8]);
    }

    #[test]
    fn what_is_lost_changed_or_an_error_does_not_count_and_ends() {
        let (lost, at_us) = back(|_| None);
        assert_eq!((lost, at_us), (0, 9 * PATIENCE_US));
        assert_eq!(back(|_| Some(Err(IoError::BusOff))).0, 0);
        // Without the last bytes, the extended identifiers.
        let shortened = back(|frame| {
            let kept = frame.data().len().min(6);
            Some(Ok(Frame::new(frame.id(), &frame.data()[..kept]).unwrap()))
        });
        assert_eq!(shortened.0, 7);
        let standard = back(|frame| matches!(frame.id(), Id::Standard(_)).then_some(Ok(frame)));
        assert_eq!(standard.0, 5);
    }
}
