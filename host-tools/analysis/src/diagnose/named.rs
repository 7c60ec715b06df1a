//! A named effect, as it goes into a model file, with the estimates of its parameters.

use super::actuator::Term;
use super::evidence::{Foretold, Support};
use super::finding::Estimate;
use super::wrench::{Fitted, FittedParameter, Joint};
use softdock_physics::effects::mechanism::ACTS_AT;
use softdock_physics::effects::{Role, by_id};
use softdock_physics::model::load::effects::LoadEffect;
use softdock_physics::model::{Axis, EffectModel, Model, allowed_parameters};
use softdock_report::number;
use softdock_statistics::DEVIATIONS_95;
use std::collections::BTreeMap;

/// An accepted effect.
#[derive(Clone, Debug)]
pub(crate) struct NamedEffect {
    /// The entry of the model file.
    pub effect: EffectModel,
    /// Its fitted parameters with units and intervals, by name.
    pub estimates: BTreeMap<String, Estimate>,
    /// The evidence for it.
    pub support: Support,
    /// See [`Fitted::foretold`].
    pub foretold: Foretold,
}

impl NamedEffect {
    pub(crate) fn new(id: &str, axes: Vec<Axis>) -> Self {
        Self {
            effect: EffectModel {
                id: id.to_owned(),
                axes,
                ..EffectModel::default()
            },
            estimates: BTreeMap::new(),
            support: Support::without_rival(f64::INFINITY),
            foretold: Foretold::UNKNOWN,
        }
    }

    /// Whether its intervals exclude that it is absent.
    pub(crate) fn is_significant(&self, model: &Model) -> bool {
        let is_sure = |name: &str| {
            let estimate = self.estimates.get(name);
            estimate.is_some_and(|e| e.low * e.high > 0.0)
        };
        LoadEffect::find(model, &self.effect.id).is_none_or(|effect| effect.is_significant(is_sure))
    }

    /// Sum of its forces and torques in units of the noise: no reading of a single axis changes by more through a dry friction. A
    /// friction that acts beside the sensor moves torques by its lever as well.
    pub(crate) fn level(&self, model: &Model) -> f64 {
        let of = |(name, estimate): (&String, &Estimate)| {
            let noise = match estimate.unit.as_str() {
                "N" => model.noise.force_n,
                "N·m" => model.noise.torque_n_m,
                _ => return 0.0,
            };
            self.effect
                .parameters
                .get(name)
                .map_or(0.0, |value| value.abs() / noise)
        };
        self.estimates.iter().map(of).sum()
    }

    /// Whether the intervals of all its parameters include 0.
    pub(crate) fn may_be_0(&self) -> bool {
        let mut all = self.estimates.values();
        all.len() > 0 && all.all(|e| e.low * e.high <= 0.0)
    }

    /// Whether the intervals of all its amounts include 0, whatever its shapes are.
    pub(crate) fn amounts_may_be_0(&self, model: &Model) -> bool {
        let Some(effect) = LoadEffect::find(model, &self.effect.id) else {
            return false;
        };
        let amounts = effect.coefficients.iter();
        let amounts = amounts.filter_map(|amount| self.estimates.get(amount.name));
        let amounts: Vec<&Estimate> = amounts.collect();
        !amounts.is_empty() && amounts.iter().all(|e| e.low * e.high <= 0.0)
    }

    /// Names of its amounts if it has several that are independent of each other; else nothing.
    pub(crate) fn independent_amounts(&self, model: &Model) -> Vec<&'static str> {
        let effect = LoadEffect::find(model, &self.effect.id);
        let Some(effect) = effect.filter(|effect| effect.effect.separable) else {
            return Vec::new();
        };
        let amounts = effect.coefficients.iter().map(|amount| amount.name);
        let own: Vec<&str> = amounts
            .filter(|name| self.estimates.contains_key(*name))
            .collect();
        if own.len() > 1 { own } else { Vec::new() }
    }

    /// Removes an amount, which is 0 then.
    pub(crate) fn leave_out(&mut self, name: &str) {
        self.effect.parameters.remove(name);
        self.effect.interval_95.remove(name);
        self.estimates.remove(name);
    }

    pub(crate) fn with_support(self, support: Support) -> Self {
        Self { support, ..self }
    }

    /// Adds a fitted parameter with its standard deviation.
    pub(crate) fn with(self, name: &str, (value, sigma): (f64, f64), unit: &str) -> Self {
        let reach = DEVIATIONS_95 * sigma;
        self.within(name, value, [value - reach, value + reach], unit)
    }

    /// Without this effect the error on unseen data is `worse` times as large. If it has a single parameter, that bounds its
    /// interval.
    pub(crate) fn foretells(&mut self, worse: f64) {
        let [(name, estimate)] = &self.estimates.iter().collect::<Vec<_>>()[..] else {
            return;
        };
        let Some(foretold) = Foretold::bound(worse) else {
            return;
        };
        let (name, Estimate { value, unit, .. }) = ((*name).clone(), (*estimate).clone());
        let ends = foretold.within(value, [estimate.low, estimate.high]);
        *self = Self {
            foretold,
            ..self.clone().within(&name, value, ends, &unit)
        };
    }

    /// Adds a fitted parameter with the ends of its interval.
    pub(crate) fn within(mut self, name: &str, value: f64, interval: [f64; 2], unit: &str) -> Self {
        self.effect.parameters.insert(name.to_owned(), value);
        self.effect.interval_95.insert(name.to_owned(), interval);
        self.estimates.insert(
            name.to_owned(),
            Estimate {
                value,
                unit: unit.to_owned(),
                low: interval[0],
                high: interval[1],
            },
        );
        self
    }

    /// Adds the parameters of an actuator term with their intervals; if the term acts on translations and on rotations, for both.
    pub(crate) fn with_term(mut self, term: &Term, intervals: &[[f64; 2]]) -> Self {
        let turns = term.axes.iter().skip(3).any(|a| *a);
        let kinds: &[bool] = match term.axes.iter().take(3).any(|a| *a) {
            true if turns && term.stage.has_units_of_its_axes() => &[false, true],
            true => &[false],
            false => &[true],
        };
        for rotation in kinds {
            let values = term.values.iter().zip(intervals);
            let parameters = term.stage.parameters(*rotation).iter();
            for ((name, unit), (value, interval)) in parameters.zip(values) {
                self = self.within(name, *value, *interval, unit);
            }
        }
        for name in term.stage.form() {
            self = self.choosing(name, 1.0);
        }
        self
    }

    /// With the values of another fit. The intervals cover those of both fits; with `anew`, of the other fit only.
    pub(crate) fn refitted(mut self, model: &Model, fitted: &EffectModel, anew: bool) -> Self {
        let estimates = std::mem::take(&mut self.estimates);
        for (name, before) in estimates {
            let Some(value) = fitted.parameters.get(&name).copied() else {
                continue;
            };
            let ends = fitted.interval_95.get(&name).copied();
            let [low, high] = self.foretold.within(value, ends.unwrap_or([value; 2]));
            let interval = match anew {
                true => [low, high],
                false => [low.min(before.low), high.max(before.high)],
            };
            self = self.within(&name, value, interval, &before.unit);
        }
        self.bounded(model)
    }

    /// Widens its intervals so that they cover those of another answer.
    pub(crate) fn hold(&mut self, other: &Self) {
        for (name, estimate) in &mut self.estimates {
            let Some(theirs) = other.estimates.get(name) else {
                continue;
            };
            (estimate.low, estimate.high) =
                (estimate.low.min(theirs.low), estimate.high.max(theirs.high));
            let interval = [estimate.low, estimate.high];
            self.effect.interval_95.insert(name.clone(), interval);
        }
    }

    /// The same with a friction that changes sign over a range of speed, m/s or rad/s, and not over a distance. `None` if it has
    /// no such shape, or the speed is not plausible for it.
    pub(crate) fn turning_over(mut self, model: &Model, speed: f64) -> Option<Self> {
        let effect = LoadEffect::find(model, &self.effect.id)?;
        let mut sizes = effect.parameters.iter().filter(|p| p.is_form_size());
        let over = sizes.find(|p| matches!(p.unit, "m/s" | "rad/s") && p.is_plausible(speed))?;
        let distances = effect.parameters.iter().filter(|p| p.is_form_size());
        for distance in distances.filter(|p| matches!(p.unit, "m" | "rad")) {
            self.effect.parameters.remove(distance.name);
        }
        Some(self.choosing(over.name, speed))
    }

    /// Adds a parameter that is a choice and has no interval. The default, 0, is left out.
    pub(crate) fn choosing(mut self, name: &str, value: f64) -> Self {
        if value != 0.0 {
            self.effect.parameters.insert(name.to_owned(), value);
        }
        self
    }

    /// A sentence with the parameters that were chosen and have no interval, such as the number of a leg. `None` if all are
    /// fitted. The point of a tool where a force acts is mentioned for a rig only, as a single axis has one point.
    pub(crate) fn choice(&self, of_a_rig: bool) -> Option<String> {
        let EffectModel { id, parameters, .. } = &self.effect;
        let chosen = parameters
            .iter()
            .filter(|(name, _)| !self.estimates.contains_key(*name))
            .filter(|(name, _)| of_a_rig || *name != ACTS_AT.name);
        let chosen: Vec<String> = chosen
            .map(|(name, value)| {
                let word = by_id(id).and_then(|e| e.parameters[e.place(name)?].word(*value));
                let word = word.map_or_else(String::new, |word| format!(" ({word})"));
                // The number of a leg.
                let value = match value.fract() == 0.0 {
                    true => format!("{value:.0}"),
                    false => number::significant(*value, 3),
                };
                format!("{name} = {value}{word}")
            })
            .collect();
        (!chosen.is_empty()).then(|| format!("Of `{id}` these logs choose {}.", chosen.join(", ")))
    }

    /// A sentence with the shapes (a time constant, say) that stand at an end of their searched range; `None` if there are none.
    pub(crate) fn at_its_end(&self, joint: &Joint) -> Option<String> {
        /// Share of an end from which a value is at that end.
        const END: f64 = 0.99;
        let effect = LoadEffect::find(&joint.logs.first()?.scene.model, &self.effect.id)?;
        let ends = self.estimates.iter().filter_map(|(name, estimate)| {
            let parameter = effect.parameters.iter().find(|p| p.name == name)?;
            let is_shape = matches!(parameter.role, Role::Shape(_));
            let [least, most] = effect.search_range(parameter, joint.pace());
            let value = estimate.value;
            let is_least = match least < 0.0 {
                true => value <= END * least,
                false => value > 0.0 && value <= least / END,
            };
            let end = match is_least {
                true => Some(least),
                false => (value >= END * most).then_some(most),
            };
            end.filter(|_| is_shape).map(|end| {
                let end = number::significant(end, 3);
                let stands = match value > END.recip() * most {
                    true => "is beyond",
                    false => "reaches",
                };
                format!(
                    "{name} {stands} the end of what the search tries, {end} {}",
                    estimate.unit
                )
            })
        });
        let ends: Vec<String> = ends.collect();
        (!ends.is_empty()).then(|| {
            format!(
                "Of `{}` {}: the true one may lie beyond, and what is left of it may be named by another name.",
                self.effect.id,
                ends.join(", ")
            )
        })
    }

    /// Limits each interval to the range of its parameter: a curvature does not know that a time constant cannot be negative.
    pub(crate) fn bounded(mut self, model: &Model) -> Self {
        let Ok(effect) = model.effect(&self.effect.id) else {
            return self;
        };
        let ranges = allowed_parameters(model, effect);
        for (name, [low, high]) in &mut self.effect.interval_95 {
            let range = ranges.iter().find(|range| range.name == name);
            let (Some(range), Some(estimate)) = (range, self.estimates.get_mut(name)) else {
                continue;
            };
            *low = low.max(range.low.min(estimate.value));
            *high = high.min(range.high.max(estimate.value));
            (estimate.low, estimate.high) = (*low, *high);
        }
        self
    }
}

/// A fitted effect on the reading as it stands in a model file.
pub(crate) fn model_of(fitted: &Fitted) -> EffectModel {
    of_reading(fitted).effect
}

/// A fitted effect on the reading.
pub(crate) fn of_reading(fitted: &Fitted) -> NamedEffect {
    let mut one = NamedEffect {
        foretold: fitted.foretold,
        ..NamedEffect::new(fitted.id, Vec::new())
    };
    for (name, FittedParameter { value, sigma, unit }) in &fitted.parameters {
        one = if *sigma > 0.0 {
            one.within(name, *value, fitted.interval(name), unit)
        } else {
            one.choosing(name, *value)
        };
    }
    one
}

/// The model with effects added.
pub(crate) fn with_effects<'a>(
    model: &Model,
    named: impl Iterator<Item = &'a NamedEffect>,
) -> Model {
    let mut after = model.clone();
    after.effects.extend(named.map(|n| n.effect.clone()));
    after
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Also for a limit of rotations and for the friction of a joint, whose parameters have names of their own.
    #[test]
    fn one_of_two_independent_amounts_may_be_left_out() {
        let model = Model::from_toml("[rig]\nactive_axes = [\"rx\"]", "model").unwrap();
        let mut weight = NamedEffect::new("bearing_gravity", Vec::new())
            .with("sine_n_m", (6.0, 0.1), "N·m")
            .with("cosine_n_m", (0.2, 0.1), "N·m");
        let both = ["sine_n_m", "cosine_n_m"];
        assert_eq!(weight.independent_amounts(&model), both);
        weight.leave_out("cosine_n_m");
        assert!(weight.independent_amounts(&model).is_empty());
        assert!(weight.estimates.contains_key("sine_n_m"));
    }

    #[test]
    fn an_interval_ends_where_the_range_of_its_parameter_ends() {
        let mut model = Model::default();
        model.rig.active_axes = vec![Axis::Rz];
        for (id, name, unit) in [
            ("rate_limit", "max_acceleration_rad_s2", "rad/s^2"),
            ("guide_viscous", "damping_n_m_s_per_rad", "N·m·s/rad"),
        ] {
            let open = NamedEffect::new(id, Vec::new()).with(name, (8.0, 30.0), unit);
            let ended = open.bounded(&model);
            let estimate = &ended.estimates[name];
            assert!(estimate.low >= 0.0 && estimate.high > 60.0, "{estimate:?}");
            assert_eq!(ended.effect.interval_95[name][0], estimate.low);
        }
    }

    /// A drift whose time constant is known, while its size may be 0.
    #[test]
    fn a_shape_that_is_told_makes_no_amount() {
        let model = Model::default();
        let drift = |force: (f64, f64)| {
            NamedEffect::new("ft_bias_drift", Vec::new())
                .with("fx_n", force, "N")
                .with("time_constant_s", (15.0, 4.0), "s")
        };
        assert!(!drift((100.0, 20.0)).amounts_may_be_0(&model));
        assert!(drift((100.0, 110.0)).amounts_may_be_0(&model));
    }
}
