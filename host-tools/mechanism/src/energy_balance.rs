//! Energy balance of a mechanism.

use crate::{Mechanism, Reaction, Relative};
use serde::Serialize;

/// Energy balance of a mechanism: `work = stored + dissipated`, except for the integration error of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct EnergyBalance {
    /// Work of the two sides on the mechanism, J.
    pub work_j: f64,
    /// Energy that the mechanism would give back, J.
    pub stored_j: f64,
    /// Energy dissipated by damping and friction, J.
    pub dissipated_j: f64,
}

impl EnergyBalance {
    /// Adds a step between two reactions, with the mean velocity in `at`; dry friction dissipated `friction_j`.
    fn add_step(
        &mut self,
        [before, after]: [&Reaction; 2],
        at: &Relative,
        step_s: f64,
        friction_j: f64,
    ) {
        let mean = (before.wrench + after.wrench) * 0.5;
        self.work_j -= at.power(&mean) * step_s;
        self.stored_j = after.stored_j;
        self.dissipated_j += 0.5 * (before.loss_w + after.loss_w) * step_s + friction_j;
    }

    /// Energy that the balance does not account for, J.
    pub fn imbalance_j(&self) -> f64 {
        self.work_j - self.stored_j - self.dissipated_j
    }
}

impl core::ops::Add for EnergyBalance {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            work_j: self.work_j + other.work_j,
            stored_j: self.stored_j + other.stored_j,
            dissipated_j: self.dissipated_j + other.dissipated_j,
        }
    }
}

/// A mechanism with its energy balance.
#[derive(Clone, Debug)]
pub struct EnergyTracked<M> {
    /// The mechanism.
    pub mechanism: M,
    before: Option<Reaction>,
    balance: EnergyBalance,
}

impl<M: Mechanism> EnergyTracked<M> {
    /// A mechanism that nothing has touched yet.
    pub fn new(mechanism: M) -> Self {
        Self {
            mechanism,
            before: None,
            balance: EnergyBalance::default(),
        }
    }

    /// As [`Mechanism::advance`], and adds the step to the energy balance. Returns the reaction at the end of the step.
    pub fn advance(&mut self, at: &Relative, step_s: f64) -> Reaction {
        let friction_j = self.mechanism.advance(at, step_s);
        let after = self.mechanism.reaction(at);
        let before = self.before.replace(after).unwrap_or(after);
        self.balance
            .add_step([&before, &after], at, step_s, friction_j);
        after
    }

    /// The energy balance so far.
    pub fn balance(&self) -> EnergyBalance {
        self.balance
    }
}
