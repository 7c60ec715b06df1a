//! Frames between ethercrab and the Ethernet port.

use crate::board::{EthernetPort, IoError};
use core::future::poll_fn;
use core::task::{Context, Poll};
use ethercrab::error::Error;
use ethercrab::{PduRx, PduTx};
use softdock_link::ethercat::InFlight;

/// Longest frame, without its checksum.
const FRAME_BYTES: usize = 1514;
/// Most frames that are handled in one turn, so that a flood cannot keep the other tasks waiting forever.
const MOST_QUEUED: usize = 16;

/// Runs until the port is closed.
pub(super) async fn run(
    mut port: impl EthernetPort,
    mut transmitter: PduTx<'_>,
    mut receiver: PduRx<'_>,
) {
    let mut in_flight = InFlight::default();
    let mut buffer = [0; FRAME_BYTES];
    poll_fn(|context| {
        transmitter.replace_waker(context.waker());
        for turn in 0..=MOST_QUEUED {
            match port.poll_receive(context, &mut buffer) {
                Poll::Ready(Ok(length)) => {
                    let frame = buffer.get(..length).unwrap_or_default();
                    if in_flight.returned(frame) {
                        // A frame that it refuses has come too late.
                        let _ = receiver.receive_frame(frame);
                    }
                }
                Poll::Ready(Err(IoError::Closed)) => return Poll::Ready(()),
                Poll::Ready(Err(IoError::Lost | IoError::BusOff)) => {}
                Poll::Pending => break,
            }
            if turn == MOST_QUEUED {
                context.waker().wake_by_ref();
            }
        }
        send(&mut transmitter, &mut port, &mut in_flight, context);
        Poll::Pending
    })
    .await;
}

/// Hands over frames to be sent; those without room stay, and the port wakes the task.
fn send(
    transmitter: &mut PduTx<'_>,
    port: &mut impl EthernetPort,
    in_flight: &mut InFlight,
    context: &mut Context<'_>,
) {
    while let Some(frame) = transmitter.next_sendable_frame() {
        let sent = frame.send_blocking(|bytes| match port.poll_send(context, bytes) {
            Poll::Ready(()) => {
                in_flight.record_sent(bytes);
                Ok(bytes.len())
            }
            Poll::Pending => Err(Error::SendFrame),
        });
        if sent.is_err() {
            break;
        }
    }
}
