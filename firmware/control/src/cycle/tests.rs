use super::*;
use crate::delay::LawName;
use crate::frames::orientation_from_abc;
use crate::robot::GimbalLock;
use nalgebra::Vector3;

const CYCLE_S: f64 = 0.004;
const LARGEST_B_RAD: f64 = 1.4;

/// A cycle with a robot at rest and a sensor that flickers.
struct Bench {
    cycle: Cycle<f64>,
    inputs: Inputs,
}

impl Bench {
    fn new(settings: &Settings) -> Self {
        let robot = RobotInterface {
            cycle_s: CYCLE_S,
            gimbal_lock: Some(GimbalLock {
                axis_in_m: [1.0, 0.0, 0.0],
                axis_in_c: [0.0, 0.0, 1.0],
                largest_angle_rad: LARGEST_B_RAD,
            }),
        };
        let mut bench = Self {
            cycle: Cycle::new(Checked::new(settings, &robot).unwrap()),
            inputs: Inputs::default(),
        };
        bench.stands_at([0.0; 3], [0.0; 3]);
        bench
    }

    /// Sets the robot's pose: x y z (m), A B C (rad).
    fn stands_at(&mut self, position_m: [f64; 3], abc_rad: [f64; 3]) {
        let rotation = orientation_from_abc::<f64>(&abc_rad);
        let pose = Pose::from_parts(Vector3::from(position_m).into(), rotation);
        self.inputs.robot.pose = Some(pose_components(&pose));
    }

    fn step(&mut self) -> (Output, Trace) {
        self.inputs.sensor.counter += 1;
        self.inputs.sensor.counts[0] ^= 1;
        let done = self.cycle.step(&self.inputs);
        self.inputs.robot.sequence = Sequence::Next;
        self.inputs.command = None;
        done
    }

    fn command(&mut self, command: Command) -> Trace {
        self.inputs.command = Some(command);
        self.step().1
    }

    fn arm(&mut self) {
        self.command(Command::Hold);
        assert_eq!(self.command(Command::Arm).mode, Mode::Armed);
    }

    /// After this the first cycle of the loop is done.
    fn start(&mut self) {
        self.arm();
        assert_eq!(self.command(Command::Start).mode, Mode::Running);
    }
}

/// Settings with a moving K, without a delay law.
fn moving(velocity_m_s: [f64; 3], angular_velocity_rad_s: [f64; 3]) -> Settings {
    let mut settings = Settings::default();
    settings.delay.law = LawName::None;
    settings.body_k.velocity_m_s = velocity_m_s;
    settings.body_k.angular_velocity_rad_s = angular_velocity_rad_s;
    settings
}

#[test]
fn each_cycle_has_its_number_and_its_time() {
    let mut bench = Bench::new(&Settings::default());
    for n in 0..5 {
        let (_, trace) = bench.step();
        assert_eq!((trace.cycle, trace.time_s), (n, n as f64 * CYCLE_S));
    }
}

/// A robot that lifts 12 kg with 0.3 m/s²: m (g + a) is removed completely, so that no contact is left.
#[test]
fn the_weight_of_the_tool_and_what_its_acceleration_takes_are_removed() {
    let mut settings = Settings::default();
    settings.sensor.tool_mass_kg = 12.0;
    settings.sensor.dynamic_compensation = crate::settings::DynamicCompensation::LoadReaction;
    let mut bench = Bench::new(&settings);
    let load = -12.0 * (9.81 + 0.3);
    bench.inputs.sensor.wrench[2] = load;
    let mut last = Trace::default();
    for n in 0..300 {
        let time_s = f64::from(n) * CYCLE_S;
        bench.stands_at([0.0, 0.0, 0.5 * 0.3 * time_s * time_s], [0.0; 3]);
        last = bench.step().1;
    }
    assert!((last.removed[2] - load).abs() < 1e-3, "{:?}", last.removed);
    assert!(last.wrench_at_m[2].abs() < 1e-3, "{:?}", last.wrench_at_m);
}

#[test]
fn what_is_measured_beyond_its_range_is_marked() {
    let mut bench = Bench::new(&Settings::default());
    bench.step();
    for (reading, marked) in [
        (1.0, false),
        (LARGEST_READING, false),
        (-LARGEST_READING, false),
        (1.1 * LARGEST_READING, true),
        (-1.1 * LARGEST_READING, true),
        (f64::NAN, true),
        (0.0, false),
    ] {
        bench.inputs.sensor.wrench[4] = reading;
        let (_, trace) = bench.step();
        assert_eq!(trace.limits.has(LimitFlags::MEASURED), marked, "{reading}");
    }
    // A metre or a radian in a cycle, and rest after it.
    for (position_m, abc_rad) in [
        ([1.0, 0.0, 0.0], [0.0; 3]),
        ([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
    ] {
        bench.stands_at(position_m, abc_rad);
        let marked = [0, 1].map(|_| bench.step().1.limits.has(LimitFlags::MEASURED));
        assert_eq!(marked, [true, false]);
    }
}

#[test]
fn a_robot_that_begins_anew_elsewhere_has_not_moved_there() {
    let mut bench = Bench::new(&Settings::default());
    for _ in 0..3 {
        bench.step();
    }
    bench.inputs.robot.sequence = Sequence::NewRun;
    bench.stands_at([1.0, 0.0, 0.0], [0.0; 3]);
    for _ in 0..3 {
        let (_, trace) = bench.step();
        assert_eq!(trace.executed_velocity, [0.0; 6]);
        assert!(!trace.limits.has(LimitFlags::MEASURED));
    }
}

/// The robot may be moved by hand or by another program: the loop would begin with a jump.
#[test]
fn a_robot_that_was_moved_since_it_was_armed_is_not_started() {
    for (by, refused) in [(0.5, false), (1.5, true)] {
        let (far, turned) = (by * 1e-3, by * 2e-3);
        for axis in 0..6 {
            for sign in [1.0, -1.0] {
                let mut bench = Bench::new(&Settings::default());
                bench.stands_at([1.0, 2.0, 3.0], [0.0; 3]);
                bench.arm();
                let (mut position_m, mut abc_rad) = ([1.0, 2.0, 3.0], [0.0; 3]);
                match axis {
                    0..3 => position_m[axis] += sign * far,
                    _ => abc_rad[axis - 3] = sign * turned,
                }
                bench.stands_at(position_m, abc_rad);
                let refusal = bench.command(Command::Start).refusal;
                let expected = refused.then_some(Refusal::MovedSinceArmed);
                assert_eq!(refusal, expected, "{by} along {axis}");
            }
        }
    }
}

#[test]
fn the_commanded_pose_is_where_the_robot_began_and_what_it_was_sent_since() {
    let velocity_m_s = [0.01, 0.02, -0.03];
    let mut bench = Bench::new(&moving(velocity_m_s, [0.0; 3]));
    let began_m = [1.0, 2.0, 3.0];
    bench.stands_at(began_m, [0.0; 3]);
    bench.start();
    let mut sent_m = [0.0; 3];
    for _ in 0..200 {
        let (output, trace) = bench.step();
        let Motion::Move { displacement_m, .. } = output.motion else {
            panic!("{output:?}");
        };
        for axis in 0..3 {
            sent_m[axis] += trace.sent_velocity[axis] * CYCLE_S;
            assert!((displacement_m[axis] - sent_m[axis]).abs() < 1e-12);
            let commanded_m = began_m[axis] + displacement_m[axis];
            assert!((trace.command_pose[axis] - commanded_m).abs() < 1e-12);
        }
    }
    let (_, trace) = bench.step();
    for axis in 0..3 {
        for velocity in [
            trace.model_velocity,
            trace.law_velocity,
            trace.sent_velocity,
        ] {
            assert!((velocity[axis] - velocity_m_s[axis]).abs() < 1e-9);
        }
    }
}

/// Velocities that are sent along x from the stop of a run on, m/s, until the robot holds at rest.
fn stop_m_s(bench: &mut Bench) -> Vec<f64> {
    let mut trace = bench.command(Command::Stop);
    let mut sent_m_s = Vec::new();
    while trace.sent_velocity[0] != 0.0 {
        assert_eq!((trace.mode, trace.fault), (Mode::Hold, None));
        sent_m_s.push(trace.sent_velocity[0]);
        assert!(sent_m_s.len() < 1000);
        trace = bench.step().1;
    }
    assert_eq!((trace.mode, trace.fault), (Mode::Hold, None));
    sent_m_s.push(0.0);
    sent_m_s
}

/// `stop_time_s` asks for 2 m/s², four times what the limits allow.
#[test]
fn a_stop_takes_as_long_as_the_limits_of_the_acceleration_ask_for() {
    let mut settings = moving([0.2, 0.0, 0.0], [0.0; 3]);
    settings.limits.acceleration_m_s2 = 0.5;
    settings.limits.box_m = [1.0; 3];
    settings.start.ramp_cycles = 200;
    (settings.jog.speed_m_s, settings.jog.reach_m) = (1e-3, 5e-3);
    let mut bench = Bench::new(&settings);
    bench.start();
    for _ in 0..250 {
        bench.step();
    }
    let sent_m_s = stop_m_s(&mut bench);
    for pair in sent_m_s.windows(2) {
        assert!(
            (pair[0] - pair[1]).abs() <= 0.5 * CYCLE_S + 1e-12,
            "{pair:?}"
        );
    }
    assert!((100..103).contains(&sent_m_s.len()), "{}", sent_m_s.len());
}

#[test]
fn a_stop_that_reaches_the_edge_of_the_box_fades_out() {
    let mut settings = moving([0.1, 0.0, 0.0], [0.0; 3]);
    settings.limits.clamp_fault_cycles = 5;
    settings.limits.box_m = [0.0125, 1.0, 1.0];
    settings.start.stop_time_s = 0.2;
    (settings.jog.speed_m_s, settings.jog.reach_m) = (1e-3, 5e-3);
    let mut bench = Bench::new(&settings);
    bench.start();
    for _ in 0..38 {
        assert_eq!(bench.step().1.limits, LimitFlags::default());
    }
    let sent_m_s = stop_m_s(&mut bench);
    assert!(sent_m_s.is_sorted_by(|a, b| a >= b), "{sent_m_s:?}");
}

/// Without a law the model feels the whole measured wrench.
#[test]
fn a_contact_that_is_felt_whole_leaves_no_impulse_unaccounted() {
    let mut bench = Bench::new(&moving([0.01, 0.0, 0.0], [0.0; 3]));
    bench.start();
    bench.inputs.sensor.wrench = [-5.0, 1.0, 2.0, 0.1, -0.2, 0.3];
    for _ in 0..100 {
        assert_eq!(bench.step().1.unaccounted_impulse, [0.0; 6]);
    }
    assert!(bench.cycle.bodies().1.k.velocity.linear.x < 0.01);
}

#[test]
fn a_contact_is_a_fault_until_the_ramp_of_the_start_has_ended() {
    let settings = Settings::default();
    let start = &settings.start;
    let ramp = start.zero_cycles + start.ramp_cycles;
    for (cycle, expected) in [
        (1, Some(FaultCode::ContactAtStart)),
        (ramp - 1, Some(FaultCode::ContactAtStart)),
        (ramp, None),
    ] {
        let mut bench = Bench::new(&settings);
        bench.start();
        for _ in 1..cycle {
            bench.step();
        }
        bench.inputs.sensor.wrench[0] = start.max_force_n * 1.01;
        let fault = bench.step().1.fault.map(|fault| fault.code);
        assert_eq!(fault, expected, "cycle {cycle} of the loop");
    }
}

#[test]
fn a_zero_takes_nothing_of_a_contact_that_a_motion_brought() {
    let mut bench = Bench::new(&moving([0.01, 0.0, 0.0], [0.0; 3]));
    bench.start();
    for contact_n in [0.0, 15.0] {
        bench.inputs.sensor.wrench[0] = contact_n;
        for _ in 0..100 {
            bench.step();
        }
    }
    stop_m_s(&mut bench);
    bench.inputs.sensor.wrench[0] = 0.0;
    let early = bench.command(Command::Zero);
    assert_eq!(early.refusal, Some(Refusal::TooFewSamples));
    for _ in 0..64 {
        bench.step();
    }
    assert_eq!(bench.command(Command::Zero).refusal, None);
    assert_eq!(bench.step().1.wrench_at_m, [0.0; 6]);
}

/// The angle B of a robot that rotates about y, towards the gimbal lock and away from it.
#[test]
fn a_turn_ends_before_the_gimbal_lock_and_goes_on_away_from_it() {
    let began = LARGEST_B_RAD - 0.01;
    for (side, spin, ends) in [
        (1.0, 0.047, true),
        (-1.0, -0.047, true),
        (1.0, -0.047, false),
        (-1.0, 0.047, false),
    ] {
        let mut bench = Bench::new(&moving([0.0; 3], [0.0, spin, 0.0]));
        bench.stands_at([0.0; 3], [0.0, side * began, 0.0]);
        bench.start();
        let mut ended = false;
        for _ in 0..80 {
            let (_, trace) = bench.step();
            let commanded = pose_from_components::<f64>(&trace.command_pose).rotation;
            let [_, b, _] = frames::abc_from_orientation(&commanded);
            assert!(b.abs() <= LARGEST_B_RAD + 1e-9, "{b}");
            ended |= trace.limits.has(LimitFlags::BOX);
            assert!(!ended || trace.sent_velocity[4] == 0.0);
        }
        assert_eq!(ended, ends, "from {side} with {spin} rad/s");
    }
}
