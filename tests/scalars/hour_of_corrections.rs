//! An hour of running, 900,000 cycles: two walls to bounce between, a torsion spring, long free
//! flights in between. What the robot adds up from the decimal text of the telegrams stays within
//! one least digit of the integrated command, from 3 to 6 decimals, relative and absolute.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use softdock_app::record::CycleRecord;
use softdock_control::frames::{abc_from_orientation, orientation_from_abc};
use softdock_control::io::Trace;
use softdock_control::limits::LimitFlags;
use softdock_control::modes::{Command, Mode};
use softdock_control::scalar::{Fixed, Scalar};
use softdock_control::settings::{CorrectionMode, Settings};
use softdock_link::decimal::Decimal;
use softdock_link::rsi::{
    Corrections, Counts, SEN_MAX_BYTES, SenTelegram, Tags, parse_sen, write_sen,
};
use softdock_tests::driver::idle;

const CYCLES: u64 = 900_000;
const CYCLE_S: f64 = 0.004;
const MODES: [CorrectionMode; 2] = [CorrectionMode::Relative, CorrectionMode::Absolute];
/// Distance of the walls from the start, m, and their stiffness: 500 kg × (15 rad/s)².
const WALL_M: f64 = 0.012;
const STIFFNESS_N_PER_M: f64 = 500.0 * 15.0 * 15.0;
/// Torsion spring about M: 100 kg·m² × (0.3 rad/s)².
const TORSION_N_M_PER_RAD: f64 = 9.0;

/// A robot that reads the text of its corrections, with as many decimals as it is told.
struct TextRobot {
    mode: CorrectionMode,
    decimals: u8,
    tags: Tags,
    sum: Counts,
}

impl TextRobot {
    fn new(mode: CorrectionMode, decimals: u8) -> Self {
        Self {
            mode,
            decimals,
            tags: Tags::default(),
            sum: [0; 6],
        }
    }

    /// Writes the answer as the board does, reads it as a robot does.
    fn take(&mut self, ipoc: u64, counts: &Counts) {
        let decimals = self.decimals;
        let telegram = SenTelegram {
            ipoc,
            correction: counts.map(|counts| Decimal { counts, decimals }),
            stop: false,
        };
        let mut bytes = [0; SEN_MAX_BYTES];
        let length = write_sen(&telegram, &self.tags, &mut bytes).unwrap();
        let read = parse_sen(&bytes[..length], &self.tags).unwrap();
        for (sum, digit) in self.sum.iter_mut().zip(read.correction) {
            assert_eq!(digit.decimals, decimals);
            match self.mode {
                CorrectionMode::Relative => *sum += digit.counts,
                CorrectionMode::Absolute => *sum = digit.counts,
            }
        }
    }

    /// Metres and radians from the start.
    fn offset(&self) -> [f64; 6] {
        let digit = 0.1_f64.powi(self.decimals.into());
        core::array::from_fn(|i| {
            let value = self.sum[i] as f64 * digit;
            if i < 3 {
                value * 1e-3
            } else {
                value.to_radians()
            }
        })
    }

    /// Largest distance from what is meant, in least digits: (translation, rotation).
    fn digits_from(&self, meant: &[f64; 6]) -> (f64, f64) {
        let digit = 0.1_f64.powi(self.decimals.into());
        let offset = self.offset();
        let apart = |i: usize| (offset[i] - meant[i]).abs();
        let linear = apart(0).max(apart(1)).max(apart(2));
        let turned = (3..6).map(|i| (apart(i) + 1.0).rem_euclid(std::f64::consts::TAU) - 1.0);
        let angular = turned.fold(0.0, |most: f64, a| most.max(a.abs()));
        (linear / (digit * 1e-3), angular / digit.to_radians())
    }
}

/// The sum of the velocities that were sent, exact to far below a picometre.
#[derive(Default)]
struct Integral {
    sum: [f64; 3],
    rest: [f64; 3],
}

impl Integral {
    fn add(&mut self, velocity: &[f64; 6]) {
        for ((sum, rest), v) in self.sum.iter_mut().zip(&mut self.rest).zip(velocity) {
            let before = *sum;
            *sum += v;
            // What a sum of two numbers of any size loses (Knuth's two-sum).
            let part = *sum - before;
            *rest += (before - (*sum - part)) + (v - part);
        }
    }

    fn metres(&self) -> [f64; 3] {
        core::array::from_fn(|i| (self.sum[i] + self.rest[i]) * CYCLE_S)
    }
}

fn settings(mode: CorrectionMode, decimals: u8) -> Settings {
    let mut settings = Settings::default();
    settings.delay.law = softdock_control::delay::LawName::None;
    settings.robot.correction_mode = mode;
    settings.robot.correction_decimals = decimals;
    settings.body_k.velocity_m_s = [0.012, 0.003, -0.002];
    settings.body_k.angular_velocity_rad_s = [0.01, -0.02, 0.015];
    settings.body_q.fixed = true;
    settings.delay.model_velocity = softdock_control::delay::ModelVelocity::End;
    settings.start.ramp_cycles = 1;
    settings
}

/// Contact and torsion at an offset from the start, axes of M. Walls are across all three axes of C.
fn wrench([x, y, z, a, b, c]: [f64; 6]) -> [f64; 6] {
    let c_from_m = orientation_from_abc::<f64>(&[a, b, c]);
    let push = |at: f64| -STIFFNESS_N_PER_M * (at - at.clamp(-WALL_M, WALL_M));
    let force = c_from_m.inverse() * Vector3::new(push(x), push(y), push(z));
    let torque = c_from_m.scaled_axis() * -TORSION_N_M_PER_RAD;
    [force.x, force.y, force.z, torque.x, torque.y, torque.z]
}

fn orientation(pose: &[f64; 7]) -> UnitQuaternion<f64> {
    let [_, _, _, w, i, j, k] = *pose;
    UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k))
}

/// What an hour comes to.
#[derive(Debug, Default)]
struct Hour {
    /// Largest distance of the robot from the integrated command, least digits.
    digits: (f64, f64),
    /// Cycles in contact.
    in_contact: u32,
    /// Distance of the commanded orientation from the integral of the angular velocity, rad.
    turned_apart_rad: f64,
}

impl Hour {
    fn note(&mut self, (linear, angular): (f64, f64)) {
        self.digits = (self.digits.0.max(linear), self.digits.1.max(angular));
    }
}

/// The whole cycle with its own corrections; besides, `each` sees every record and what is meant.
fn an_hour<S: Scalar>(
    settings: &Settings,
    each: impl FnMut(&CycleRecord, &[f64; 6], &mut Hour),
) -> Hour {
    lasting::<S>(CYCLES, settings, each)
}

/// Likewise, for so many cycles.
fn lasting<S: Scalar>(
    cycles: u64,
    settings: &Settings,
    mut each: impl FnMut(&CycleRecord, &[f64; 6], &mut Hour),
) -> Hour {
    let robot = &settings.robot;
    let mut robot = TextRobot::new(robot.correction_mode, robot.correction_decimals);
    let mut driver = idle::<S>(settings);
    let (mut hour, mut integral) = (Hour::default(), Integral::default());
    let mut turned = UnitQuaternion::identity();
    let mut record = driver.start().unwrap();
    for _ in 0..cycles {
        assert_eq!(record.trace.fault, None);
        assert_eq!(record.trace.limits, LimitFlags::default());
        let Trace {
            sent_velocity,
            command_pose,
            ..
        } = &record.trace;
        integral.add(sent_velocity);
        let [_, _, _, wx, wy, wz] = *sent_velocity;
        turned *= UnitQuaternion::from_scaled_axis(Vector3::new(wx, wy, wz) * CYCLE_S);
        let ([x, y, z], q) = (integral.metres(), orientation(command_pose));
        let [a, b, c] = abc_from_orientation(&q);
        let meant = [x, y, z, a, b, c];
        robot.take(record.inputs.robot.counter, &record.output.correction);
        hour.note(robot.digits_from(&meant));
        hour.turned_apart_rad = hour.turned_apart_rad.max(q.angle_to(&turned));
        each(&record, &meant, &mut hour);

        let at = robot.offset();
        driver.inputs.robot.pose = Some(at);
        driver.inputs.sensor.wrench = wrench(at);
        hour.in_contact += u32::from(driver.inputs.sensor.wrench[0] != 0.0);
        record = driver.step();
    }
    let share = f64::from(hour.in_contact) / cycles as f64;
    assert!((0.02..0.5).contains(&share), "in contact for {share}");
    assert_eq!(driver.cycle.mode(), Mode::Running);
    hour
}

/// All digits and both modes at once: the other seven round the same command beside the cycle.
#[test]
#[ignore = "long: an hour of cycles"]
fn f64_from_3_to_6_decimals_relative_and_absolute() {
    let all = MODES.map(|mode| (3..=6).map(move |decimals| (mode, decimals)));
    let mut others: Vec<_> = all
        .into_iter()
        .flatten()
        .filter(|other| *other != (CorrectionMode::Relative, 4))
        .map(|(mode, decimals)| {
            (
                Corrections::new(mode == CorrectionMode::Absolute, decimals),
                TextRobot::new(mode, decimals),
            )
        })
        .collect();
    assert_eq!(others.len(), 7);
    others.iter_mut().for_each(|(q, _)| q.start([0.0; 3]));
    let hour = an_hour::<f64>(&settings(MODES[0], 4), |record, meant, hour| {
        let [x, y, z, a, b, c] = *meant;
        for (corrections, robot) in &mut others {
            let counts = corrections.advance([x, y, z], [a, b, c]);
            robot.take(record.inputs.robot.counter, &counts);
            hour.note(robot.digits_from(meant));
        }
    });
    // Half a digit of rounding, and nothing else.
    assert!(hour.digits.0 < 0.501 && hour.digits.1 < 0.501, "{hour:?}");
    assert!(hour.turned_apart_rad < 1e-12, "{hour:?}");
}

/// The scalar of the board without a floating-point unit, with the finest digits. A, B, C of
/// fixed point are good to 3e-9 rad, a fifth of such a digit. The commanded orientation itself is
/// the rounded sum of an hour's rotations: 2e-6 rad, where rounding downwards came to 4e-4.
#[test]
#[ignore = "long: an hour of cycles"]
fn fixed_point_absolute_with_6_decimals() {
    let hour = an_hour::<Fixed>(&settings(MODES[1], 6), |_, _, _| ());
    assert!(hour.digits.0 < 0.501 && hour.digits.1 < 1.0, "{hour:?}");
    assert!(hour.turned_apart_rad < 1e-5, "{hour:?}");
}

#[test]
fn f32_relative_with_3_decimals_for_ten_minutes() {
    f32_relative_with_3_decimals(CYCLES / 6);
}

#[test]
#[ignore = "long: an hour of cycles"]
fn f32_relative_with_3_decimals_for_an_hour() {
    f32_relative_with_3_decimals(CYCLES);
}

/// Angles in f32 are good to 1e-7 rad: with 3 decimals a hundredth of a digit.
fn f32_relative_with_3_decimals(cycles: u64) {
    let hour = lasting::<f32>(cycles, &settings(MODES[0], 3), |_, _, _| ());
    assert!(hour.digits.0 < 0.501 && hour.digits.1 < 0.52, "{hour:?}");
    assert!(hour.turned_apart_rad < 1e-4, "{hour:?}");
}

/// A run that is stopped and started again and again within one RSI run keeps the sum, in both
/// modes: nothing is lost at the seams.
fn restarts<S: Scalar>(mode: CorrectionMode) {
    let settings = settings(mode, 4);
    let mut robot = TextRobot::new(mode, 4);
    let mut driver = idle::<S>(&settings);
    for _ in 0..50 {
        let start = robot.offset();
        driver.inputs.robot.pose = Some(start);
        driver.command(Command::Hold);
        driver.command(Command::Arm);
        let mut record = driver.command(Command::Start);
        for n in 0..100 {
            robot.take(record.inputs.robot.counter, &record.output.correction);
            let [x, y, z, ..] = record.trace.command_pose;
            let (offset, meant) = (robot.offset(), [x, y, z]);
            for (is, meant) in offset.iter().zip(meant) {
                assert!((is - meant).abs() < 0.9e-7, "{is} {meant}");
            }
            driver.inputs.robot.pose = Some(offset);
            record = match n {
                50 => driver.command(Command::Stop),
                _ => driver.step(),
            };
        }
    }
    assert!(robot.offset()[0] > 0.1, "{:?}", robot.offset());
}

#[test]
fn restarts_lose_nothing() {
    for mode in MODES {
        restarts::<f64>(mode);
        restarts::<Fixed>(mode);
    }
}
