//! The result of fitting a hypothesis.

use super::fitted::Fitted;
use crate::diagnose::finding::Trial;
use softdock_physics::model::Channel;
use softdock_physics::model::load::loaded::{Loaded, ValuedEffect, contribution};
use softdock_physics::model::load::{Column, Scene};

/// Largest relative difference of the total χ² to explain between fits under one noise model. A noise model that is estimated
/// anew from the same data stays within it; that of another search does not.
pub(crate) const SAME_NOISE: f64 = 0.01;

/// A hypothesis after its shapes were refined, with its evidence on all logs.
#[derive(Clone, Debug, Default)]
pub(crate) struct TestedHypothesis {
    /// Its effects.
    pub effects: Vec<Fitted>,
    /// Ids of effects that the model had already.
    pub beside: Vec<String>,
    /// χ² of all there was to explain. As χ² is in units of the noise, this value also identifies the noise model under which the
    /// hypothesis was tried.
    pub to_explain: f64,
    /// Fall of χ² over all logs.
    pub gain: f64,
    /// Fall of χ² of each log.
    pub gains: Vec<f64>,
    /// Gain less the price of the parameters and the prior odds of the effects.
    pub evidence: f64,
    /// Number of parameters.
    pub parameters: usize,
    /// Reasons why it cannot be, in words: parameters with a sign that physics forbids or outside any plausible range, and
    /// effects so much larger than the reading that they would have to cancel each other more exactly than laws hold.
    pub wrong: Vec<String>,
    /// Fall of the squared distance to the intervals of rounded readings; infinite without rounding.
    pub beyond_rounding: f64,
    /// Why its parameters are those of all logs and not those of the logs of the fit; `None` if they are the latter.
    pub of_all_logs: Option<String>,
}

impl TestedHypothesis {
    pub(crate) fn trial(&self) -> Trial {
        Trial {
            effects: self.ids(),
            channel: Channel::Wrench,
            gain: self.gain,
        }
    }

    /// Rescales its χ² to the noise model under which there is `to_explain` to explain.
    pub(crate) fn beside_noise(mut self, to_explain: f64) -> Self {
        let by = to_explain / self.to_explain;
        self.to_explain = to_explain;
        // Price and prior odds stay what they are.
        self.evidence += self.gain * (by - 1.0);
        self.gain *= by;
        self.gains.iter_mut().for_each(|gain| *gain *= by);
        self
    }

    /// Whether it was tried under the noise model with which there is `to_explain` to explain.
    pub(crate) fn is_beside_noise_of(&self, to_explain: f64) -> bool {
        (self.to_explain / to_explain - 1.0).abs() < SAME_NOISE
    }

    /// The same where nominal parameters are held and so much more of each log is to be explained. What it leaves is as before.
    pub(crate) fn with_more_to_explain(mut self, more: &[f64]) -> Self {
        let sum: f64 = more.iter().sum();
        self.to_explain += sum;
        self.evidence += sum;
        self.gain += sum;
        let each = self.gains.iter_mut().zip(more);
        each.for_each(|(gain, more)| *gain += more);
        self
    }

    /// Whether its effects are those of another hypothesis, in whatever order.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        self.effects_in_order() == other.effects_in_order()
    }

    /// Ids in alphabetical order, so that hypotheses of the same effects compare equal.
    pub(crate) fn effects_in_order(&self) -> Vec<&'static str> {
        let mut ids: Vec<&'static str> = self.effects.iter().map(|e| e.id).collect();
        ids.sort_unstable();
        ids
    }

    /// Ids, in the order of the effects.
    pub(crate) fn ids(&self) -> Vec<String> {
        self.effects.iter().map(|e| e.id.to_owned()).collect()
    }

    fn valued(&self, scene: &Scene) -> Vec<ValuedEffect<'static>> {
        let effects = self.effects.iter();
        effects.filter_map(|one| one.valued(scene)).collect()
    }

    /// Its effects that do not move the reading in time.
    pub(crate) fn loads(&self, scene: &Scene) -> Vec<ValuedEffect<'static>> {
        let mut loads = self.valued(scene);
        loads.retain(|(effect, _)| !effect.is_late());
        loads
    }

    /// What its effects contribute to the reading of a log.
    pub(crate) fn contribution(&self, scene: &Scene) -> Column {
        contribution(scene, &self.valued(scene))
    }

    /// What one of its effects, or one of its terms, contributes. A late effect contributes the shift in time of what the other
    /// effects load the sensor with, so that the parts add up to the whole.
    pub(crate) fn part(&self, scene: &Scene, one: &Fitted) -> Column {
        match one.valued(scene) {
            Some(late) if late.0.is_late() => Loaded::by(scene, &self.loads(scene)).added(late),
            Some(load) => contribution(scene, &[load]),
            None => Column::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Held parameters leave more to explain, and what is left is the same.
    #[test]
    fn what_is_held_elsewhere_is_more_to_explain() {
        let tried = TestedHypothesis {
            to_explain: 1000.0,
            gain: 300.0,
            gains: vec![100.0, 200.0],
            evidence: 280.0,
            ..TestedHypothesis::default()
        };
        let held = tried.clone().with_more_to_explain(&[40.0, 60.0]);
        assert_eq!(held.to_explain - held.gain, tried.to_explain - tried.gain);
        assert_eq!(held.gains, [140.0, 260.0]);
        assert_eq!(held.evidence, 380.0);
        assert!(tried.is_beside_noise_of(1005.0) && !tried.is_beside_noise_of(held.to_explain));
    }
}
