//! What a fit makes of a hypothesis.

use super::fitted::Fitted;
use crate::diagnose::finding::Trial;
use softdock_physics::model::Channel;
use softdock_physics::model::load::loaded::{Loaded, Valued, contribution};
use softdock_physics::model::load::{Column, Scene};

/// Relative difference of all there is to explain that noise which was estimated anew makes, and another noise does not.
pub(crate) const SAME_NOISE: f64 = 0.01;

/// A hypothesis after its shapes were refined, with its evidence on all logs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tested {
    /// Its effects.
    pub effects: Vec<Fitted>,
    /// Ids of what the model had already.
    pub beside: Vec<String>,
    /// χ² of all there was to explain. Its unit is the noise beside which the hypothesis was tried: that is the same where
    /// this is.
    pub to_explain: f64,
    /// Fall of χ² over all logs.
    pub gain: f64,
    /// Fall of χ² of each log.
    pub gains: Vec<f64>,
    /// Gain less the price of the parameters and the prior odds of the effects.
    pub evidence: f64,
    /// Number of parameters.
    pub parameters: usize,
    /// Parameters with a sign that physics forbids, or out of any plausible range; effects that are larger than what was
    /// measured by so much that they would have to cancel each other more exactly than laws hold.
    pub wrong: Vec<String>,
    /// Fall of the squared distance to the intervals of rounded readings.
    pub beyond_rounding: f64,
    /// Why its parameters are those of all logs and not those of the logs of the fit, if they are.
    pub of_all_logs: Option<String>,
}

impl Tested {
    pub(crate) fn trial(&self) -> Trial {
        Trial {
            effects: self.ids(),
            channel: Channel::Wrench,
            gain: self.gain,
        }
    }

    /// With χ² in the unit in which there is so much to explain.
    pub(crate) fn beside_noise(mut self, to_explain: f64) -> Self {
        let by = to_explain / self.to_explain;
        self.to_explain = to_explain;
        // Price and prior odds stay what they are.
        self.evidence += self.gain * (by - 1.0);
        self.gain *= by;
        self.gains.iter_mut().for_each(|gain| *gain *= by);
        self
    }

    /// Whether its noise is that beside which there is so much to explain.
    pub(crate) fn is_beside_noise_of(&self, to_explain: f64) -> bool {
        (self.to_explain / to_explain - 1.0).abs() < SAME_NOISE
    }

    /// The same where so much more of each log is to be explained, as nominal parameters are held: it leaves what it left.
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

    /// Ids by the alphabet: those of the same effects are equal.
    pub(crate) fn effects_in_order(&self) -> Vec<&'static str> {
        let mut ids: Vec<&'static str> = self.effects.iter().map(|e| e.id).collect();
        ids.sort_unstable();
        ids
    }

    /// Ids, in order.
    pub(crate) fn ids(&self) -> Vec<String> {
        self.effects.iter().map(|e| e.id.to_owned()).collect()
    }

    fn valued(&self, scene: &Scene) -> Vec<Valued<'static>> {
        let effects = self.effects.iter();
        effects.filter_map(|one| one.valued(scene)).collect()
    }

    /// Its effects that do not move the reading in time.
    pub(crate) fn loads(&self, scene: &Scene) -> Vec<Valued<'static>> {
        let mut loads = self.valued(scene);
        loads.retain(|(effect, _)| !effect.is_late());
        loads
    }

    /// Their part of a reading.
    pub(crate) fn contribution(&self, scene: &Scene) -> Column {
        contribution(scene, &self.valued(scene))
    }

    /// The part of one of them, or of one of its terms, so that the parts are the whole: what moves the reading in time
    /// does so to what the others load the sensor with.
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
        let tried = Tested {
            to_explain: 1000.0,
            gain: 300.0,
            gains: vec![100.0, 200.0],
            evidence: 280.0,
            ..Tested::default()
        };
        let held = tried.clone().with_more_to_explain(&[40.0, 60.0]);
        assert_eq!(held.to_explain - held.gain, tried.to_explain - tried.gain);
        assert_eq!(held.gains, [140.0, 260.0]);
        assert_eq!(held.evidence, 380.0);
        assert!(tried.is_beside_noise_of(1005.0) && !tried.is_beside_noise_of(held.to_explain));
    }
}
