//! A simulated rig behind real sockets: RSI over UDP, the sensor behind SLCAN over TCP or on EtherCAT over UDP.
//!
//! Robot and sensor share the rig's own time, which stops until the board has answered. A telegram is sent only after the
//! board has taken a reading of that time. So the board's corrections depend only on its arithmetic: two boards with the same
//! arithmetic send the same corrections, however slow or busy the computer is.

use crate::process::PATIENCE;
use softdock_app::settings::BoardSettings;
use softdock_experiments::scenario::Scenario;
use softdock_link::can::Frame;
use softdock_link::can::ati::{AtiCalibration, AtiDevice, ForceUnit, TorqueUnit};
use softdock_link::ethercat::Product;
use softdock_link::slcan::{AdapterLines, OPENING};
use softdock_rig::ethercat::wire::{exchanges, plug};
use softdock_rig::ethercat::{Description, Segment, SubDevice};
use softdock_rig::peer::slcan::{frames, send};
use softdock_rig::peer::telegrams::{Answer, Telegrams};
use softdock_rig::rig::Rig;
use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Time after which a telegram counts as missed by a board that restarts.
const MISSED: Duration = Duration::from_secs(1);
/// Interval between two checks of a wait.
const POLL_INTERVAL: Duration = Duration::from_millis(20);
/// Requests of the sensor's data after which the board has certainly taken the reading: the first is answered with it, the
/// second comes after that.
const REQUESTS: u32 = 2;

/// Corrections of the board, per cycle: X Y Z (units of the last decimal of mm), A B C (of degrees).
pub type Motion = Vec<[i64; 6]>;

/// Present output of the sensor, and the number of requests since it was set.
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
    /// As `ended`, for the EtherCAT segment, which checks only this flag.
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
    telegrams: Telegrams,
    socket: UdpSocket,
    shown: Arc<SharedShown>,
    sensor: Option<JoinHandle<()>>,
}

impl LockStepRig {
    /// Connects the rig of a scenario to a board with `settings`. Its sensor starts at once, its robot with [`Self::run`].
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
        let calibration = scenario.rig.sensor.calibration();
        let device = AtiDevice::new(settings.can.base_id, &calibration, force, torque);
        let device = device.expect("a valid sensor");
        let stream = TcpStream::connect(can).expect("the board listens for its sensor");
        Self::with_sensor(scenario, settings, robot, |shown| {
            thread::spawn(move || serve(stream, device, &shown))
        })
    }

    /// As [`Self::connect`], with an Axia80 on EtherCAT.
    ///
    /// # Panics
    /// As [`Self::connect`].
    pub fn connect_ethercat(
        scenario: &Scenario,
        settings: &BoardSettings,
        robot: SocketAddr,
        ethercat: SocketAddr,
    ) -> Self {
        let calibration = scenario.rig.sensor.calibration();
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
            telegrams: Telegrams::new(
                settings.rsi.tags().expect("valid names"),
                scenario.rig.cycle_us.into(),
            ),
            socket,
            sensor: Some(sensor(shown.clone())),
            shown,
        }
    }

    /// Waits until an EtherCAT sensor has exchanged data for longer than the board needs to accept them.
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

    /// Moves the robot to another pose from one cycle to the next, as another robot program would.
    ///
    /// # Panics
    /// If the scenario is not valid.
    pub fn stand_at(&mut self, scenario: &Scenario) {
        let rig = Rig::new(&scenario.rig, scenario.start_pose(), scenario.seed);
        self.rig = rig.expect("a valid rig");
    }

    /// Runs at most `most` cycles, until `stop` is set or the board closes the sensor's line; returns whether it could go on.
    /// A telegram that the board misses while it restarts is sent again.
    ///
    /// # Panics
    /// As [`Self::run`].
    pub fn run_until(&mut self, stop: &AtomicBool, most: usize) -> bool {
        (0..most).all(|_| !stop.load(Ordering::Relaxed) && self.step().is_some())
    }

    /// Runs one cycle; returns the correction, or None if the board has closed the sensor's line. A telegram that the board
    /// misses while it restarts is sent again.
    ///
    /// # Panics
    /// As [`Self::run`].
    pub fn step(&mut self) -> Option<[i64; 6]> {
        self.socket
            .set_read_timeout(Some(MISSED))
            .expect("a timeout can be set");
        self.cycle()
    }

    /// Runs some cycles; returns the corrections.
    ///
    /// # Panics
    /// If the board does not answer with the telegram's time stamp, or the robot stops.
    pub fn run(&mut self, cycles: usize) -> Motion {
        let cycle = |_| self.cycle().expect("the board has the sensor's line");
        (0..cycles).map(cycle).collect()
    }

    /// Runs one cycle; returns the correction, or None if the board has closed the sensor's line, as it does when it
    /// restarts.
    fn cycle(&mut self) -> Option<[i64; 6]> {
        let report = self.rig.begin_cycle().expect("the robot goes on");
        let sample = self.rig.gauges();
        self.show(sample.counts, sample.status).then_some(())?;
        let telegram = self.telegrams.write(&report).expect("a telegram");
        let answer = self.exchange(&telegram);
        self.rig.answer(answer.correction, answer.stop);
        self.telegrams.advance();
        Some(answer.counts)
    }

    /// The answer to a telegram.
    fn exchange(&self, telegram: &[u8]) -> Answer {
        let give_up = Instant::now() + PATIENCE;
        let mut bytes = [0; 1024];
        let (ipoc, mut sent) = (self.telegrams.ipoc(), 0);
        loop {
            self.socket.send(telegram).expect("a datagram can be sent");
            sent += 1;
            while let Ok(length) = self.socket.recv(&mut bytes) {
                let answer = self.telegrams.read(&bytes[..length]).expect("an answer");
                if answer.ipoc == ipoc {
                    return answer;
                }
                // A telegram that was sent twice is answered twice.
                assert!(
                    sent > 1 || answer.ipoc < ipoc,
                    "the time stamp must come back as it was"
                );
            }
            assert!(Instant::now() < give_up, "{ipoc} was never answered");
        }
    }

    /// Sets the gauges and waits until the board has taken a reading of them; false if it never will.
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

/// Simulates an EtherCAT segment until the test ends.
fn serve_ethercat(board: SocketAddr, calibration: &AtiCalibration, shared: &SharedShown) {
    let axia = SubDevice::new(Description::of(Product::Axia80));
    let mut segment = Segment::new(vec![axia]);
    let plugged = plug(board, &shared.unplugged, &mut segment, |segment, frame| {
        if !exchanges(frame) {
            return;
        }
        let mut shown = shared.lock();
        shown.requests += 1;
        segment.measure(calibration.wrench(&shown.counts), shown.status);
        drop(shown);
        shared.changed.notify_all();
    });
    plugged.expect("a free UDP port");
}

/// Answers requests until the test or the board ends.
fn serve(mut stream: TcpStream, mut device: AtiDevice, shared: &SharedShown) {
    let ready = stream.set_nodelay(true).is_ok()
        && stream.set_read_timeout(Some(POLL_INTERVAL)).is_ok()
        && stream.write_all(&OPENING.concat()).is_ok();
    let mut lines = AdapterLines::default();
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
        for request in frames(&mut lines, &buffer[..length]) {
            if answer(&request, &mut stream, &mut device, shared).is_err() {
                break;
            }
        }
    }
    shared.lock().ended = true;
    shared.changed.notify_all();
}

fn answer(
    request: &Frame,
    stream: &mut TcpStream,
    device: &mut AtiDevice,
    shared: &SharedShown,
) -> std::io::Result<()> {
    let mut shown = shared.lock();
    shown.requests += 1;
    let (counts, status) = (shown.counts, shown.status);
    drop(shown);
    shared.changed.notify_all();
    send(stream, device.answer(request, counts, status))
}
