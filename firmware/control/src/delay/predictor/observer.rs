//! The observer: robot, contact load and model of a cycle in the axes of the robot.
//!
//! The robot model follows the commands that were sent; its positions are corrected by a fraction of their distance from the
//! measured ones. The pose that arrives may be L cycles older than the force that arrives with it: the model is extrapolated to
//! the time of the force, with commands that are already sent, for every L.

use super::axis_map::{AxisMap, positions, unwrapped};
use super::command_history::CommandHistory;
use super::least_squares::shrunk;
use super::noise::PositionNoise;
use super::robot_model::{RobotModel, RobotState};
use super::tuning::*;
use super::{M6, V6};
use crate::delay::LawInput;
use crate::frames::{Twist, Wrench};
use crate::scalar::Scalar;

/// State of the observer.
#[derive(Clone, Debug)]
pub(super) struct Observer {
    /// Number of the cycle since the law's first.
    pub(super) cycle: usize,
    pub(super) commands: CommandHistory,
    /// The robot model, at the time of the measured pose.
    pub(super) robot: RobotState,
    /// Commanded and measured positions.
    commanded: V6,
    pub(super) measured: V6,
    /// Measured position minus that of the model without feedback, and the sum of the corrections by feedback, m.
    pub(super) open_loop_error: V6,
    fed_back: V6,
    noise: PositionNoise,
    /// Measured position minus that of the corrected model, shrunk to what noise does not explain, m: after a pause of another
    /// length, for example.
    unlike_model: V6,
    /// The robot at the time of the force, and its position a cycle ago.
    pub(super) at_force: AtForce,
    pub(super) previous: [V6; LATENCIES],
    /// The full state of the robot at the time of the force for the believed latency, and that latency.
    believed_at_force: (usize, RobotState),
    /// Position of the model of the two spacecraft at the time of the force.
    pub(super) model: V6,
    /// Generalised contact load of this cycle and of the last one, N.
    pub(super) load: V6,
    pub(super) previous_load: V6,
    pub(super) map: AxisMap,
}

/// How the measured positions correct the robot model.
pub(super) struct Feedback {
    /// Fraction of an error that is corrected, and the standard deviation of a position from the approach, m.
    pub(super) gain: f64,
    pub(super) noise_m: f64,
    /// Free flight after the approach: changes of the error from one cycle to the next are noise.
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
        robot.position += measured;
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

    /// The next cycle: takes in what was sent and measured. Returns the last command.
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
        let error = self.measured - self.robot.position;
        self.open_loop_error = error + self.fed_back;
        self.noise.take(&error, feedback.in_flight);
        let corrected = error * feedback.gain;
        self.fed_back += corrected;
        self.robot.position += corrected;
        let (left, variance) = (error - corrected, self.noise.variance(feedback.noise_m));
        self.unlike_model =
            V6::from_fn(|i, _| shrunk(left[i], variance[i], INNOVATION_SIGNIFICANCE));
        command
    }

    /// Extrapolates the robot model to the time of the force, for each latency; keeps the full state for the believed one.
    pub(super) fn carry_on(&mut self, model: &RobotModel, believed: usize) {
        self.previous = self.at_force.position;
        let mut robot = self.robot;
        for l in 0..LATENCIES {
            self.at_force.position[l] = robot.position + self.unlike_model;
            self.at_force.velocity[l] = robot.velocity;
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

    /// Takes in a wrench at M in axes of M as generalised load on the axes, N.
    pub(super) fn take_load<S: Scalar>(&mut self, wrench: &Wrench<S>) {
        self.previous_load = self.load;
        self.load = self.map.load(wrench);
    }

    /// B: velocity of the axes per impulse on them, for both spacecraft in their present state.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::predictor::scene::robot;
    use crate::delay::spacecraft::{CYCLE_S, Spacecraft};
    use crate::dynamics::relative_velocity;
    use crate::frames::Pose;
    use crate::settings::BodySettings;
    use nalgebra::{UnitQuaternion, Vector3};

    /// Both spacecraft rotated, apart, and seen in a laboratory that is rotated as well.
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
    fn model(delay_cycles: f64, latency: f64) -> RobotModel {
        RobotModel::new(&robot(delay_cycles, 0.0, 0.0, 0.0), CYCLE_S, latency)
    }

    /// Observes for a cycle a robot that moves along x and turns about z; positions in m, and m of the lever.
    fn advance(
        observer: &mut Observer,
        model: &RobotModel,
        feedback: &Feedback,
        [measured, commanded]: [f64; 2],
    ) -> V6 {
        let at = |x: f64| {
            let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, x / ANGLE_LEVER_M);
            Pose::from_parts(Vector3::new(x, 0.0, 0.0).into(), turn)
        };
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

    /// At 5 mm/s, a micrometre or so off: a fraction of the distance is corrected in each cycle; without feedback the distance
    /// would have stayed.
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
                let found = observer.measured[axis] - observer.robot.position[axis];
                assert!((found - left).abs() < 1e-15, "{n}: {found}");
                assert!((observer.open_loop_error[axis] - apart).abs() < 1e-15);
                // Only what exceeds four standard deviations of noise counts.
                let unlike = shrunk(left, 1e-14, 4.0);
                assert!((observer.unlike_model[axis] - unlike).abs() < 1e-15, "{n}");
            }
            assert_eq!(observer.cycle, n as usize + 1);
        }
    }

    /// A pose that is two cycles old: the force is that of the position two cycles later.
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
                let robot = observer.robot_at_force(&model, l).position[0];
                assert_eq!(robot, position, "{n} {l}");
            }
        }
    }

    /// A distance of the measured robot from its model is the same at the time of the force.
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
}
