//! Telemetry of a microcontroller: its memory, its socket, and its two tasks.

use super::SHARED;
use super::clock::UptimeClock;
use super::identity::Identity;
use super::udp;
use crate::board::{DatagramSink, IoError};
use crate::image::{IMAGE_MAX_BYTES, Image};
use crate::service::IDENTITY_BYTES;
use crate::settings::BoardSettings;
use crate::telemetry::{
    Announcement, DATAGRAM_MAX_BYTES, Datagram, RecordQueue, Slot, Stream, encode, transmit,
};
use core::fmt::Write;
use core::net::{SocketAddr, SocketAddrV4};
use embassy_net::Stack;
use embassy_net::udp::{PacketMetadata, UdpSocket};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::zerocopy_channel::{Channel, Receiver, Sender};
use static_cell::StaticCell;

/// Records that may wait for the encoder: 24 ms of cycles.
const SLOTS: usize = 6;
/// Datagrams that may wait for the network's stack, and in it.
const DATAGRAMS: usize = 2;

/// The robot task's end of the telemetry.
pub type Queue = RecordQueue<'static, CriticalSectionRawMutex>;

/// State of [`encoder_task`].
#[derive(Debug)]
pub(super) struct Encoder {
    slots: Receiver<'static, CriticalSectionRawMutex, Slot>,
    datagrams: Sender<'static, CriticalSectionRawMutex, Datagram>,
    boot: u32,
    image: &'static [u8],
    identity: heapless::String<IDENTITY_BYTES>,
}

/// State of [`transmitter_task`].
pub(super) struct Transmitter {
    datagrams: Receiver<'static, CriticalSectionRawMutex, Datagram>,
    socket: Socket,
    recorder: SocketAddr,
}

/// Prepares everything; `None` if called more than once, or if the settings may not be used. `port` is the board's own.
pub(super) fn prepare(
    stack: Stack<'static>,
    port: u16,
    recorder: SocketAddrV4,
    settings: &BoardSettings,
    (identity, boot): (&Identity, u32),
) -> Option<(Queue, Encoder, Transmitter)> {
    static SLOT_MEMORY: StaticCell<[Slot; SLOTS]> = StaticCell::new();
    static RECORDS: StaticCell<Channel<'static, CriticalSectionRawMutex, Slot>> = StaticCell::new();
    static DATAGRAM_MEMORY: StaticCell<[Datagram; DATAGRAMS]> = StaticCell::new();
    static MADE: StaticCell<Channel<'static, CriticalSectionRawMutex, Datagram>> =
        StaticCell::new();
    static IMAGE: StaticCell<[u8; IMAGE_MAX_BYTES]> = StaticCell::new();

    let slots = SLOT_MEMORY.try_init_with(|| [Slot::default(); SLOTS])?;
    let (records, taken) = RECORDS.init_with(|| Channel::new(slots)).split();
    let datagrams = DATAGRAM_MEMORY.init_with(|| core::array::from_fn(|_| Datagram::new()));
    let (made, waiting) = MADE.init_with(|| Channel::new(datagrams)).split();
    let image = IMAGE.init_with(|| [0; IMAGE_MAX_BYTES]);
    let settings = settings.clone();
    let sequence = 0;
    let length = Image { sequence, settings }.encode(image).ok()?;
    let mut text = heapless::String::new();
    // A longer one is cut off.
    let _ = write!(text, "{identity}");
    let encoder = Encoder {
        slots: taken,
        datagrams: made,
        boot,
        image: image.get(..length)?,
        identity: text,
    };
    let transmitter = Transmitter {
        datagrams: waiting,
        socket: Socket::bind(stack, port)?,
        recorder: recorder.into(),
    };
    Some((RecordQueue::new(records), encoder, transmitter))
}

/// Encodes records into datagrams forever; for the executor of background tasks.
#[embassy_executor::task]
pub(super) async fn encoder_task(encoder: Encoder) {
    let announcement = Announcement {
        image: encoder.image,
        identity: &encoder.identity,
    };
    let stream = Stream::new(encoder.boot);
    let (slots, datagrams) = (encoder.slots, encoder.datagrams);
    let machine = || SHARED.machine().to_machine();
    encode(
        slots,
        datagrams,
        &UptimeClock,
        stream,
        &announcement,
        machine,
    )
    .await;
}

/// Sends datagrams for ever; for the executor of the network.
#[embassy_executor::task]
pub(super) async fn transmitter_task(mut transmitter: Transmitter) {
    let socket = &mut transmitter.socket;
    transmit(transmitter.datagrams, socket, transmitter.recorder).await;
}

/// A socket that only sends.
struct Socket(UdpSocket<'static>);

impl Socket {
    fn bind(stack: Stack<'static>, port: u16) -> Option<Self> {
        static FROM: StaticCell<[PacketMetadata; 1]> = StaticCell::new();
        static RECEIVED: StaticCell<[u8; 1]> = StaticCell::new();
        static TO: StaticCell<[PacketMetadata; DATAGRAMS]> = StaticCell::new();
        static SENT: StaticCell<[u8; DATAGRAMS * DATAGRAM_MAX_BYTES]> = StaticCell::new();
        let mut socket = UdpSocket::new(
            stack,
            FROM.init_with(|| [PacketMetadata::EMPTY]),
            RECEIVED.init_with(|| [0]),
            TO.init_with(|| [PacketMetadata::EMPTY; DATAGRAMS]),
            SENT.init_with(|| [0; DATAGRAMS * DATAGRAM_MAX_BYTES]),
        );
        socket.bind(port).ok()?;
        Some(Self(socket))
    }
}

impl DatagramSink for Socket {
    async fn send(&mut self, datagram: &[u8], to: SocketAddr) -> Result<(), IoError> {
        udp::send(&self.0, datagram, to).await
    }
}
