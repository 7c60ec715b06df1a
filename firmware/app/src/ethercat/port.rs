//! The Ethernet port of a microcontroller, over `embassy-net-driver`.

use crate::board::{EthernetPort, IoError};
use core::task::{Context, Poll};
use embassy_net::driver::{Driver, RxToken, TxToken};

/// A driver that carries nothing but EtherCAT.
pub struct DriverPort<D>(pub D);

impl<D: Driver> EthernetPort for DriverPort<D> {
    fn poll_receive(
        &mut self,
        context: &mut Context<'_>,
        buffer: &mut [u8],
    ) -> Poll<Result<usize, IoError>> {
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
