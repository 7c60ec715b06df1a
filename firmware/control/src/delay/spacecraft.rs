//! Two spacecraft for the tests of laws, and what a law gets to see of them in a cycle.

use super::{LawInput, SentHistory};
use crate::dynamics::{BodyState, TwoBody, TwoBodyState, relative_velocity};
use crate::frames::{Pose, Twist, Wrench};
use crate::settings::BodySettings;
use nalgebra::UnitQuaternion;

/// Cycle, s.
pub(super) const CYCLE_S: f64 = 0.004;

/// Both spacecraft, and the measured pose of the robot.
pub(super) struct Spacecraft {
    pub(super) bodies: TwoBody<f64>,
    pub(super) state: TwoBodyState<f64>,
    pub(super) measured: Pose<f64>,
    pub(super) sent: SentHistory<f64>,
}

impl Spacecraft {
    /// At their initial state, with the robot at the pose of K seen from Q.
    pub(super) fn new(k: &BodySettings, q: &BodySettings) -> Self {
        let state = TwoBodyState {
            k: BodyState::initial(k),
            q: BodyState::initial(q),
        };
        Self {
            bodies: TwoBody::new(k, q, CYCLE_S),
            state,
            measured: state.q_from_k(),
            sent: SentHistory::new(),
        }
    }

    /// K of 500 kg with this velocity, and Q that does not move.
    pub(super) fn before_a_wall(velocity_m_s: [f64; 3]) -> Self {
        let k = BodySettings {
            velocity_m_s,
            ..BodySettings::default()
        };
        let wall = BodySettings {
            fixed: true,
            ..BodySettings::default()
        };
        Self::new(&k, &wall)
    }

    /// The input of a law in a cycle with this wrench.
    pub(super) fn input<'a>(&'a self, wrench: &'a Wrench<f64>) -> LawInput<'a, f64> {
        let model = relative_velocity(&self.state.k, &self.state.q);
        self.asked(wrench, model)
    }

    /// The same with another velocity of the model.
    pub(super) fn asked<'a>(
        &'a self,
        wrench: &'a Wrench<f64>,
        model: Twist<f64>,
    ) -> LawInput<'a, f64> {
        LawInput {
            model,
            model_end: model,
            wrench,
            measured: &self.measured,
            commanded: &self.measured,
            sent: &self.sent,
            bodies: &self.bodies,
            state: &self.state,
            c_from_q: UnitQuaternion::identity(),
            released: true,
            frozen: false,
        }
    }

    /// Moves both for a cycle; the robot follows at once.
    pub(super) fn step(&mut self, felt: &Wrench<f64>) {
        self.state = self.bodies.step(&self.state, felt).0;
        self.measured = self.state.q_from_k();
    }

    /// Kinetic energy of both, J.
    pub(super) fn energy(&self) -> f64 {
        let (k, q) = (&self.bodies.k, &self.bodies.q);
        k.kinetic_energy(&self.state.k) + q.kinetic_energy(&self.state.q)
    }
}
