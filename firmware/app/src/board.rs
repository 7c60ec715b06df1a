//! Interfaces that a board provides to the tasks.

use crate::record::CycleRecord;
use core::net::SocketAddr;
use core::task::{Context, Poll};
use softdock_link::service::LoopBack;

/// Why a bus or socket returned nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IoError {
    /// It is gone for good; the task ends.
    Closed,
    /// The sensor's bus went off; see [`SensorBus::recover`].
    BusOff,
    /// Something was lost on the way; the task goes on.
    Lost,
}

/// The wire to the sensor: a CAN bus, or an EtherCAT segment.
#[allow(
    async_fn_in_trait,
    reason = "one executor, one thread: no Send is needed"
)]
pub trait SensorBus {
    /// What travels on it.
    type Frame;
    /// Hands a frame to the controller. Waits only for room in the transmit queue. Cancel-safe: a
    /// dropped future has handed over the whole frame or nothing.
    async fn send(&mut self, frame: &Self::Frame) -> Result<(), IoError>;
    /// The next received frame. Cancel-safe: a dropped future loses no frame.
    async fn receive(&mut self) -> Result<Self::Frame, IoError>;
    /// Brings the bus back after it went off: a CAN controller from bus-off.
    async fn recover(&mut self) -> Result<(), IoError>;
    /// Tests a CAN controller in internal loop-back with the frames of [`loop_back`](crate::loop_back), then returns to the bus;
    /// `None` without such a controller.
    async fn loop_back(&mut self) -> Option<LoopBack> {
        None
    }
}

/// An Ethernet port that carries whole frames, without checksum: that of an EtherCAT segment.
pub trait EthernetPort {
    /// The length of the next received frame in `buffer`. `Pending`: the task is woken when one comes.
    fn poll_receive(
        &mut self,
        context: &mut Context<'_>,
        buffer: &mut [u8],
    ) -> Poll<Result<usize, IoError>>;
    /// Takes a frame to be sent. `Pending`: it was not taken, and the task is woken when there is room.
    fn poll_send(&mut self, context: &mut Context<'_>, frame: &[u8]) -> Poll<()>;
}

/// A UDP socket on the robot's network.
#[allow(
    async_fn_in_trait,
    reason = "one executor, one thread: no Send is needed"
)]
pub trait DatagramSocket {
    /// The next datagram: its length in `buffer` and its sender. A longer datagram is cut off or lost.
    /// Cancel-safe: a dropped future loses no datagram.
    async fn receive(&mut self, buffer: &mut [u8]) -> Result<(usize, SocketAddr), IoError>;
    /// A further datagram if one is queued already; never waits.
    fn try_receive(&mut self, buffer: &mut [u8]) -> Option<(usize, SocketAddr)>;
    /// When the newest datagram of `sender` left the network controller, µs by the board's clock; it may have waited since.
    /// `None` if that is not known.
    fn came_us(&self, _sender: SocketAddr) -> Option<u64> {
        None
    }
    /// Sends a datagram. Waits only for room in the transmit queue.
    async fn send(&mut self, datagram: &[u8], to: SocketAddr) -> Result<(), IoError>;
}

/// A UDP socket that only sends.
#[allow(
    async_fn_in_trait,
    reason = "one executor, one thread: no Send is needed"
)]
pub trait DatagramSink {
    /// Sends a datagram. Waits only for room in the transmit queue.
    async fn send(&mut self, datagram: &[u8], to: SocketAddr) -> Result<(), IoError>;
}

impl<T: DatagramSocket> DatagramSink for T {
    async fn send(&mut self, datagram: &[u8], to: SocketAddr) -> Result<(), IoError> {
        DatagramSocket::send(self, datagram, to).await
    }
}

/// Monotonic time since boot.
#[allow(
    async_fn_in_trait,
    reason = "one executor, one thread: no Send is needed"
)]
pub trait Clock {
    /// Now, µs.
    fn now_us(&self) -> u64;
    /// Processor cycles while awake, wrapping; `None` without such a counter.
    fn processor_cycles(&self) -> Option<u32> {
        None
    }
    /// Returns at `at_us` or soon after; never for `u64::MAX`. Cancel-safe.
    async fn wait_until(&self, at_us: u64);
}

/// Takes the record of each cycle. Never blocks: a record without room is dropped and counted by the implementation.
pub trait Recorder {
    /// Takes one record.
    fn record(&mut self, record: &CycleRecord);
}

/// Keeps nothing if there is no recorder.
impl<R: Recorder> Recorder for Option<R> {
    fn record(&mut self, record: &CycleRecord) {
        if let Some(recorder) = self {
            recorder.record(record);
        }
    }
}

/// Keeps nothing.
impl Recorder for () {
    fn record(&mut self, _record: &CycleRecord) {}
}

#[cfg(test)]
pub(crate) mod tests {
    use super::Clock;
    use core::cell::Cell;

    /// Time that passes as soon as somebody waits for it, until it stands still.
    pub(crate) struct Stopwatch {
        now_us: Cell<u64>,
        end_us: u64,
    }

    impl Stopwatch {
        /// From 0 to this.
        pub(crate) fn until(end_us: u64) -> Self {
            let now_us = Cell::new(0);
            Self { now_us, end_us }
        }
    }

    impl Clock for Stopwatch {
        fn now_us(&self) -> u64 {
            self.now_us.get()
        }

        async fn wait_until(&self, at_us: u64) {
            if at_us > self.end_us {
                return core::future::pending().await;
            }
            self.now_us.set(at_us.max(self.now_us()));
        }
    }
}
