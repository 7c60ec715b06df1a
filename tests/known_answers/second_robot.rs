//! A robot that has nothing of KUKA's closes the same loop: binary telegrams each 1 ms, a quaternion
//! in, twists out. Everything but [`twist_robot`](softdock_tests::twist_robot) is the product.

use nalgebra::{UnitQuaternion, Vector3};
use softdock_app::record::CycleRecord;
use softdock_app::robot_cycle::RobotCycle;
use softdock_app::robot_link::{Incoming, Prepared, RobotLink, Senders};
use softdock_app::robot_protocol::RobotProtocol;
use softdock_control::checked::Checked;
use softdock_control::delay::{LawName, ModelVelocity};
use softdock_control::io::SensorSample;
use softdock_control::modes::{Command, FaultCode, Mode};
use softdock_control::settings::Settings;
use softdock_tests::twist_robot::{Answer, CYCLE_S, CYCLE_US, TwistRobot, Twists};
use std::f64::consts::{FRAC_PI_2, PI};
use std::net::SocketAddr;

const MASS_KG: f64 = 500.0;

/// Board and robot.
struct Loop {
    link: RobotLink<f64, Twists>,
    robot: TwistRobot,
    sensor: SensorSample,
    records: Vec<CycleRecord>,
    now_us: u64,
}

/// A free spacecraft before a fixed one. The cycle's length is left at KUKA's.
fn settings() -> Settings {
    let mut settings = Settings::default();
    settings.delay.law = LawName::None;
    settings.delay.model_velocity = ModelVelocity::Mean;
    settings.body_k.mass_kg = MASS_KG;
    settings.body_q.fixed = true;
    // The jog of the defaults changes its speed from cycle to cycle as a robot of 4 ms may.
    settings.limits.acceleration_m_s2 = 50.0;
    settings.limits.acceleration_rad_s2 = 100.0;
    settings
}

fn address(host: u8) -> SocketAddr {
    SocketAddr::from(([192, 168, 1, host], 1000))
}

impl Loop {
    /// The robot stands where KUKA's B is 90° and A and C are not defined.
    fn new(settings: &Settings) -> Self {
        let senders = Senders {
            allowed: None,
            silence_us: 400_000,
        };
        let robot = TwistRobot {
            counter: 7_000_000_000,
            place: (
                Vector3::new(1.0, -0.5, 1.2),
                UnitQuaternion::from_axis_angle(&Vector3::y_axis(), FRAC_PI_2),
            ),
            status: 0,
        };
        Self {
            link: RobotLink::new(Prepared::with(settings, Twists::default(), senders).unwrap()),
            robot,
            sensor: SensorSample::default(),
            records: Vec::new(),
            now_us: 0,
        }
    }

    /// With the loop closed, behind the ramp.
    fn running(settings: &Settings) -> Self {
        let mut running = Self::new(settings);
        running.start();
        running.cycles(settings.start.zero_cycles + settings.start.ramp_cycles);
        assert_eq!(running.link.mode(), Mode::Running);
        running
    }

    fn start(&mut self) {
        for command in [Command::Hold, Command::Arm, Command::Start] {
            self.cycle(Some(command));
        }
        assert_eq!(self.link.mode(), Mode::Running, "{:?}", self.last().trace);
    }

    /// Does what the robot task does for a datagram. Whatever is answered has its counter.
    fn take(&mut self, datagram: &[u8], from: u8, command: Option<Command>) -> Option<Answer> {
        let answer = match self.link.receive(datagram, address(from), self.now_us) {
            Incoming::Telegram(telegram) => {
                if let Some(sequence) = self.link.follow(&telegram) {
                    self.sensor.counter += 1;
                    self.sensor.counts[5] ^= 1;
                    let record = self
                        .link
                        .run_cycle(&telegram, sequence, self.sensor, command);
                    self.records.push(record);
                }
                self.link.last_answer().to_vec()
            }
            Incoming::Unreadable { counter } => self.link.resting_answer(counter).to_vec(),
            Incoming::Ignored => return None,
        };
        let answer = Answer::read(&answer).expect("a whole answer");
        assert_eq!(answer.counter, self.robot.counter);
        Some(answer)
    }

    /// One cycle of both.
    fn cycle(&mut self, command: Option<Command>) -> Answer {
        let telegram = self.robot.telegram();
        let answer = self.take(&telegram, 10, command).expect("an answer");
        self.robot.execute(&answer);
        self.next();
        answer
    }

    /// Time passes.
    fn next(&mut self) {
        self.robot.counter += CYCLE_US;
        self.now_us += CYCLE_US;
    }

    fn cycles(&mut self, count: u32) {
        for _ in 0..count {
            self.cycle(None);
        }
    }

    fn last(&self) -> &CycleRecord {
        self.records.last().expect("a cycle")
    }

    /// How far the robot is from where it was commanded to be, m and rad.
    fn apart(&self) -> (f64, f64) {
        let [x, y, z, w, i, j, k] = self.last().trace.command_pose;
        let orientation = UnitQuaternion::from_quaternion([i, j, k, w].into());
        let (position, turned) = &self.robot.place;
        (
            (position - Vector3::new(x, y, z)).norm(),
            turned.angle_to(&orientation),
        )
    }

    /// A fault is latched, and the robot stands still however often it asks.
    fn assert_fault(&mut self, code: FaultCode) {
        let fault = self.last().trace.fault.map(|fault| fault.code);
        assert_eq!(fault, Some(code));
        for _ in 0..5 {
            assert_eq!(self.cycle(None).twist, [0.0; 6]);
        }
    }
}

/// The cycle's length is the robot's. All six axes at once: no rounding of a twist to an f32 is lost,
/// however long it goes.
#[test]
fn free_flight_in_six_axes_does_not_drift() {
    let mut settings = settings();
    settings.body_k.velocity_m_s = [0.011, -0.007, 0.003];
    settings.body_k.angular_velocity_rad_s = [0.013, 0.017, -0.019];
    let mut flight = Loop::running(&settings);
    let (before, turned) = flight.robot.place;
    flight.cycles(10_000);
    let (after, turned_to) = flight.robot.place;
    let (metres, radians) = flight.apart();
    assert!(
        metres < 1e-11 && radians < 1e-8,
        "{metres} m, {radians} rad"
    );

    // Q is fixed and was armed with the spacecraft at its origin, so that axes of C are those of the start.
    let way = turned_frame() * Vector3::new(0.11, -0.07, 0.03);
    assert!((after - before - way).norm() < 1e-9, "{}", after - before);
    let turn = Vector3::new(0.13, 0.17, -0.19);
    let expected = turned * UnitQuaternion::from_scaled_axis(turn);
    assert!(turned_to.angle_to(&expected) < 1e-7);
    let times: Vec<f64> = flight.records.iter().map(|r| r.trace.time_s).collect();
    assert!((times[1] - times[0] - CYCLE_S).abs() < 1e-12);
}

/// Axes of the spacecraft's laboratory, which are those of M at the start, in C.
fn turned_frame() -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::y_axis(), FRAC_PI_2)
}

/// A free spacecraft bounces off a spring. The force of each cycle is that of its beginning: half a cycle
/// late, which adds exp(π ω T / 4) to an elastic bounce.
#[test]
fn a_bounce_comes_back_as_calculated() {
    const OMEGA: f64 = 21.0;
    const SPEED_M_S: f64 = 0.01;
    let mut settings = settings();
    settings.body_k.velocity_m_s = [SPEED_M_S, 0.0, 0.0];
    let mut bounce = Loop::running(&settings);
    let normal = turned_frame() * Vector3::x();
    let wall = bounce.robot.place.0.dot(&normal) + 0.1037 * SPEED_M_S;
    let mut touched = false;
    for _ in 0..1000 {
        let depth = (bounce.robot.place.0.dot(&normal) - wall).max(0.0);
        if touched && depth == 0.0 {
            break;
        }
        touched |= depth > 0.0;
        // M has turned with the spacecraft's laboratory: its x is the normal.
        bounce.sensor.wrench[0] = -MASS_KG * OMEGA * OMEGA * depth;
        bounce.cycle(None);
    }
    assert!(touched);
    let restitution = -bounce.last().trace.body_k.velocity[0] / SPEED_M_S;
    let expected = (PI * OMEGA * CYCLE_S / 4.0).exp();
    println!("restitution {restitution:.5}, expected {expected:.5}");
    assert!((restitution - expected).abs() < 1e-4, "{restitution}");
}

/// What lost, repeated and damaged telegrams lead to is the same for every robot, and the motion is
/// whole behind them.
#[test]
fn lost_repeated_damaged_and_foreign_telegrams() {
    let mut settings = settings();
    settings.body_k.velocity_m_s = [0.01, 0.0, 0.0];
    let mut flight = Loop::running(&settings);
    for _ in 0..3 {
        flight.next();
    }
    flight.cycles(10);

    let telegram = flight.robot.telegram();
    let once = flight.take(&telegram, 10, None).unwrap();
    let cycles = flight.records.len();
    assert_eq!(flight.take(&telegram, 10, None), Some(once));
    assert_eq!(flight.records.len(), cycles);
    flight.robot.execute(&once);
    flight.next();

    let cut = flight.robot.telegram();
    let answer = flight.take(&cut[..40], 10, None).unwrap();
    assert_eq!(answer.twist, [0.0; 6]);
    assert_eq!(flight.take(&cut, 66, None), None);
    assert_eq!(flight.take(b"TWST", 10, None), None);
    flight.next();
    flight.cycles(10);

    let counters = flight.link.counters();
    let seen = [
        counters.lost,
        counters.duplicates,
        counters.malformed,
        counters.foreign,
    ];
    assert_eq!(seen, [3 + 1, 1, 2, 1]);
    assert_eq!(flight.link.mode(), Mode::Running);
    assert!(flight.apart().0 < 1e-11, "{:?}", flight.apart());
}

/// Faults latch, every telegram is answered with its own counter, and a person can start again.
#[test]
fn faults_of_the_robot_stop_it() {
    let mut settings = settings();
    settings.body_k.velocity_m_s = [0.01, 0.0, 0.0];
    let mut flight = Loop::running(&settings);
    (0..11).for_each(|_| flight.next());
    assert_eq!(flight.cycle(None).twist, [0.0; 6]);
    flight.assert_fault(FaultCode::TelegramsLost);

    let mut flight = Loop::running(&settings);
    flight.robot.counter = 0;
    assert_eq!(flight.cycle(None).twist, [0.0; 6]);
    flight.assert_fault(FaultCode::RobotRestarted);
    assert_eq!(flight.link.counters().runs, 2);
    flight.cycle(Some(Command::Reset));
    flight.start();
    flight.cycles(100);
    assert!(flight.apart().0 < 1e-11, "{:?}", flight.apart());

    let mut flight = Loop::running(&settings);
    flight.robot.status = 1;
    flight.cycles(2 * settings.limits.clamp_fault_cycles);
    flight.assert_fault(FaultCode::SustainedClamp);
}

/// A record holds the robot's own numbers, so that any robot's run replays bit for bit.
#[test]
fn a_run_replays_bit_for_bit() {
    let mut settings = settings();
    settings.body_k.angular_velocity_rad_s = [0.013, 0.017, -0.019];
    let mut flight = Loop::running(&settings);
    flight.sensor.wrench = [1.0, -2.0, 3.0, 0.1, 0.2, -0.3];
    flight.cycles(1000);
    let twists = Twists::default();
    let checked = Checked::new(&settings, &twists.interface()).unwrap();
    let mut replay = RobotCycle::<f64, Twists>::with(checked, twists);
    for record in &flight.records {
        assert_eq!(replay.step(&record.inputs), *record);
    }
}
