//! The board's telemetry: the firmware's two tasks in a thread of their own.

use super::Shared;
use super::clock::RealClock;
use crate::board::block_on::block_on;
use anyhow::{Context, Result};
use embassy_futures::join::join;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::zerocopy_channel::{Channel, Receiver};
use softdock_app::board::{DatagramSink, IoError};
use softdock_app::image::{IMAGE_MAX_BYTES, Image};
use softdock_app::settings::BoardSettings;
use softdock_app::telemetry::{
    Announcement, Datagram, RecordQueue, Slot, Stream, encode, transmit,
};
use softdock_io::identity;
use softdock_io::say;
use std::hash::{BuildHasher, Hasher, RandomState};
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::sync::Arc;
use std::thread::{self, JoinHandle};

/// Records that may wait: 4 s of cycles, for a computer that has other things to do.
const SLOTS: usize = 1000;
/// Datagrams between the tasks.
const DATAGRAMS: usize = 16;

/// The robot task's end of the telemetry.
pub(super) type Queue = RecordQueue<'static, CriticalSectionRawMutex>;
type Slots = Receiver<'static, CriticalSectionRawMutex, Slot>;

/// Telemetry that is ready to start.
#[derive(Debug)]
pub(super) struct Telemetry {
    sink: Sink,
    recorder: SocketAddr,
    /// Image of the settings, which is announced to the recorder.
    image: Vec<u8>,
}

impl Telemetry {
    /// Telemetry to a recorder.
    pub(super) fn new(settings: &BoardSettings, recorder: SocketAddr) -> Result<Self> {
        let any: SocketAddr = match recorder {
            SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
            SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
        };
        let socket = UdpSocket::bind(any)
            .with_context(|| format!("no UDP port is free for the telemetry to {recorder}"))?;
        let mut image = vec![0; IMAGE_MAX_BYTES];
        let settings = settings.clone();
        let length = Image {
            sequence: 0,
            settings,
        }
        .encode(&mut image)?;
        image.truncate(length);
        say!("board: telemetry to UDP {recorder}");
        Ok(Self {
            sink: Sink(socket),
            recorder,
            image,
        })
    }

    /// Starts the thread. It ends when the queue is closed.
    pub(super) fn start(self, clock: RealClock, shared: Arc<Shared>) -> (Queue, JoinHandle<()>) {
        // Like all that a board's tasks share, the slots live as long as the process.
        let slots = vec![Slot::default(); SLOTS].leak();
        let (records, taken) = Box::leak(Box::new(Channel::new(slots))).split();
        let thread = thread::spawn(move || block_on(run(self, taken, &clock, &shared)));
        (RecordQueue::new(records), thread)
    }
}

async fn run(telemetry: Telemetry, slots: Slots, clock: &RealClock, shared: &Shared) {
    let Telemetry {
        mut sink,
        recorder,
        image,
    } = telemetry;
    let identity = identity::text();
    let announcement = Announcement {
        image: &image,
        identity: &identity,
    };
    let mut buffers = vec![Datagram::new(); DATAGRAMS];
    let mut datagrams = Channel::<CriticalSectionRawMutex, _>::new(&mut buffers);
    let (made, waiting) = datagrams.split();
    let (stream, machine) = (Stream::new(boot()), || shared.machine().to_machine());
    join(
        encode(slots, made, clock, stream, &announcement, machine),
        transmit(waiting, &mut sink, recorder),
    )
    .await;
}

/// A number that no other boot has: the keys of a hash map are drawn at random.
fn boot() -> u32 {
    RandomState::new().build_hasher().finish() as u32
}

/// A socket that blocks this thread only.
#[derive(Debug)]
struct Sink(UdpSocket);

impl DatagramSink for Sink {
    async fn send(&mut self, datagram: &[u8], to: SocketAddr) -> Result<(), IoError> {
        self.0
            .send_to(datagram, to)
            .map(|_| ())
            .map_err(|_| IoError::Lost)
    }
}
