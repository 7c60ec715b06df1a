//! The Ethernet port of a microcontroller, over `embassy-net-driver`.

use crate::board::{EthernetPort, IoError};
use core::task::{Context, Poll};
use embassy_net_driver::{Driver, RxToken, TxToken};

/// A driver that carries nothing but EtherCAT.
pub struct DriverPort<D>(pub D);

impl<D: Driver> EthernetPort for DriverPort<D> {
    fn poll_receive(
        &mut self,
        context: &mut Context<'_>,
        buffer: &mut [u8],
    ) -> Poll<Result<usize, IoError>> {
        // No network stack polls this link, and the PHY is configured when its link is polled.
        self.0.link_state(context);
        let Some((frame, _)) = self.0.receive(context) else {
            return Poll::Pending;
        };
        Poll::Ready(frame.consume(|bytes| {
            let room = buffer.get_mut(..bytes.len()).ok_or(IoError::Lost)?;
            room.copy_from_slice(bytes);
            Ok(bytes.len())
        }))
    }

    fn poll_send(&mut self, context: &mut Context<'_>, frame: &[u8]) -> Poll<()> {
        let Some(room) = self.0.transmit(context) else {
            return Poll::Pending;
        };
        room.consume(frame.len(), |bytes| bytes.copy_from_slice(frame));
        Poll::Ready(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::task::Waker;
    use embassy_net_driver::{Capabilities, HardwareAddress, LinkState};

    /// A controller without a frame.
    #[derive(Default)]
    struct Silent {
        looks: usize,
    }

    struct Nothing;

    impl RxToken for Nothing {
        fn consume<R, F: FnOnce(&mut [u8]) -> R>(self, read: F) -> R {
            read(&mut [])
        }
    }

    impl TxToken for Nothing {
        fn consume<R, F: FnOnce(&mut [u8]) -> R>(self, _: usize, write: F) -> R {
            write(&mut [])
        }
    }

    impl Driver for Silent {
        type RxToken<'a> = Nothing;
        type TxToken<'a> = Nothing;

        fn receive(&mut self, _: &mut Context<'_>) -> Option<(Nothing, Nothing)> {
            None
        }

        fn transmit(&mut self, _: &mut Context<'_>) -> Option<Nothing> {
            None
        }

        fn link_state(&mut self, _: &mut Context<'_>) -> LinkState {
            self.looks += 1;
            LinkState::Down
        }

        fn capabilities(&self) -> Capabilities {
            Capabilities::default()
        }

        fn hardware_address(&self) -> HardwareAddress {
            HardwareAddress::Ethernet([2, 0, 0, 0, 0, 1])
        }
    }

    #[test]
    fn who_waits_for_a_frame_looks_after_the_link() {
        let mut port = DriverPort(Silent::default());
        let context = &mut Context::from_waker(Waker::noop());
        for looks in 1..4 {
            assert!(port.poll_receive(context, &mut [0; 64]).is_pending());
            assert_eq!(port.0.looks, looks);
        }
    }
}
