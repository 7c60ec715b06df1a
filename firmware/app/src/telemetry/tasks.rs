//! The two tasks that bring the records to the recorder.

use super::datagram::Datagram;
use super::message::{Announcement, MessageError};
use super::queue::Slot;
use super::stream::{MessageParts, Stream};
use crate::board::{Clock, DatagramSink, IoError};
use core::net::SocketAddr;
use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_sync::zerocopy_channel::{Receiver, Sender};
use softdock_link::service::Machine;

/// Time between two announcements, µs: a recorder that is started later waits no longer for the
/// settings.
pub const ANNOUNCE_PERIOD_US: u64 = 1_000_000;

/// Encodes records into datagrams, and sends the announcement at once and every [`ANNOUNCE_PERIOD_US`], together with the state
/// of the board from `machine`. Runs until [`RecordQueue::close`](super::RecordQueue::close).
///
/// Between two waits it encodes a record: postcard's bytes and the checksum of 1.2 kB (estimated, not measured: less than 100 µs
/// at 480 MHz). So it belongs on an executor of a lower priority than the robot's.
pub async fn encode<M: RawMutex>(
    mut slots: Receiver<'_, M, Slot>,
    mut datagrams: Sender<'_, M, Datagram>,
    clock: &impl Clock,
    mut stream: Stream,
    announcement: &Announcement<'_>,
    machine: impl Fn() -> Machine,
) {
    let mut announce_at_us = clock.now_us();
    loop {
        if clock.now_us() >= announce_at_us {
            forward(stream.announcement(announcement), &mut datagrams).await;
            forward(stream.machine(&machine()), &mut datagrams).await;
            announce_at_us = clock.now_us().saturating_add(ANNOUNCE_PERIOD_US);
        }
        let due = clock.wait_until(announce_at_us);
        let Either::First(slot) = select(slots.receive(), due).await else {
            continue;
        };
        stream.set_lost(slot.lost);
        let Some(record) = &slot.record else {
            break;
        };
        let parts = stream.record(record);
        // The record is in the stream's buffer: its slot is free before its datagrams are sent.
        slots.receive_done();
        forward(parts, &mut datagrams).await;
    }
    forward(stream.announcement(announcement), &mut datagrams).await;
    datagrams.send().await.clear();
    datagrams.send_done();
}

/// Hands on the datagrams of a message. Waits for room.
async fn forward<M: RawMutex>(
    message: Result<MessageParts<'_>, MessageError>,
    datagrams: &mut Sender<'_, M, Datagram>,
) {
    // That every record fits is tested; an identity that is too long is not announced, and the
    // recorder says that the settings are missing.
    for part in message.into_iter().flatten() {
        part.write(datagrams.send().await);
        datagrams.send_done();
    }
}

/// Sends the datagrams to the recorder. Runs until the stream has ended or the socket is closed. Datagrams that a socket loses
/// show as a gap in the numbers.
pub async fn transmit<M: RawMutex>(
    mut datagrams: Receiver<'_, M, Datagram>,
    socket: &mut impl DatagramSink,
    recorder: SocketAddr,
) {
    loop {
        let datagram = datagrams.receive().await;
        if datagram.is_empty() {
            // The encoder has ended the stream.
            return;
        }
        let sent = socket.send(datagram, recorder).await;
        datagrams.receive_done();
        if sent == Err(IoError::Closed) {
            return;
        }
    }
}
