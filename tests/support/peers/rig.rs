//! A simulated rig behind real sockets: RSI over UDP, the sensor behind SLCAN over TCP or on EtherCAT over UDP.
//!
//! Robot and sensor share the rig's own time, which stands still until the board has answered. A
//! telegram is sent only after the board has taken a reading of that instant. So the board's
//! corrections depend on nothing but its arithmetic: two boards that compute the same send the same,
//! however slow or busy the computer is.

use crate::process::PATIENCE;
use softdock::experiment::scenario::Scenario;
use softdock_app::settings::BoardSettings;
use softdock_link::can::ati::{AtiCalibration, AtiDevice, ForceUnit, TorqueUnit};
use softdock_link::ethercat::Product;
use softdock_link::rsi::{RobTelegram, SenTelegram, Tags, parse_sen, write_rob};
use softdock_link::slcan::{MAX_LINE_BYTES, encode_frame_line, parse_frame_line};
use softdock_rig::ethercat::wire::{exchanges, plug};
use softdock_rig::ethercat::{Description, Measurement, Segment, SubDevice};
use softdock_rig::rig::{Rig, RobotReport};
use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// The first time stamp, ms.
const FIRST_IPOC: u64 = 1_000_000;
/// Decimals of the telegrams.
const DECIMALS: u8 = 6;
/// Time after which a telegram counts as missed by a board that starts over.
const MISSED: Duration = Duration::from_secs(1);
/// How often waits look again.
const POLL_INTERVAL: Duration = Duration::from_millis(20);
/// Requests of the sensor's data after which a reading has certainly been taken: the first is
/// answered with it, the second comes after it.
const REQUESTS: u32 = 2;
/// Open sequence of SLCAN.
const OPEN: &[u8] = b"C\rS8\rO\r";

/// What the board sent, per cycle: X Y Z (units of the last decimal of mm), A B C (of degrees).
pub type Motion = Vec<[i64; 6]>;

/// What the sensor shows, and how often it was asked since.
#[derive(Debug, Default)]
struct Shown {
    counts: [i16; 6],
    status: u16,
    requests: u32,
    ended: bool,
}

#[derive(Debug, Default)]
struct SharedShown {
    shown: Mutex<Shown>,
    changed: Condvar,
    /// Likewise, for who waits for nothing else.
    unplugged: AtomicBool,
}

impl SharedShown {
    fn lock(&self) -> MutexGuard<'_, Shown> {
        self.shown.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The rig, connected to a board.
pub struct LockStepRig {
    rig: Rig,
    tags: Tags,
    cycle_ms: u64,
    socket: UdpSocket,
    shown: Arc<SharedShown>,
    sensor: Option<JoinHandle<()>>,
    ipoc: u64,
}

impl LockStepRig {
    /// Connects the rig of a scenario to a board with `settings`. Its sensor starts at once, its
    /// robot with [`Self::run`].
    ///
    /// # Panics
    /// If the board does not listen.
    pub fn connect(
        scenario: &Scenario,
        settings: &BoardSettings,
        robot: SocketAddr,
        can: SocketAddr,
    ) -> Self {
        let (force, torque) = (ForceUnit::Newton, TorqueUnit::NewtonMetre);
        let device = AtiDevice::new(settings.can.base_id, &calibration(scenario), force, torque);
        let device = device.expect("a valid sensor");
        let stream = TcpStream::connect(can).expect("the board listens for its sensor");
        Self::with_sensor(scenario, settings, robot, |shown| {
            thread::spawn(move || serve(stream, device, &shown))
        })
    }

    /// Likewise with an Axia80 on EtherCAT.
    ///
    /// # Panics
    /// Likewise.
    pub fn connect_ethercat(
        scenario: &Scenario,
        settings: &BoardSettings,
        robot: SocketAddr,
        ethercat: SocketAddr,
    ) -> Self {
        let calibration = calibration(scenario);
        Self::with_sensor(scenario, settings, robot, |shown| {
            thread::spawn(move || serve_ethercat(ethercat, &calibration, &shown))
        })
    }

    fn with_sensor(
        scenario: &Scenario,
        settings: &BoardSettings,
        robot: SocketAddr,
        sensor: impl FnOnce(Arc<SharedShown>) -> JoinHandle<()>,
    ) -> Self {
        let mut rig =
            Rig::new(&scenario.rig, scenario.start_pose(), scenario.seed).expect("a valid rig");
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a free UDP port");
        socket.connect(robot).expect("the board's address");
        socket
            .set_read_timeout(Some(PATIENCE))
            .expect("a timeout can be set");
        let shown = Arc::new(SharedShown::default());
        let sample = rig.gauges();
        (shown.lock().counts, shown.lock().status) = (sample.counts, sample.status);
        Self {
            rig,
            tags: settings.rsi.tags().expect("valid names"),
            cycle_ms: (settings.control.robot.cycle_s * 1e3).round() as u64,
            socket,
            sensor: Some(sensor(shown.clone())),
            shown,
            ipoc: FIRST_IPOC,
        }
    }

    /// Waits until an EtherCAT sensor has been exchanging data for longer than it takes to believe them.
    ///
    /// # Panics
    /// If it never does.
    pub fn wait_for_sensor(&self) {
        const EXCHANGES: u32 = 200;
        let give_up = Instant::now() + PATIENCE;
        let mut shown = self.shown.lock();
        while shown.requests < EXCHANGES {
            assert!(Instant::now() < give_up, "the sensor never starts");
            let wait = self.shown.changed.wait_timeout(shown, POLL_INTERVAL);
            shown = wait.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Takes the robot to another pose, as a program of its own would, from one cycle to the next.
    ///
    /// # Panics
    /// If the scenario is not valid.
    pub fn stand_at(&mut self, scenario: &Scenario) {
        let rig = Rig::new(&scenario.rig, scenario.start_pose(), scenario.seed);
        self.rig = rig.expect("a valid rig");
    }

    /// Runs until `stop` is raised or the board lets go of the sensor's line, at most so many cycles;
    /// whether it could go on. A telegram that the board misses while it starts over is sent again.
    ///
    /// # Panics
    /// As [`Self::run`].
    pub fn run_until(&mut self, stop: &AtomicBool, most: usize) -> bool {
        (0..most).all(|_| !stop.load(Ordering::Relaxed) && self.step().is_some())
    }

    /// Runs one cycle: the correction; None if the board has let go of the sensor's line. A telegram
    /// that the board misses while it starts over is sent again.
    ///
    /// # Panics
    /// As [`Self::run`].
    pub fn step(&mut self) -> Option<[i64; 6]> {
        self.socket
            .set_read_timeout(Some(MISSED))
            .expect("a timeout can be set");
        self.cycle()
    }

    /// Runs so many cycles: the corrections.
    ///
    /// # Panics
    /// If the board does not answer with the telegram's time stamp, or the robot stops.
    pub fn run(&mut self, cycles: usize) -> Motion {
        let cycle = |_| self.cycle().expect("the board has the sensor's line");
        (0..cycles).map(cycle).collect()
    }

    /// The correction; None if the board has let go of the sensor's line, as when it starts over.
    fn cycle(&mut self) -> Option<[i64; 6]> {
        let report = self.rig.begin_cycle().expect("the robot goes on");
        let sample = self.rig.gauges();
        self.show(sample.counts, sample.status).then_some(())?;
        let mut bytes = [0; 1024];
        let telegram = self.telegram(&report);
        let length = write_rob(&telegram, DECIMALS, &self.tags, &mut bytes);
        let length = length.expect("room for a telegram");
        let answer = self.exchange(&bytes[..length]);
        let [x, y, z, a, b, c] = answer.correction.map(|decimal| decimal.to_f64());
        let [a, b, c] = [a, b, c].map(f64::to_radians);
        let correction = [x * 1e-3, y * 1e-3, z * 1e-3, a, b, c];
        self.rig.answer(correction, answer.stop);
        self.ipoc += self.cycle_ms;
        Some(answer.correction.map(|decimal| decimal.counts))
    }

    /// The answer to a telegram.
    fn exchange(&self, telegram: &[u8]) -> SenTelegram {
        let give_up = Instant::now() + PATIENCE;
        let mut bytes = [0; 1024];
        let mut sent = 0;
        loop {
            self.socket.send(telegram).expect("a datagram can be sent");
            sent += 1;
            while let Ok(length) = self.socket.recv(&mut bytes) {
                let answer = parse_sen(&bytes[..length], &self.tags).expect("an answer");
                if answer.ipoc == self.ipoc {
                    return answer;
                }
                // Answers to what was sent twice come twice.
                assert!(
                    sent > 1 || answer.ipoc < self.ipoc,
                    "the time stamp must come back as it was"
                );
            }
            assert!(Instant::now() < give_up, "{} was never answered", self.ipoc);
        }
    }

    fn telegram(&self, report: &RobotReport) -> RobTelegram {
        let wire = |[x, y, z, a, b, c]: [f64; 6]| {
            let [a, b, c] = [a, b, c].map(f64::to_degrees);
            [x * 1e3, y * 1e3, z * 1e3, a, b, c]
        };
        RobTelegram {
            ipoc: self.ipoc,
            actual_pose: Some(wire(report.actual_pose)),
            setpoint_pose: Some(wire(report.setpoint_pose)),
            late_answers: Some(report.late_answers),
            poscorr_stat: Some(report.poscorr_stat),
        }
    }

    /// Shows gauges and waits until the board has taken a reading of them; false if it never will.
    fn show(&self, counts: [i16; 6], status: u16) -> bool {
        let give_up = Instant::now() + PATIENCE;
        let mut shown = self.shown.lock();
        (shown.counts, shown.status, shown.requests) = (counts, status, 0);
        while shown.requests < REQUESTS {
            if shown.ended {
                return false;
            }
            assert!(
                Instant::now() < give_up,
                "the board does not ask for readings"
            );
            let wait = self.shown.changed.wait_timeout(shown, POLL_INTERVAL);
            shown = wait.unwrap_or_else(PoisonError::into_inner).0;
        }
        true
    }
}

impl Drop for LockStepRig {
    fn drop(&mut self) {
        self.shown.lock().ended = true;
        self.shown.unplugged.store(true, Ordering::Relaxed);
        if let Some(sensor) = self.sensor.take() {
            let _ = sensor.join();
        }
    }
}

fn calibration(scenario: &Scenario) -> AtiCalibration {
    AtiCalibration {
        matrix: scenario.rig.sensor.calibration,
        counts_per_force: scenario.rig.sensor.counts_per_newton,
        counts_per_torque: scenario.rig.sensor.counts_per_newton_metre,
    }
}

/// Is an EtherCAT segment until the test ends.
fn serve_ethercat(board: SocketAddr, calibration: &AtiCalibration, shared: &SharedShown) {
    let axia = SubDevice::new(Description::of(Product::Axia80));
    let mut segment = Segment::new(vec![axia]);
    let plugged = plug(board, &shared.unplugged, &mut segment, |segment, frame| {
        if !exchanges(frame) {
            return;
        }
        let mut shown = shared.lock();
        shown.requests += 1;
        let wrench = calibration.wrench(&shown.counts);
        for device in &mut segment.devices {
            let per_unit = device.counts_per_unit();
            device.measure(Measurement::of(wrench, per_unit, shown.status.into()));
        }
        drop(shown);
        shared.changed.notify_all();
    });
    plugged.expect("a free UDP port");
}

/// Answers requests until the test or the board ends.
fn serve(mut stream: TcpStream, mut device: AtiDevice, shared: &SharedShown) {
    let ready = stream.set_nodelay(true).is_ok()
        && stream.set_read_timeout(Some(POLL_INTERVAL)).is_ok()
        && stream.write_all(OPEN).is_ok();
    let mut line = Vec::new();
    let mut buffer = [0; 512];
    while ready && !shared.lock().ended {
        let length = match stream.read(&mut buffer) {
            Ok(0) => break,
            Ok(length) => length,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                continue;
            }
            Err(_) => break,
        };
        for byte in &buffer[..length] {
            if !matches!(*byte, b'\r' | 0x07) {
                line.push(*byte);
                continue;
            }
            let request = std::mem::take(&mut line);
            if answer(&request, &mut stream, &mut device, shared).is_err() {
                break;
            }
        }
    }
    shared.lock().ended = true;
    shared.changed.notify_all();
}

fn answer(
    line: &[u8],
    stream: &mut TcpStream,
    device: &mut AtiDevice,
    shared: &SharedShown,
) -> std::io::Result<()> {
    let Ok(request) = parse_frame_line(line) else {
        return Ok(());
    };
    let mut shown = shared.lock();
    shown.requests += 1;
    let (counts, status) = (shown.counts, shown.status);
    drop(shown);
    shared.changed.notify_all();
    for frame in device.answer(&request, counts, status) {
        let mut text = heapless::Vec::<u8, MAX_LINE_BYTES>::new();
        encode_frame_line(&frame, &mut text);
        stream.write_all(&text)?;
    }
    Ok(())
}
