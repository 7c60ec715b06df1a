//! An effect with the parameters that were fitted to the logs.

use crate::diagnose::evidence::Foretold;
use softdock_physics::model::Model;
use softdock_physics::model::load::Scene;
use softdock_physics::model::load::effects::LoadEffect;
use softdock_physics::model::load::loaded::ValuedEffect;
use softdock_statistics::DEVIATIONS_95;
use std::collections::BTreeMap;

/// A fitted parameter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FittedParameter {
    /// Its value.
    pub value: f64,
    /// Standard deviation of the value; 0 for a choice.
    pub sigma: f64,
    /// Its unit.
    pub unit: &'static str,
}

/// An effect with fitted parameters.
#[derive(Clone, Debug)]
pub(crate) struct Fitted {
    /// The effect's id.
    pub id: &'static str,
    /// Its parameters by name.
    pub parameters: BTreeMap<&'static str, FittedParameter>,
    /// Ratio of its amount beside a smooth remainder to its amount without one.
    pub beside_remainder: f64,
    /// Values of its parameters in other answers that the logs do not refute.
    pub elsewhere: BTreeMap<&'static str, Vec<f64>>,
    /// How far its only free parameter may be off, by the error on unseen data.
    pub foretold: Foretold,
}

impl Fitted {
    /// The effect of the catalogue with its values; `None` if the model of the scene has no such effect.
    pub(crate) fn valued(&self, scene: &Scene) -> Option<ValuedEffect<'static>> {
        let effect = LoadEffect::find(&scene.model, self.id)?;
        let values = self.parameters.iter();
        let values = values.map(|(name, parameter)| ((*name).to_owned(), parameter.value));
        Some((effect, effect.values_or_defaults(&values.collect())))
    }

    /// The effect split into one term for each coefficient that is not 0, if it is linear in them; otherwise the effect itself.
    pub(crate) fn terms(&self, model: &Model) -> Vec<Self> {
        let effect = LoadEffect::find(model, self.id).filter(|effect| effect.is_linear());
        let names = effect.iter().flat_map(|effect| &effect.coefficients);
        let given = |name: &&str| self.parameters.get(name).is_some_and(|p| p.value != 0.0);
        let names: Vec<&str> = names.map(|c| c.name).filter(given).collect();
        if names.len() < 2 {
            return vec![self.clone()];
        }
        let term = |own: &&str| {
            let mut term = self.clone();
            for other in names.iter().filter(|name| name != &own) {
                if let Some(parameter) = term.parameters.get_mut(other) {
                    parameter.value = 0.0;
                }
            }
            term
        };
        names.iter().map(term).collect()
    }

    /// Factors of its [`Self::terms`] with which their sum becomes the effect that it is a detail of. `None` if it is no detail,
    /// or if a coefficient that this needs is 0: then that other effect stands beside it.
    pub(crate) fn plain(&self, model: &Model) -> Option<Vec<f64>> {
        let effect = LoadEffect::find(model, self.id)?;
        let mut details = effect.effect.detail_of.iter();
        let (_, plain) = details.find(|(_, plain)| !plain.is_empty())?;
        let of = |name: &str| self.parameters.get(name).map_or(0.0, |p| p.value);
        let parts = effect.coefficients.iter().zip(*plain);
        let parts: Vec<(f64, f64)> = parts.map(|(c, amount)| (of(c.name), *amount)).collect();
        let is_whole = parts
            .iter()
            .all(|(value, amount)| *value != 0.0 || *amount == 0.0);
        let given = parts.iter().filter(|(value, _)| *value != 0.0);
        is_whole.then(|| given.map(|(value, amount)| amount / value).collect())
    }

    /// Records how it stands beside a remainder: the ratio of its amount there, and `share`, a relative standard deviation that
    /// is added to those of all free parameters.
    pub(crate) fn record_amount_ratio(&mut self, (amount, share): (f64, f64)) {
        self.beside_remainder = amount;
        for parameter in self.parameters.values_mut() {
            if parameter.sigma > 0.0 {
                parameter.sigma = parameter.sigma.hypot(share * parameter.value);
            }
        }
    }

    /// Whether the interval of a parameter leaves out 0.
    fn is_sure(&self, name: &str) -> bool {
        let [low, high] = self.interval(name);
        low * high > 0.0
    }

    /// Whether the intervals of its coefficients leave out 0 where they have to.
    pub(crate) fn is_determined(&self, model: &Model) -> bool {
        LoadEffect::find(model, self.id)
            .is_some_and(|effect| effect.is_determined(|name| self.is_sure(name)))
    }

    /// Whether its intervals exclude that it is absent.
    pub(crate) fn is_significant(&self, model: &Model) -> bool {
        LoadEffect::find(model, self.id)
            .is_none_or(|effect| effect.is_significant(|name| self.is_sure(name)))
    }

    /// Without this effect the error on unseen data is `worse` times as large. If it has a single free parameter, that bounds its
    /// interval.
    pub(crate) fn foretells(&mut self, worse: f64) {
        let free = self.parameters.values().filter(|p| p.sigma > 0.0);
        if let Some(share) = Foretold::bound(worse).filter(|_| free.count() == 1) {
            self.foretold = share;
        }
    }

    /// Widens its intervals so that they include the values of another answer.
    pub(crate) fn hold(&mut self, other: &Self) {
        for (name, parameter) in &other.parameters {
            let values = self.elsewhere.entry(name).or_default();
            values.push(parameter.value);
        }
    }

    /// 95 % interval of a parameter. It covers the values without and beside a remainder, as far as unseen data allow them, and
    /// the values of other answers that are not refuted. [0, 0] for a parameter that the effect has not.
    pub(crate) fn interval(&self, name: &str) -> [f64; 2] {
        let Some(FittedParameter { value, sigma, .. }) = self.parameters.get(name).copied() else {
            return [0.0; 2];
        };
        let beside = self.beside_remainder * value;
        let reach = DEVIATIONS_95 * sigma;
        let said = [value.min(beside) - reach, value.max(beside) + reach];
        let own = self.foretold.within(value, said);
        let others = self.elsewhere.get(name).into_iter().flatten();
        others.fold(own, |[low, high], other| {
            [low.min(*other), high.max(*other)]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2 ± 0.1 N alone, 0.9 times as much beside a remainder, 0.5 N beside another effect.
    #[test]
    fn an_interval_holds_what_other_answers_say() {
        let force = |value: f64, sigma: f64| FittedParameter {
            value,
            sigma,
            unit: "N",
        };
        let of = |value: f64| Fitted {
            id: "guide_coulomb",
            parameters: BTreeMap::from([("force_n", force(value, 0.1))]),
            beside_remainder: 0.9,
            elsewhere: BTreeMap::new(),
            foretold: Foretold::UNKNOWN,
        };
        let mut fitted = of(2.0);
        let reach = 0.1 * DEVIATIONS_95;
        assert_eq!(fitted.interval("force_n"), [1.8 - reach, 2.0 + reach]);
        fitted.hold(&of(1.9));
        assert_eq!(fitted.interval("force_n"), [1.8 - reach, 2.0 + reach]);
        fitted.hold(&of(0.5));
        assert_eq!(fitted.interval("force_n"), [0.5, 2.0 + reach]);
        assert_eq!(fitted.interval("smoothing_speed_m_s"), [0.0; 2]);
        // Without the effect the error is 1.1 times as large, and so it is with twice its amount.
        let mut vague = of(2.0);
        vague.parameters.insert("force_n", force(2.0, 3.0));
        vague.foretells(1.05);
        assert!(vague.interval("force_n")[0] < -3.0);
        vague.foretells(1.1);
        assert_eq!(vague.interval("force_n"), [0.0, 4.0]);
        vague.foretells(1.36);
        let [low, high] = vague.interval("force_n");
        assert!(
            (low - 1.0).abs() < 0.01 && (high - 3.0).abs() < 0.01,
            "{low} {high}"
        );
    }
}
