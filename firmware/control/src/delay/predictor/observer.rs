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

use super::least_squares::shrunk;
use super::robot_model::{CommandHistory, RobotModel, RobotState};
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
