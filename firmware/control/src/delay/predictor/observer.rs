//! The observer: robot, contact load and model of a cycle in the axes of the robot, and what noise they carry.
//!
//! The law works in the robot's axes X Y Z A B C, because its delay and its pauses are those of its axes.
//! Angles are multiplied by a length, and so become metres, and torques forces: all six are then of one size,
//! and a contact beside the centre is a contact along one direction of six.
//!
//! The robot model follows the commands that were sent; its positions are corrected by a share of their
//! distance from the measured ones. The pose that arrives may be L cycles older than the force that arrives
//! with it: the model is carried on to the time of the force, with commands that are already sent, for each L
//! at once.

use super::command_history::CommandHistory;
use super::least_squares::shrunk;
use super::robot_model::{RobotModel, RobotState};
use super::tuning::*;
use super::{M6, V6};
use crate::delay::LawInput;
use crate::frames::{Pose, Twist, Wrench, abc_from_orientation};
use crate::scalar::Scalar;
use nalgebra::{ComplexField, Matrix3, Vector3};

/// What is observed from cycle to cycle.
#[derive(Clone, Debug)]
pub(super) struct Observer {
    /// Number of the cycle since the law's first.
    pub(super) cycle: usize,
    pub(super) commands: CommandHistory,
    /// The robot model, at the time of the measured pose.
    pub(super) robot: RobotState,
    /// Where the commands have led, and what is measured.
    commanded: V6,
    pub(super) measured: V6,
    /// Measured position less that of the model without feedback, and what feedback has given it, m.
    pub(super) open_loop_error: V6,
    fed_back: V6,
    noise: PositionNoise,
    /// Measured position less that of the corrected model as far as it is no noise, m: after a pause of another length, for one.
    unlike_model: V6,
    /// The robot at the time of the force, and its position a cycle ago.
    pub(super) at_force: AtForce,
    pub(super) previous: [V6; LATENCIES],
    /// The whole state of it, for the believed latency.
    believed_at_force: (usize, RobotState),
    /// Where the model of the two spacecraft is, at the time of the force.
    pub(super) model: V6,
    /// Generalised contact load of this cycle and of the last one, N.
    pub(super) load: V6,
    pub(super) previous_load: V6,
    pub(super) map: AxisMap,
}

/// How the measured positions correct the robot model.
pub(super) struct Feedback {
    /// Part of an error that is taken, and the standard deviation of a position along the approach, m.
    pub(super) gain: f64,
    pub(super) noise_m: f64,
    /// Free flight after the approach: what positions differ by from one cycle to the next is noise.
    pub(super) in_flight: bool,
}

/// The robot at the time of the force, for each latency.
#[derive(Clone, Copy, Debug)]
pub(super) struct AtForce {
    pub(super) position: [V6; LATENCIES],
    pub(super) velocity: [V6; LATENCIES],
    /// A pause ended within the last cycle.
    pub(super) resumed: [bool; LATENCIES],
}

impl Observer {
    /// The first cycle: at rest.
    pub(super) fn new<S: Scalar>(input: &LawInput<'_, S>) -> Self {
        let (measured, abc) = positions(input.measured);
        let mut robot = RobotState::default();
        robot.shift(&measured);
        let at_rest = AtForce {
            position: [measured; LATENCIES],
            velocity: [V6::zeros(); LATENCIES],
            resumed: [false; LATENCIES],
        };
        Self {
            cycle: 0,
            commands: CommandHistory::new(),
            robot,
            commanded: unwrapped(positions(input.commanded).0, &measured),
            measured,
            open_loop_error: V6::zeros(),
            fed_back: V6::zeros(),
            noise: PositionNoise::default(),
            unlike_model: V6::zeros(),
            at_force: at_rest,
            previous: at_rest.position,
            believed_at_force: (0, robot),
            model: measured,
            load: V6::zeros(),
            previous_load: V6::zeros(),
            map: AxisMap::at(input.measured, abc),
        }
    }

    /// The next cycle: what was sent, what is measured. Answers the last command.
    pub(super) fn advance<S: Scalar>(
        &mut self,
        input: &LawInput<'_, S>,
        model: &RobotModel,
        feedback: &Feedback,
    ) -> V6 {
        let (measured, abc) = positions(input.measured);
        self.map = AxisMap::at(input.measured, abc);
        self.measured = unwrapped(measured, &self.measured);
        let commanded = unwrapped(positions(input.commanded).0, &self.commanded);
        let command = (commanded - self.commanded) / model.cycle_s;
        self.commanded = commanded;
        self.commands.push(&command);
        self.robot.step_sent(model, &self.commands, self.cycle);
        self.cycle += 1;
        let error = self.measured - self.robot.position();
        self.open_loop_error = error + self.fed_back;
        self.noise.take(&error, feedback.in_flight);
        let corrected = error * feedback.gain;
        self.fed_back += corrected;
        self.robot.shift(&corrected);
        let (left, variance) = (error - corrected, self.noise.variance(feedback.noise_m));
        self.unlike_model =
            V6::from_fn(|i, _| shrunk(left[i], variance[i], INNOVATION_SIGNIFICANCE));
        command
    }

    /// Carries the robot model on to the time of the force, for each latency; one of them is believed.
    pub(super) fn carry_on(&mut self, model: &RobotModel, believed: usize) {
        self.previous = self.at_force.position;
        let mut robot = self.robot;
        for l in 0..LATENCIES {
            self.at_force.position[l] = robot.position() + self.unlike_model;
            self.at_force.velocity[l] = robot.velocity();
            self.at_force.resumed[l] = robot.resumed();
            if l == believed {
                self.believed_at_force = (l, robot);
            }
            robot.step_sent(model, &self.commands, self.cycle + l);
        }
    }

    /// The robot model at the time of the force.
    pub(super) fn robot_at_force(&self, model: &RobotModel, latency: usize) -> RobotState {
        if self.believed_at_force.0 == latency {
            return self.believed_at_force.1;
        }
        let mut robot = self.robot;
        for l in 0..latency {
            robot.step_sent(model, &self.commands, self.cycle + l);
        }
        robot
    }

    /// A wrench at M in axes of M as a load on the axes, N.
    pub(super) fn take_load<S: Scalar>(&mut self, wrench: &Wrench<S>) {
        self.previous_load = self.load;
        self.load = self.map.load(wrench);
    }

    /// B: velocity of the axes per impulse on them, of both spacecraft as they are.
    pub(super) fn mobility<S: Scalar>(&self, input: &LawInput<'_, S>) -> M6 {
        let state = input.state;
        let (k, q) = (&state.k.c_from_body.rotation, &state.q.c_from_body.rotation);
        let lab_from_k = input.c_from_q * q.inverse() * k;
        let mut of_wrench = M6::zeros();
        for column in 0..6 {
            let mut unit = [0.0; 6];
            unit[column] = 1.0;
            let twist = input.bodies.mobility(state, &Wrench::of(&unit));
            let linear = lab_from_k * twist.linear;
            let values = Twist {
                linear,
                angular: twist.angular,
            };
            of_wrench.set_column(column, &V6::from(values.get()));
        }
        self.map.mobility(&of_wrench)
    }
}

/// The map between axes and body at an orientation.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisMap {
    /// ω in M = `body_from_axes` · (A', B', C').
    body_from_axes: Matrix3<f64>,
    axes_from_body: Matrix3<f64>,
    c_from_m: Matrix3<f64>,
}

impl AxisMap {
    /// At a pose with the angles A, B, C (rad).
    fn at<S: Scalar>(pose: &Pose<S>, [_, b, c]: [f64; 3]) -> Self {
        let (sb, cb) = (ComplexField::sin(b), ComplexField::cos(b));
        let (sc, cc) = (ComplexField::sin(c), ComplexField::cos(c));
        let body_from_axes = Matrix3::new(-sb, 0.0, 1.0, cb * sc, cc, 0.0, cb * cc, -sc, 0.0);
        // B stays off ±90°, see `Refusal::OrientationSingular`.
        let safe = if cb.abs() < 1e-3 { 1e-3 } else { cb };
        let (along, across) = (sc / safe, cc / safe);
        let axes_from_body = Matrix3::new(
            0.0,
            along,
            across,
            0.0,
            cc,
            -sc,
            1.0,
            along * sb,
            across * sb,
        );
        Self {
            body_from_axes,
            axes_from_body,
            c_from_m: pose.rotation.to_rotation_matrix().matrix().map(S::get),
        }
    }

    /// Velocity of the axes, from linear in C and angular in M.
    pub(super) fn velocity<S: Scalar>(&self, twist: &Twist<S>) -> V6 {
        let [x, y, z, a, b, c] = twist.get();
        let rates = self.axes_from_body * Vector3::new(a, b, c) * ANGLE_LEVER_M;
        V6::new(x, y, z, rates.x, rates.y, rates.z)
    }

    /// The twist of a velocity of the axes.
    pub(super) fn twist<S: Scalar>(&self, v: &V6) -> Twist<S> {
        let spin = self.body_from_axes * Vector3::new(v[3], v[4], v[5]) / ANGLE_LEVER_M;
        Twist::of(&[v[0], v[1], v[2], spin.x, spin.y, spin.z])
    }

    /// Generalised forces of a wrench at M in axes of M.
    fn load<S: Scalar>(&self, wrench: &Wrench<S>) -> V6 {
        let [x, y, z, a, b, c] = wrench.get();
        let (force, torque) = (self.c_from_m * Vector3::new(x, y, z), Vector3::new(a, b, c));
        let t = self.body_from_axes.transpose() * torque / ANGLE_LEVER_M;
        V6::new(force.x, force.y, force.z, t.x, t.y, t.z)
    }

    /// The wrench at M of generalised forces.
    pub(super) fn wrench<S: Scalar>(&self, load: &V6) -> Wrench<S> {
        let force = self.c_from_m.transpose() * Vector3::new(load[0], load[1], load[2]);
        let torque = Vector3::new(load[3], load[4], load[5]);
        let torque = self.axes_from_body.transpose() * torque * ANGLE_LEVER_M;
        Wrench::of(&[force.x, force.y, force.z, torque.x, torque.y, torque.z])
    }

    /// Velocity of the axes per generalised impulse, from that of a twist (linear in C, angular in
    /// M) per impulsive wrench at M in axes of M.
    fn mobility(&self, of_wrench: &M6) -> M6 {
        let rates = self.axes_from_body * ANGLE_LEVER_M;
        let torques = self.axes_from_body.transpose() * ANGLE_LEVER_M;
        let mut velocity = M6::identity();
        velocity.fixed_view_mut::<3, 3>(3, 3).copy_from(&rates);
        let mut wrench = M6::zeros();
        let forces = self.c_from_m.transpose();
        wrench.fixed_view_mut::<3, 3>(0, 0).copy_from(&forces);
        wrench.fixed_view_mut::<3, 3>(3, 3).copy_from(&torques);
        velocity * of_wrench * wrench
    }
}

/// Positions of the axes, m and m of the lever, and the angles A, B, C, rad.
fn positions<S: Scalar>(pose: &Pose<S>) -> (V6, [f64; 3]) {
    let t = &pose.translation.vector;
    let abc = abc_from_orientation(&pose.rotation).map(S::get);
    let [a, b, c] = abc.map(|angle| angle * ANGLE_LEVER_M);
    (V6::new(t.x.get(), t.y.get(), t.z.get(), a, b, c), abc)
}

/// The same positions with angles within half a turn of others.
fn unwrapped(mut positions: V6, near: &V6) -> V6 {
    let turn = core::f64::consts::TAU * ANGLE_LEVER_M;
    for i in 3..6 {
        let turns = ComplexField::round((near[i] - positions[i]) / turn);
        positions[i] += turns * turn;
    }
    positions
}

/// Noise of the measured positions: mean squares of their differences from one cycle to the next.
#[derive(Clone, Debug, Default)]
struct PositionNoise {
    /// Distance from the model, m.
    apart: V6,
    squares: V6,
    count: f64,
}

impl PositionNoise {
    /// A cycle's distance, and whether its change is noise.
    fn take(&mut self, apart: &V6, is_noise: bool) {
        let change = apart - self.apart;
        self.apart = *apart;
        if is_noise {
            self.squares += change.component_mul(&change);
            self.count += 1.0;
        }
    }

    /// Of a position of each axis, m²; until it is known that of one along the approach, `noise_m`.
    fn variance(&self, noise_m: f64) -> V6 {
        if self.count < NOISE_SAMPLES {
            return V6::repeat(noise_m * noise_m);
        }
        self.squares / (2.0 * self.count)
    }
}

/// Noise of the load: running mean squares of the six in free flight, about zero, because a load that is there
/// without a contact is an error as well.
#[derive(Clone, Debug)]
pub(super) struct LoadNoise {
    least: f64,
    squares: V6,
    count: f64,
}

impl LoadNoise {
    /// `least` standard deviation that is assumed, N.
    pub(super) fn new(least: f64) -> Self {
        Self {
            least,
            squares: V6::zeros(),
            count: 0.0,
        }
    }

    /// A load in free flight.
    pub(super) fn add(&mut self, load: &V6) {
        self.squares += load.component_mul(load);
        self.count += 1.0;
    }

    /// Largest standard deviation of the six, N.
    pub(super) fn sigma(&self) -> f64 {
        if self.count < NOISE_SAMPLES {
            return self.least;
        }
        ComplexField::sqrt(self.squares.amax() / self.count).max(self.least)
    }

    /// Size of a load that does not come from noise, N: of the loudest of the six, and of the others
    /// together.
    pub(super) fn threshold(&self) -> f64 {
        let largest = self.sigma();
        if self.count < NOISE_SAMPLES {
            return LOAD_SIGNIFICANCE * largest;
        }
        let others = (self.squares.sum() - self.squares.amax()).max(0.0) / self.count;
        LOAD_SIGNIFICANCE * largest + ComplexField::sqrt(others)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::actuator::ActuatorSettings;
    use crate::delay::spacecraft::{CYCLE_S, Spacecraft};
    use crate::dynamics::{advanced, relative_velocity};
    use crate::settings::BodySettings;
    use nalgebra::UnitQuaternion;

    fn pose(position: [f64; 3], angles: [f64; 3]) -> Pose<f64> {
        let [a, b, c] = angles;
        Pose::from_parts(
            Vector3::from(position).into(),
            UnitQuaternion::from_euler_angles(c, b, a),
        )
    }

    fn map(pose: &Pose<f64>) -> AxisMap {
        AxisMap::at(pose, positions(pose).1)
    }

    /// Turned by large angles about all axes.
    fn poses() -> [Pose<f64>; 4] {
        [
            pose([0.1, 0.2, 0.3], [0.0, 0.0, 0.0]),
            pose([-1.0, 0.5, 2.0], [0.7, -0.4, 1.1]),
            pose([0.0, 0.0, 1.0], [-2.5, 1.3, -2.0]),
            pose([0.3, -0.1, 0.0], [1.5, -1.2, 3.0]),
        ]
    }

    fn twist() -> Twist<f64> {
        Twist::of(&[0.01, -0.02, 0.03, 0.05, -0.04, 0.02])
    }

    #[test]
    fn the_velocity_of_the_axes_is_the_rate_of_their_positions() {
        for pose in poses() {
            let velocity = map(&pose).velocity(&twist());
            let (at, _) = positions(&pose);
            let later = positions(&advanced(&pose, &twist(), 1e-4)).0;
            let earlier = positions(&advanced(&pose, &twist(), -1e-4)).0;
            let rate = (later - earlier) / 2e-4;
            assert!((rate - velocity).amax() < 1e-7, "{pose}: {rate} {velocity}");
            assert_eq!(at.fixed_rows::<3>(0), pose.translation.vector);
            let back = map(&pose).twist::<f64>(&velocity).get();
            let apart = V6::from(back) - V6::from(twist().get());
            assert!(apart.amax() < 1e-15, "{apart}");
        }
    }

    /// A load of the axes does the work of its wrench.
    #[test]
    fn a_wrench_and_its_load_have_the_same_power() {
        let wrench = Wrench::of(&[3.0, -5.0, 2.0, 1.0, 0.5, -2.0]);
        for pose in poses() {
            let map = map(&pose);
            let load = map.load(&wrench);
            let force = pose.rotation * wrench.force;
            let power = force.dot(&twist().linear) + wrench.torque.dot(&twist().angular);
            let found = load.dot(&map.velocity(&twist()));
            assert!((found - power).abs() < 1e-14, "{found} {power}");
            let back = V6::from(map.wrench::<f64>(&load).get()) - V6::from(wrench.get());
            assert!(back.amax() < 1e-14, "{back}");
        }
    }

    /// Where A and C are the same axis their rates would have no end.
    #[test]
    fn at_the_gimbal_lock_the_rates_of_the_axes_are_bounded() {
        for b in [90.0_f64, -90.0, 89.99] {
            let angles = [0.3, b.to_radians(), 0.2];
            let map = AxisMap::at(&pose([0.0; 3], angles), angles);
            let velocity = map.velocity(&twist());
            assert!(velocity.amax() < 1e3 * 0.07 * ANGLE_LEVER_M, "{velocity}");
        }
    }

    /// Both turned, apart, and seen in a laboratory that is turned as well.
    #[test]
    fn the_mobility_is_what_an_impulse_changes_of_the_velocity() {
        let body = |mass_kg, position_m, orientation_wxyz| BodySettings {
            mass_kg,
            position_m,
            orientation_wxyz,
            inertia_kg_m2: [[80.0, 5.0, 0.0], [5.0, 120.0, -10.0], [0.0, -10.0, 60.0]],
            ..BodySettings::default()
        };
        let k = body(300.0, [0.5, -0.3, 0.2], [0.8, 0.3, -0.4, 0.33]);
        let q = body(700.0, [0.0; 3], [0.7, -0.2, 0.5, 0.4]);
        let mut spacecraft = Spacecraft::new(&k, &q);
        let c_from_q = UnitQuaternion::from_euler_angles(0.4, -0.9, 0.6);
        spacecraft.measured =
            Pose::from_parts(Vector3::zeros().into(), c_from_q) * spacecraft.measured;
        let wrench = Wrench::of(&[30.0, -50.0, 20.0, 10.0, 5.0, -20.0]);
        let mut input = spacecraft.input(&wrench);
        input.c_from_q = c_from_q;
        let observer = Observer::new(&input);
        let found = observer.mobility(&input) * observer.map.load(&wrench);
        let map = observer.map;
        let state = spacecraft.bodies.step(&spacecraft.state, &wrench).0;
        let mut change = relative_velocity(&state.k, &state.q);
        change.linear = c_from_q * change.linear;
        let expected = map.velocity(&change) / CYCLE_S;
        let apart = (found - expected).amax();
        assert!(apart < 1e-4 * expected.amax(), "{found} {expected}");
    }

    #[test]
    fn an_angle_goes_on_beyond_half_a_turn() {
        let at = |degrees: f64| V6::repeat(degrees.to_radians() * ANGLE_LEVER_M);
        for (measured, near, expected) in [
            (-179.0, 179.0, 181.0),
            (179.0, -179.0, -181.0),
            (10.0, 725.0, 730.0),
            (10.0, 20.0, 10.0),
        ] {
            let found = unwrapped(at(measured), &at(near));
            let kept = at(measured).fixed_rows::<3>(0).into_owned();
            assert_eq!(found.fixed_rows::<3>(0), kept);
            let angles = found.fixed_rows::<3>(3) - at(expected).fixed_rows::<3>(3);
            assert!(angles.amax() < 1e-12, "{measured} {near}: {found}");
        }
    }

    fn model(delay_cycles: f64, latency: f64) -> RobotModel {
        let actuator = ActuatorSettings {
            delay_s: delay_cycles * CYCLE_S,
            ..ActuatorSettings::default()
        };
        RobotModel::new(&actuator, CYCLE_S, latency)
    }

    /// Observes a robot that moves along x and turns about z by positions in m and m of the lever, for a cycle.
    fn advance(
        observer: &mut Observer,
        model: &RobotModel,
        feedback: &Feedback,
        [measured, commanded]: [f64; 2],
    ) -> V6 {
        let at = |x: f64| pose([x, 0.0, 0.0], [x / ANGLE_LEVER_M, 0.0, 0.0]);
        let mut spacecraft = Spacecraft::before_a_wall([0.0; 3]);
        spacecraft.measured = at(measured);
        let (wrench, commanded) = (Wrench::zero(), at(commanded));
        let mut input = spacecraft.input(&wrench);
        input.commanded = &commanded;
        observer.advance(&input, model, feedback)
    }

    fn observer() -> Observer {
        let (spacecraft, wrench) = (Spacecraft::before_a_wall([0.0; 3]), Wrench::zero());
        Observer::new(&spacecraft.input(&wrench))
    }

    /// At 5 mm/s, a micrometre or so beside it: a share of the distance is taken in each cycle, and without feedback it would
    /// have stayed.
    #[test]
    fn the_robot_model_comes_closer_to_the_measured_robot_by_a_share_in_each_cycle() {
        let (mut observer, model) = (observer(), model(3.0, 0.0));
        let (step, apart, gain) = (0.005 * CYCLE_S, 1.5e-6, 0.3);
        for n in 0..20 {
            let feedback = Feedback {
                gain,
                noise_m: 1e-7,
                in_flight: false,
            };
            let commanded = step * f64::from(n + 1);
            let moved = step * f64::from((n + 1 - 3).max(0));
            let command = advance(&mut observer, &model, &feedback, [moved + apart, commanded]);
            for axis in [0, 3] {
                assert!((command[axis] - 0.005).abs() < 1e-12);
                let left = apart * (1.0 - gain).powi(n + 1);
                let found = observer.measured[axis] - observer.robot.position()[axis];
                assert!((found - left).abs() < 1e-15, "{n}: {found}");
                assert!((observer.open_loop_error[axis] - apart).abs() < 1e-15);
                // What is more than four standard deviations of noise is no noise.
                let unlike = shrunk(left, 1e-14, 4.0);
                assert!((observer.unlike_model[axis] - unlike).abs() < 1e-15, "{n}");
            }
            assert_eq!(observer.cycle, n as usize + 1);
        }
    }

    /// A pose that is two cycles old: the force acts where the robot will be two cycles later.
    #[test]
    fn the_robot_is_carried_on_to_the_time_of_the_force() {
        let (mut observer, model) = (observer(), model(3.0, 2.0));
        let way = |cycle: i32| 1e-6 * f64::from(cycle.max(0)).powi(2);
        for n in 1..30 {
            let before = observer.at_force.position;
            let feedback = Feedback {
                gain: 0.0,
                noise_m: 1.0,
                in_flight: false,
            };
            advance(&mut observer, &model, &feedback, [way(n - 5), way(n)]);
            observer.carry_on(&model, 1);
            assert_eq!(observer.previous, before);
            for l in 0..LATENCIES {
                let cycle = n - 5 + l as i32;
                let position = observer.at_force.position[l][0];
                assert!((position - way(cycle)).abs() < 1e-15, "{n} {l}: {position}");
                let rate = (way(cycle) - way(cycle - 1)) / CYCLE_S;
                let velocity = observer.at_force.velocity[l][0];
                assert!(
                    (velocity - rate).abs() < 1e-12,
                    "{n} {l}: {velocity} {rate}"
                );
                assert!(!observer.at_force.resumed[l]);
                let robot = observer.robot_at_force(&model, l).position()[0];
                assert_eq!(robot, position, "{n} {l}");
            }
        }
    }

    /// What the measured robot lacks of its model is lacking at the time of the force as well.
    #[test]
    fn a_robot_that_is_not_where_its_model_is_is_taken_from_the_measurement() {
        let (mut observer, model) = (observer(), model(3.0, 2.0));
        let feedback = Feedback {
            gain: 0.25,
            noise_m: 0.0,
            in_flight: false,
        };
        advance(&mut observer, &model, &feedback, [1e-4, 0.0]);
        observer.carry_on(&model, 0);
        for position in observer.at_force.position {
            assert!((position[0] - 1e-4).abs() < 1e-15, "{position}");
        }
    }

    #[test]
    fn the_last_load_is_kept() {
        let mut observer = observer();
        let wrench = |x: f64| Wrench::<f64>::of(&[x, 0.0, 0.0, 0.0, 0.0, 0.0]);
        observer.take_load(&wrench(1.0));
        observer.take_load(&wrench(2.0));
        assert_eq!((observer.previous_load[0], observer.load[0]), (1.0, 2.0));
    }

    /// Two positions' noise makes the difference between two cycles: half of its mean square, of what is noise, from 16 on.
    #[test]
    fn the_noise_of_a_position_is_half_of_what_it_changes_by() {
        let mut noise = PositionNoise::default();
        let at =
            |n: i32| V6::new(1.0, -2.0, 0.0, 0.5, 0.0, 0.0) * if n % 2 == 0 { 1e-6 } else { -1e-6 };
        noise.take(&at(0), false);
        for n in 1..=16 {
            assert_eq!(noise.variance(3e-6), V6::repeat(3e-6 * 3e-6), "{n}");
            noise.take(&(V6::repeat(1.0)), false);
            noise.take(&at(n - 1), false);
            noise.take(&at(n), true);
        }
        let expected = at(0).component_mul(&at(0)) * 2.0;
        assert!((noise.variance(3e-6) - expected).amax() < 1e-24);
    }

    /// The loudest of the six by four and a half, and the others together; from 16 on, and no less than is set.
    #[test]
    fn a_load_is_significant_beyond_the_noise_of_free_flight() {
        let loads = |count: i32, size: f64| {
            let mut noise = LoadNoise::new(0.2);
            for n in 0..count {
                let sign = if n % 2 == 0 { size } else { -size };
                noise.add(&(V6::new(3.0, -2.0, 0.0, 6.0, 1.0, -2.0) * sign));
            }
            noise
        };
        for (noise, sigma, threshold) in [
            (loads(0, 1.0), 0.2, 0.9),
            (loads(15, 1.0), 0.2, 0.9),
            (loads(16, 1.0), 6.0, 27.0 + 18.0_f64.sqrt()),
            (loads(100, 1.0), 6.0, 27.0 + 18.0_f64.sqrt()),
            (loads(100, 0.01), 0.2, 0.9 + 0.01 * 18.0_f64.sqrt()),
        ] {
            assert!((noise.sigma() - sigma).abs() < 1e-12, "{}", noise.sigma());
            assert!(
                (noise.threshold() - threshold).abs() < 1e-12,
                "{}",
                noise.threshold()
            );
        }
    }
}
