//! Display of a running board: its telemetry, as `softdock record` gets it. Nothing is sent to the board; arming, starting
//! and jogging are left to the terminal and the serial line.
//!
//! A thread receives the datagrams and makes frames of them, about 25 per second. A page that is too slow misses frames, and
//! is told how many; the board never waits.

use anyhow::Result;
use serde::Serialize;
use serde_json::{Value, json};
use softdock_app::record::CycleRecord;
use softdock_io::telemetry::{BoardMessage, Listener, Viewer};
use softdock_link::service::Machine;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use tokio::sync::broadcast::{self, Receiver, Sender};

/// Time from one frame to the next: it looks smooth.
const FRAME: Duration = Duration::from_millis(40);
/// Number of frames that a slow page may be behind: two seconds.
const BEHIND: usize = 50;
/// Largest number of cycles in a frame: cycles that come at once after a pause are not all drawn.
const MOST_CYCLES: usize = 500;

/// Telemetry of a board, if it is listened to.
pub(super) struct Live {
    frames: Sender<Arc<Value>>,
    watch: Mutex<Option<Watch>>,
}

impl Default for Live {
    fn default() -> Self {
        Self {
            frames: broadcast::Sender::new(BEHIND),
            watch: Mutex::default(),
        }
    }
}

/// A listening thread. Dropping it ends the thread and frees the port.
struct Watch {
    address: SocketAddr,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Live {
    fn watch(&self) -> MutexGuard<'_, Option<Watch>> {
        self.watch.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Listens on an address, in place of a previous one. Returns the actual address.
    ///
    /// # Errors
    ///
    /// The address is not one of this computer, or its port is taken.
    pub(super) fn start(&self, listen: SocketAddr) -> Result<SocketAddr> {
        let mut watch = self.watch();
        // Ends a previous thread, so that the same port is free again.
        *watch = None;
        let listener = Listener::bind(listen)?;
        let address = listener.address();
        let stop = Arc::new(AtomicBool::new(false));
        let (frames, raised) = (self.frames.clone(), stop.clone());
        let thread = thread::spawn(move || listen_to(&listener, &frames, &raised));
        *watch = Some(Watch {
            address,
            stop,
            thread: Some(thread),
        });
        Ok(address)
    }

    /// Ends listening.
    pub(super) fn stop(&self) {
        *self.watch() = None;
    }

    /// A receiver of all frames from now on.
    pub(super) fn frames(&self) -> Receiver<Arc<Value>> {
        self.frames.subscribe()
    }

    /// The address that is listened on; None if none is.
    pub(super) fn address(&self) -> Option<SocketAddr> {
        self.watch().as_ref().map(|watch| watch.address)
    }
}

/// Data of the cycles since the last frame, and the state of the board.
#[derive(Default, Serialize)]
struct Frame {
    time_s: Vec<f64>,
    /// Compensated contact force at M, N.
    force_n: Vec<[f64; 3]>,
    /// Executed velocity of M, m/s.
    velocity_m_s: Vec<[f64; 3]>,
    cycle: u64,
    mode: Option<String>,
    fault: Option<String>,
    refusal: Option<String>,
    sensor_age: u32,
    late_answers: u32,
    firmware: Option<String>,
    /// Histogram of answer times in sixteenths of a cycle, and the last and longest time, µs.
    answers: Option<Answers>,
    /// Records lost on the board, lost by the network, and unreadable.
    losses: [u64; 3],
    /// Time since the last cycle came, s.
    silent_s: f64,
}

#[derive(Clone, Serialize)]
struct Answers {
    histogram: Vec<u32>,
    last_us: u32,
    longest_us: u32,
}

impl Frame {
    fn see(&mut self, seen: BoardMessage) {
        match seen {
            BoardMessage::Firmware(identity) => self.firmware = Some(identity),
            BoardMessage::Cycle(cycle) => self.cycle(&cycle),
            BoardMessage::Machine(machine) => self.answers = Some(Answers::of(&machine)),
        }
    }

    fn cycle(&mut self, record: &CycleRecord) {
        let trace = &record.trace;
        if self.time_s.len() < MOST_CYCLES {
            let three = |six: &[f64; 6]| [six[0], six[1], six[2]];
            self.time_s.push(trace.time_s);
            self.force_n.push(three(&trace.wrench_at_m));
            self.velocity_m_s.push(three(&trace.executed_velocity));
        }
        self.cycle = trace.cycle;
        self.mode = Some(format!("{:?}", trace.mode));
        self.fault = trace.fault.map(|fault| {
            let (limit, received) = (fault.expected, fault.received);
            format!("{} (limit {limit}, received {received})", fault.code)
        });
        if let Some(refusal) = &trace.refusal {
            self.refusal = Some(refusal.to_string());
        }
        self.sensor_age = trace.sensor_age;
        self.late_answers = record.inputs.robot.late_answers;
    }

    /// The beginning of the next frame: the state without the cycles that were sent.
    fn next(self) -> Self {
        Self {
            time_s: Vec::new(),
            force_n: Vec::new(),
            velocity_m_s: Vec::new(),
            ..self
        }
    }
}

impl Answers {
    fn of(machine: &Machine) -> Self {
        Self {
            histogram: machine.answers.histogram.to_vec(),
            last_us: machine.answers.last_us,
            longest_us: machine.answers.longest_us,
        }
    }
}

fn listen_to(listener: &Listener, frames: &Sender<Arc<Value>>, stop: &AtomicBool) {
    let mut viewer = Viewer::default();
    let mut frame = Frame::default();
    let mut heard = Instant::now();
    while !stop.load(Ordering::Relaxed) {
        let until = Instant::now() + FRAME;
        while let Some(left) = until.checked_duration_since(Instant::now()) {
            match listener.receive(left) {
                Some((datagram, _)) => viewer.accept(&datagram, &mut |seen| frame.see(seen)),
                None => viewer.give_up_missing(&mut |seen| frame.see(seen)),
            }
        }
        if !frame.time_s.is_empty() {
            heard = Instant::now();
        }
        frame.losses = viewer.losses();
        frame.silent_s = heard.elapsed().as_secs_f64();
        // An error only means that no page is connected.
        let _ = frames.send(Arc::new(json!(frame)));
        frame = frame.next();
    }
}
