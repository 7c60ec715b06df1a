//! A robot in a contact for the tests of its command, and its future motion by a second, slower computation.

use super::V6;
use super::command_history::CommandHistory;
use super::contact_estimator::Estimate;
use super::control_problem::ControlProblem;
use super::dynamic_matrix::DynamicMatrix;
use super::reference::Reference;
use super::reversals::Reversals;
use super::robot_model::{RobotModel, RobotState};
use super::stiffening::Curve;
use super::tuning::*;
use crate::delay::actuator::ActuatorSettings;
use crate::delay::spacecraft::CYCLE_S;
use nalgebra::{SMatrix, SVector};

/// All that a command depends on: a robot in a contact, with earlier commands that do not quite fit the reference.
pub(super) struct Scene {
    pub(super) model: RobotModel,
    pub(super) commands: CommandHistory,
    pub(super) latency: usize,
    pub(super) robot: RobotState,
    pub(super) velocity: V6,
    pub(super) reference: Reference,
    pub(super) contact: Estimate,
    pub(super) curve: Option<Curve>,
}

/// Cycles before this one.
pub(super) const CYCLE: usize = 60;

impl Scene {
    /// Into a spring and damper with 500 kg, `since` cycles after the onset, oblique to all axes; the robot has moved
    /// approximately as it should.
    pub(super) fn new(actuator: &ActuatorSettings, latency: usize, zeta: f64, since: f64) -> Self {
        let model = RobotModel::new(actuator, CYCLE_S, latency as f64);
        let (contact, reference) = oblique(zeta, CYCLE as f64 - since);
        let before = reference.velocity;
        let mut commands = CommandHistory::new();
        for n in 0..CYCLE {
            let wave = (n as f64 * 0.7).sin();
            commands.push(&(before + V6::new(1.0, -0.5, 2.0, 0.3, -1.0, 0.4) * (5e-4 * wave)));
        }
        let mut robot = RobotState::default();
        (0..CYCLE + latency).for_each(|n| robot.step_sent(&model, &commands, n));
        let place = reference.position_at(CYCLE as f64, CYCLE_S) + V6::repeat(1e-6);
        robot.position += place - robot.position;
        let [deviation] = reference.deviations(CYCLE as f64, CYCLE_S);
        Self {
            model,
            commands,
            latency,
            robot,
            velocity: before - contact.push * (deviation.velocity * 1.1),
            reference,
            contact,
            curve: None,
        }
    }

    /// Into a wall across the first axis, of this frequency (rad/s) and damping ratio, with the robot where it should be.
    pub(super) fn straight(
        actuator: &ActuatorSettings,
        (omega, zeta): (f64, f64),
        since: f64,
    ) -> Self {
        let mut scene = Self::new(actuator, 0, 0.0, since);
        let mass = scene.contact.mass;
        scene.contact = Estimate::exact(mass * omega * omega, 2.0 * zeta * mass * omega, mass);
        let along = V6::ith(0, 1.0);
        scene.contact.surface = 0.1;
        let (onset, before) = (scene.reference.onset, along * 0.005);
        scene.reference =
            Reference::into_contact(&scene.contact, (onset, along * 0.1), (before, 0.005));
        let [deviation] = scene.reference.deviations(CYCLE as f64, CYCLE_S);
        scene.velocity = before - along * deviation.velocity;
        for n in 0..COMMAND_HISTORY {
            let ahead = scene.model.execution_delay(0) - (COMMAND_HISTORY - n) as f64;
            let at = |cycle: f64| scene.reference.position_at(CYCLE as f64 + cycle, CYCLE_S);
            let velocity = (at(ahead + 1.0) - at(ahead)) / CYCLE_S;
            scene.commands.push(&velocity);
        }
        scene.commands.next = CYCLE;
        let place = scene.reference.position_at(CYCLE as f64, CYCLE_S);
        scene.robot.position += place - scene.robot.position;
        scene
    }

    pub(super) fn ask<T>(&self, answer: impl FnOnce(&ControlProblem<'_>) -> T) -> T {
        let matrix = DynamicMatrix::new(&self.model, self.latency);
        answer(&ControlProblem {
            cycle: CYCLE,
            model: &self.model,
            commands: &self.commands,
            matrix: &matrix,
            latency: self.latency,
            robot: self.robot,
            velocity: self.velocity,
            reference: self.reference,
            contact: Some(self.contact),
            reversals: Reversals::default(),
            latest: self.latency,
            curve: self.curve,
        })
    }

    /// Velocity of the reference at the time at which the robot executes the command of `ahead` cycles from now.
    pub(super) fn base(&self, ahead: usize) -> V6 {
        let executed = CYCLE as f64 + self.model.execution_delay(self.latency) + ahead as f64;
        let at = |cycle: f64| self.reference.position_at(cycle, CYCLE_S);
        (at(executed + 1.0) - at(executed)) / CYCLE_S
    }

    /// Positions of the robot over the horizon if these commands are added to those of the reference.
    pub(super) fn positions(&self, more: &[V6]) -> Vec<V6> {
        let motion = self.motion(more).into_iter();
        motion.map(|(position, _)| position).collect()
    }

    /// The same, with the velocities that are sampled then.
    pub(super) fn motion(&self, more: &[V6]) -> Vec<(V6, V6)> {
        let (mut commands, mut robot) = (self.commands.clone(), self.robot);
        let mut motion = Vec::new();
        for t in 0..=PREDICTION_HORIZON {
            motion.push((robot.position, robot.velocity));
            let sent = self.base(t) + more.get(t).copied().unwrap_or_default();
            commands.push(&sent);
            // A robot without a dead time, with a late pose, executes even commands that are sent later.
            let mut later = commands.clone();
            for n in 1..=self.latency {
                later.push(&self.base(t + n));
            }
            robot.step_sent(&self.model, &later, CYCLE + self.latency + t);
        }
        motion
    }

    /// The moves that track the reference with the least ‖r − x‖² + ρ ‖U‖², by a dense QR decomposition.
    pub(super) fn moves(&self) -> Vec<V6> {
        const ROWS: usize = PREDICTION_HORIZON + 1 + CONTROL_HORIZON;
        let free = self.positions(&[]);
        let damping = self.contact.damping / (self.contact.stiffness * CYCLE_S);
        let rho: f64 = 3.0 + 0.3 * damping * damping;
        let mut equations = SMatrix::<f64, ROWS, CONTROL_HORIZON>::zeros();
        for i in 0..CONTROL_HORIZON {
            let mut one = vec![V6::zeros(); i];
            one.push(V6::repeat(1.0));
            for (t, (with, without)) in self.positions(&one).iter().zip(&free).enumerate() {
                equations[(t, i)] = (with - without)[0] / CYCLE_S;
            }
            equations[(PREDICTION_HORIZON + 1 + i, i)] = rho.sqrt();
        }
        let qr = equations.qr();
        let mut moves = vec![V6::zeros(); CONTROL_HORIZON];
        for axis in 0..6 {
            let mut wanted = SVector::<f64, ROWS>::zeros();
            for (t, free) in free.iter().enumerate() {
                let reference = self.reference.position_at((CYCLE + t) as f64, CYCLE_S);
                wanted[t] = (reference - free)[axis] / CYCLE_S;
            }
            let right = qr.q().transpose() * wanted;
            let solved = qr.r().solve_upper_triangular(&right).expect("a rank");
            for (of_axis, solved) in moves.iter_mut().zip(solved.iter()) {
                of_axis[axis] = *solved;
            }
        }
        moves
    }
}

/// A contact with 500 kg along a direction oblique to all axes, that begins at a cycle: a · d is 1.
pub(super) fn oblique(zeta: f64, onset: f64) -> (Estimate, Reference) {
    let (mass, omega) = (500.0, 21.0);
    let mut contact = Estimate::exact(mass * omega * omega, 2.0 * zeta * mass * omega, mass);
    contact.gradient = V6::new(0.8, -0.6, 0.1, 0.0, 0.2, -0.1);
    let push = V6::new(0.7, -0.6, 0.3, 0.2, 0.1, -0.3);
    contact.push = push / push.dot(&contact.gradient);
    let before = V6::new(0.006, -0.002, 0.001, 0.003, -0.001, 0.002);
    let closing = contact.gradient.dot(&before);
    let position = V6::new(0.1, 0.2, -0.3, 0.4, 0.5, -0.6);
    contact.surface = contact.gradient.dot(&position);
    let reference = Reference::into_contact(&contact, (onset, position), (before, closing));
    (contact, reference)
}

/// A robot given by dead time and pause in cycles, lag and servo.
pub(super) fn robot(delay: f64, pause: f64, lag_s: f64, servo_hz: f64) -> ActuatorSettings {
    ActuatorSettings {
        delay_s: delay * CYCLE_S,
        pause_s: pause * CYCLE_S,
        lag_s,
        servo_hz,
        ..ActuatorSettings::default()
    }
}

/// Dead times: whole, fractional and none; a lag and a servo; all without a pause.
pub(super) fn robots() -> [ActuatorSettings; 5] {
    [
        robot(8.0, 0.0, 0.0, 0.0),
        robot(7.625, 0.0, 0.0, 0.0),
        robot(0.0, 0.0, 0.012, 0.0),
        robot(4.0, 0.0, 0.016, 0.0),
        robot(2.5, 0.0, 0.0, 10.0),
    ]
}
