//! Robot, load and model of a cycle in the coordinates of the law, and the twin that goes with them.

use super::bank::Places;
use super::coordinates::{Map, positions, unwrapped};
use super::twin::{Axes, Commands, Plan};
use super::{LATENCIES, M6, V6};
use crate::delay::LawInput;
use crate::frames::{Twist, Wrench};
use crate::scalar::Scalar;
use nalgebra::Matrix3;

/// What is followed from cycle to cycle.
#[derive(Clone, Debug)]
pub(super) struct Flight {
    /// Number of the cycle since the law's first.
    pub(super) cycle: usize,
    pub(super) commands: Commands,
    /// The twin, at the time of the measured pose.
    pub(super) axes: Axes,
    /// Where the commands have led.
    commanded: V6,
    pub(super) measured: V6,
    /// Measured position less that of the twin without feedback, and what feedback has given it, m.
    pub(super) residual: V6,
    taken_over: V6,
    /// Where the robot is at the time of the force, at each latency, and where it was a cycle ago.
    pub(super) places: Places,
    pub(super) before: [V6; LATENCIES],
    /// The twin at the time of the force, for a latency.
    looked: (usize, Axes),
    /// Where the model is, at the time of the force.
    pub(super) model: V6,
    /// Generalised contact load of this cycle and of the last one, N.
    pub(super) load: V6,
    pub(super) load_before: V6,
    map: Map,
    c_from_m: Matrix3<f64>,
}

impl Flight {
    /// The first cycle: at rest.
    pub(super) fn new<S: Scalar>(input: &LawInput<'_, S>) -> Self {
        let (measured, abc) = positions(input.measured);
        let (commanded, _) = positions(input.commanded);
        let mut axes = Axes::default();
        axes.shift(&measured);
        let still = Places {
            position: [measured; LATENCIES],
            velocity: [V6::zeros(); LATENCIES],
            resumed: [false; LATENCIES],
        };
        Self {
            cycle: 0,
            commands: Commands::new(),
            axes,
            commanded: unwrapped(commanded, &measured),
            measured,
            residual: V6::zeros(),
            taken_over: V6::zeros(),
            places: still,
            before: still.position,
            looked: (0, axes),
            model: measured,
            load: V6::zeros(),
            load_before: V6::zeros(),
            map: Map::at(abc),
            c_from_m: rotation(input.measured),
        }
    }

    /// The next cycle: what was sent, what is measured. Answers the last command.
    pub(super) fn advance<S: Scalar>(
        &mut self,
        input: &LawInput<'_, S>,
        plan: &Plan,
        observer: f64,
    ) -> V6 {
        let (measured, abc) = positions(input.measured);
        self.measured = unwrapped(measured, &self.measured);
        self.map = Map::at(abc);
        self.c_from_m = rotation(input.measured);
        let (commanded, _) = positions(input.commanded);
        let commanded = unwrapped(commanded, &self.commanded);
        let command = (commanded - self.commanded) / plan.cycle_s;
        self.commanded = commanded;
        self.commands.push(&command);
        self.axes.step_sent(plan, &self.commands, self.cycle);
        self.cycle += 1;
        let error = self.measured - self.axes.position();
        self.residual = error + self.taken_over;
        self.taken_over += error * observer;
        self.axes.shift(&(error * observer));
        command
    }

    /// Follows the twin to the time of the force, for each latency; one of them is believed.
    pub(super) fn look(&mut self, plan: &Plan, believed: usize) {
        self.before = self.places.position;
        let mut axes = self.axes;
        for l in 0..LATENCIES {
            self.places.position[l] = axes.position();
            self.places.velocity[l] = axes.velocity();
            self.places.resumed[l] = axes.0.iter().any(|axis| axis.resumed());
            if l == believed {
                self.looked = (l, axes);
            }
            axes.step_sent(plan, &self.commands, self.cycle + l);
        }
    }

    /// The twin at the time of the force.
    pub(super) fn at_force(&self, plan: &Plan, latency: usize) -> Axes {
        if self.looked.0 == latency {
            return self.looked.1;
        }
        let mut axes = self.axes;
        for l in 0..latency {
            axes.step_sent(plan, &self.commands, self.cycle + l);
        }
        axes
    }

    /// A wrench at M in axes of M as a load on the axes, N.
    pub(super) fn take_load<S: Scalar>(&mut self, wrench: &Wrench<S>) {
        self.load_before = self.load;
        self.load = self.map.load(wrench, &self.c_from_m);
    }

    pub(super) fn velocity<S: Scalar>(&self, twist: &Twist<S>) -> V6 {
        self.map.velocity(twist)
    }

    pub(super) fn twist<S: Scalar>(&self, velocity: &V6) -> Twist<S> {
        self.map.twist(velocity)
    }

    pub(super) fn wrench<S: Scalar>(&self, load: &V6) -> Wrench<S> {
        self.map.wrench(load, &self.c_from_m)
    }

    /// Velocity of the axes per impulse on them.
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
        self.map.mobility(&of_wrench, &self.c_from_m)
    }
}

fn rotation<S: Scalar>(pose: &crate::frames::Pose<S>) -> Matrix3<f64> {
    pose.rotation.to_rotation_matrix().matrix().map(S::get)
}
