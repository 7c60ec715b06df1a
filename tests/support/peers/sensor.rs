//! A force sensor behind SLCAN that answers at once, stops answering, or adds noise to the line.

use softdock_link::can::Frame;
use softdock_link::can::ati::{AtiCalibration, AtiDevice, ForceUnit, TorqueUnit};
use softdock_link::slcan::AdapterLines;
use softdock_rig::peer::slcan::{frames, send};
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// Gauge counts per N and per N·m; the gauges are the axes.
const COUNTS_PER_UNIT: f64 = 100.0;
/// Interval of the checks whether the thread should end.
const POLL_INTERVAL: Duration = Duration::from_millis(20);
/// Sequence with which python-can opens the channel, with its empty line and its second `O`.
const OPEN: &[u8] = b"C\rS8\r\rO\rO\r";
/// Noise of a bad cable: complete lines, and one byte too many before a frame.
const NOISE: &[u8] =
    b"\x00\xfft2\rt99999999\r\x07garbage that is longer than any line of SLCAN may be\r";

/// Data shared by the test and the sensor's thread.
#[derive(Debug, Default)]
struct State {
    ended: AtomicBool,
    silent: AtomicBool,
    noisy: AtomicBool,
    readings: AtomicU64,
}

/// The sensor's thread; it ends on drop.
#[derive(Debug)]
pub struct Sensor {
    state: Arc<State>,
    thread: Option<JoinHandle<()>>,
}

impl Sensor {
    /// Connects to a board and opens the channel.
    ///
    /// # Panics
    /// If the board does not listen.
    pub fn connect(can: SocketAddr) -> Self {
        let mut stream = TcpStream::connect(can).expect("the board listens for its sensor");
        stream
            .set_nodelay(true)
            .expect("small packets can be sent at once");
        stream
            .set_read_timeout(Some(POLL_INTERVAL))
            .expect("a timeout can be set");
        stream.write_all(OPEN).expect("the board reads");
        let state = Arc::new(State::default());
        let shared = state.clone();
        let thread = thread::spawn(move || Device::new(stream).serve(&shared));
        Self {
            state,
            thread: Some(thread),
        }
    }

    /// Stops answering, or answers again.
    pub fn be_silent(&self, silent: bool) {
        self.state.silent.store(silent, Ordering::Relaxed);
    }

    /// Adds noise between its answers and damages some of them, or stops doing so.
    pub fn be_noisy(&self, noisy: bool) {
        self.state.noisy.store(noisy, Ordering::Relaxed);
    }

    /// Number of readings so far.
    pub fn readings(&self) -> u64 {
        self.state.readings.load(Ordering::Relaxed)
    }
}

impl Drop for Sensor {
    fn drop(&mut self) {
        self.state.ended.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

struct Device {
    stream: TcpStream,
    device: AtiDevice,
}

impl Device {
    fn new(stream: TcpStream) -> Self {
        let mut matrix = [[0.0; 6]; 6];
        for (axis, row) in matrix.iter_mut().enumerate() {
            row[axis] = 1.0;
        }
        let (counts_per_force, counts_per_torque) = (COUNTS_PER_UNIT, COUNTS_PER_UNIT);
        let calibration = AtiCalibration {
            matrix,
            counts_per_force,
            counts_per_torque,
        };
        let device = AtiDevice::new(
            0x20,
            &calibration,
            ForceUnit::Newton,
            TorqueUnit::NewtonMetre,
        );
        Self {
            stream,
            device: device.expect("a valid sensor"),
        }
    }

    /// Answers until the test or the board ends.
    fn serve(mut self, state: &State) {
        let mut lines = AdapterLines::default();
        let mut buffer = [0; 512];
        while !state.ended.load(Ordering::Relaxed) {
            let length = match self.stream.read(&mut buffer) {
                Ok(0) => return,
                Ok(length) => length,
                Err(error)
                    if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) =>
                {
                    continue;
                }
                Err(_) => return,
            };
            for request in frames(&mut lines, &buffer[..length]) {
                if !state.silent.load(Ordering::Relaxed) && self.answer(&request, state).is_err() {
                    return;
                }
            }
        }
    }

    fn answer(&mut self, request: &Frame, state: &State) -> std::io::Result<()> {
        // Gauge 0 flickers by one count, as in every real converter.
        let reading = state.readings.fetch_add(1, Ordering::Relaxed);
        let gauges = [i16::from(reading.is_multiple_of(2)), 0, 0, 0, 0, 0];
        let noisy = state.noisy.load(Ordering::Relaxed);
        let mut out = Vec::new();
        for frame in self.device.answer(request, gauges, 0) {
            if noisy {
                out.extend_from_slice(NOISE);
                // This line has no end of its own, so the next frame becomes part of it and is lost.
                out.extend_from_slice(if reading.is_multiple_of(20) {
                    b"#"
                } else {
                    b""
                });
            }
            send(&mut out, [frame])?;
        }
        self.stream.write_all(&out)
    }
}
