//! What the stages accepted, as effects of a model file.

use super::actuator::{Candidate, Search, Term};
use super::engine::Stages;
use super::evidence::{Foretold, NEARLY_AS_GOOD, Support};
use super::finding::Estimate;
use super::wrench::Fitted;
use super::wrench_finding::WrenchFinding;
use softdock_physics::effects::body::{clock_jitter, clock_offset, clock_rate};
use softdock_physics::effects::mechanism::ACTS_AT;
use softdock_physics::effects::{Role, by_id};
use softdock_physics::model::load::effects::LoadEffect;
use softdock_physics::model::stage::Stage;
use softdock_physics::model::{Axis, EffectModel, Model};
use softdock_report::number;
use softdock_statistics::DEVIATIONS_95;
use std::collections::BTreeMap;

/// An accepted effect.
#[derive(Clone, Debug)]
pub(crate) struct Named {
    /// As it goes into the model file.
    pub effect: EffectModel,
    /// Its parameters with units and intervals.
    pub estimates: BTreeMap<String, Estimate>,
    /// What speaks for it.
    pub support: Support,
    /// See [`Fitted`].
    pub foretold: Foretold,
}

impl Named {
    pub(super) fn new(id: &str, axes: Vec<Axis>) -> Self {
        Self {
            effect: EffectModel {
                id: id.to_owned(),
                axes,
                ..EffectModel::default()
            },
            estimates: BTreeMap::new(),
            support: Support::alone(f64::INFINITY),
            foretold: Foretold::UNKNOWN,
        }
    }

    /// Whether its intervals say more than that it may not be there.
    pub(super) fn is_told(&self, model: &Model) -> bool {
        let is_sure = |name: &str| {
            let estimate = self.estimates.get(name);
            estimate.is_some_and(|e| e.low * e.high > 0.0)
        };
        LoadEffect::find(model, &self.effect.id).is_none_or(|effect| effect.is_told(is_sure))
    }

    fn with_support(self, support: Support) -> Self {
        Self { support, ..self }
    }

    /// Adds a fitted parameter.
    pub(super) fn with(self, name: &str, (value, sigma): (f64, f64), unit: &str) -> Self {
        let reach = DEVIATIONS_95 * sigma;
        self.within(name, value, [value - reach, value + reach], unit)
    }

    /// Unseen data are foretold so many times worse without it: where it has one parameter, that bounds it.
    pub(super) fn foretells(&mut self, worse: f64) {
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

    /// The same with the ends of its interval.
    fn within(mut self, name: &str, value: f64, interval: [f64; 2], unit: &str) -> Self {
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

    /// Adds the parameters of a term of the actuator, with the ends of their intervals: for each kind of axis that it has.
    fn with_term(mut self, term: &Term, intervals: &[[f64; 2]]) -> Self {
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

    /// With the values of another fit, and intervals that hold what both say; `anew`: those of that fit alone.
    pub(super) fn refitted(mut self, fitted: &EffectModel, anew: bool) -> Self {
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
        self.bounded()
    }

    /// From now on the intervals hold those of another answer, too.
    pub(super) fn hold(&mut self, other: &Self) {
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

    /// The same with a friction that turns round over a speed, rad/s or m/s, and over no distance; none if it cannot.
    pub(super) fn turning_over(mut self, model: &Model, speed: f64) -> Option<Self> {
        let effect = LoadEffect::find(model, &self.effect.id)?;
        let mut sizes = effect.parameters.iter().filter(|p| p.is_form_size());
        let over = sizes.find(|p| matches!(p.unit, "m/s" | "rad/s") && p.is_plausible(speed))?;
        let distances = effect.parameters.iter().filter(|p| p.is_form_size());
        for distance in distances.filter(|p| matches!(p.unit, "m" | "rad")) {
            self.effect.parameters.remove(distance.name);
        }
        Some(self.choosing(over.name, speed))
    }

    /// Adds a parameter that is a choice: it has no interval. The usual choice is left out.
    pub(super) fn choosing(mut self, name: &str, value: f64) -> Self {
        if value != 0.0 {
            self.effect.parameters.insert(name.to_owned(), value);
        }
        self
    }

    /// What was chosen for it and has no interval, such as the number of a leg, in words; none if everything is fitted. Where on a
    /// tool a force acts is a question of a rig: an axis has one point.
    pub(super) fn choice(&self, of_a_rig: bool) -> Option<String> {
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

    /// Shapes, such as a time constant, that stand where a search ends, in words; none if there are none.
    pub(super) fn at_its_end(&self, found: &WrenchFinding) -> Option<String> {
        /// Part of an end that is the end.
        const END: f64 = 0.99;
        let joint = &found.prepared;
        let effect = LoadEffect::find(&joint.logs.first()?.scene.model, &self.effect.id)?;
        let ends = self.estimates.iter().filter_map(|(name, estimate)| {
            let parameter = effect.parameters.iter().find(|p| p.name == name)?;
            let is_shape = matches!(parameter.role, Role::Shape(_));
            let [least, most] = effect.searched(parameter, joint.pace());
            let value = estimate.value;
            let end = match value > 0.0 && value <= least / END {
                true => Some(least),
                false => (value >= END * most).then_some(most),
            };
            end.filter(|_| is_shape).map(|end| {
                let end = number::significant(end, 3);
                format!(
                    "{name} reaches the end of what the search tries, {end} {}",
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

    /// Ends each interval where its parameter's range ends: a curvature knows nothing of a time
    /// constant that cannot be negative.
    fn bounded(mut self) -> Self {
        let Some(effect) = by_id(&self.effect.id) else {
            return self;
        };
        for (name, [low, high]) in &mut self.effect.interval_95 {
            let (Some(at), Some(estimate)) = (effect.place(name), self.estimates.get_mut(name))
            else {
                continue;
            };
            let range = &effect.parameters[at];
            *low = low.max(range.low.min(estimate.value));
            *high = high.min(range.high.max(estimate.value));
            (estimate.low, estimate.high) = (*low, *high);
        }
        self
    }
}

/// All accepted effects, in the order of the stages.
pub(crate) fn all(model: &Model, stages: &Stages) -> Vec<Named> {
    let mut named = clock(stages);
    named.extend(actuator(stages));
    named.extend(sampling(stages));
    if let Some(found) = &stages.wrench {
        let earlier = found.earlier.0.iter().zip(&found.earlier.1);
        let accepted = found.found.accepted.iter().flat_map(|t| &t.effects);
        let all = earlier.chain(accepted.zip(&found.found.support));
        named.extend(all.map(|(fitted, support)| of_reading(fitted).with_support(*support)));
    }
    for fit in &stages.body.accepted {
        let one = Named::new(fit.id, Vec::new());
        let mut one = one.with_support(Support::alone(fit.evidence));
        for (name, (value, sigma, unit)) in &fit.parameters {
            one = if *sigma > 0.0 {
                one.with(name, (*value, *sigma), unit)
            } else {
                one.choosing(name, *value)
            };
        }
        named.push(one);
    }
    if model.tool.mass_kg == 0.0 {
        divide_by_mass(&mut named);
    }
    named.into_iter().map(Named::bounded).collect()
}

/// Of a tool without nominal mass the fit gives mass times centre of mass.
fn divide_by_mass(named: &mut [Named]) {
    let mass = named.iter().find(|n| n.effect.id == "tool_mass_error");
    let Some(mass_kg) = mass
        .and_then(|m| m.effect.parameters.get("mass_error_kg"))
        .copied()
    else {
        return;
    };
    for one in named
        .iter_mut()
        .filter(|n| n.effect.id == "tool_com_error" && mass_kg > 0.0)
    {
        one.effect
            .parameters
            .values_mut()
            .for_each(|v| *v /= mass_kg);
        for [low, high] in one.effect.interval_95.values_mut() {
            *low /= mass_kg;
            *high /= mass_kg;
        }
        for estimate in one.estimates.values_mut() {
            estimate.value /= mass_kg;
            estimate.low /= mass_kg;
            estimate.high /= mass_kg;
        }
    }
}

fn clock(stages: &Stages) -> Vec<Named> {
    let clock = &stages.clock;
    let one = |id: &str, name: &str, value: (f64, f64), unit: &str| {
        Named::new(id, Vec::new()).with(name, value, unit)
    };
    let jitter = clock.jitter.map(|jitter| {
        let of_intervals = f64::from(u8::from(jitter.scatter.of_intervals));
        let estimate = (jitter.scatter.jitter_s, jitter.sigma_s);
        one(clock_jitter::EFFECT.id, "jitter_s", estimate, "s")
            .choosing("of_intervals", of_intervals)
    });
    let rate = clock
        .rate
        .map(|rate| one(clock_rate::EFFECT.id, "rate_error", rate, "-"));
    let offset = clock
        .offset_s
        .map(|offset| one(clock_offset::EFFECT.id, "offset_s", offset, "s"));
    // A jitter bends the estimates of the other two.
    match jitter {
        Some(jitter) => vec![jitter],
        None => rate.into_iter().chain(offset).collect(),
    }
}

fn actuator(stages: &Stages) -> Vec<Named> {
    let Some(found) = &stages.actuator else {
        return Vec::new();
    };
    let (Some(accepted), Some(active)) = (&found.search.accepted, found.white.first()) else {
        return Vec::new();
    };
    let active = active.each_ref().map(|series| !series.is_empty());
    let mut named: Vec<Named> = Vec::new();
    for (term, intervals) in accepted.terms.iter().zip(&found.intervals) {
        let id = term.stage.id();
        let same = |one: &Named| one.effect.id == id;
        let one = match named.iter().position(same) {
            // Translations and rotations with a limit each are one effect.
            Some(at) => named.remove(at),
            None => {
                let of_id = found.search.support.iter().find(|(other, _)| *other == id);
                let support = of_id.map_or(Support::alone(f64::INFINITY), |(_, s)| *s);
                Named::new(id, axes_of(term, &active)).with_support(support)
            }
        };
        named.push(one.with_term(term, intervals));
    }
    let first = accepted.terms.first().map(|term| term.stage);
    if accepted.terms.iter().any(|term| Some(term.stage) != first) {
        for one in &mut named {
            widen(one, &found.search);
        }
    }
    for one in &mut named {
        // With a value for each kind of axis there is nothing to leave out.
        let stage = Stage::of(&one.effect.id, &one.effect.parameters);
        if stage.is_some_and(Stage::has_units_of_its_axes) && one.effect.axes.len() == 3 {
            one.effect.axes.clear();
        }
    }
    named
}

/// A parameter of a pair whose value depends on what else is believed has no narrower interval than
/// the estimates of all hypotheses that explain nearly as much.
fn widen(one: &mut Named, search: &Search) {
    let gain = |c: &Candidate| search.nominal.chi2 - c.chi2;
    let enough = NEARLY_AS_GOOD * search.accepted.as_ref().map_or(f64::INFINITY, gain);
    for rival in search.singles.iter().filter(|c| gain(c) > enough) {
        for term in rival.terms.iter().filter(|t| t.stage.id() == one.effect.id) {
            let rotation = !term.axes.iter().take(3).any(|a| *a);
            for ((name, _), value) in term.stage.parameters(rotation).iter().zip(&term.values) {
                if let Some(estimate) = one.estimates.get_mut(*name) {
                    estimate.low = estimate.low.min(*value);
                    estimate.high = estimate.high.max(*value);
                    let interval = [estimate.low, estimate.high];
                    one.effect.interval_95.insert((*name).to_owned(), interval);
                }
            }
        }
    }
}

/// The axes of a term; none where all that move have it.
fn axes_of(term: &Term, active: &[bool; 6]) -> Vec<Axis> {
    if term.axes == *active {
        return Vec::new();
    }
    let own = Axis::ALL.into_iter().filter(|a| term.axes[a.index()]);
    own.collect()
}

fn sampling(stages: &Stages) -> Vec<Named> {
    let logs = &stages.sampling.all;
    let mut named = Vec::new();
    let Some(first) = logs.first() else {
        return named;
    };
    if logs.iter().all(|log| log.is_rounded()) {
        // The step is known to the digits of the log.
        let [force, torque] = first.lsb;
        let mut one = Named::new("ft_quantisation", Vec::new());
        if force > 0.0 {
            one = one.with("lsb_force_n", (force, 1e-4 * force), "N");
        }
        if torque > 0.0 {
            one = one.with("lsb_torque_n_m", (torque, 1e-4 * torque), "N·m");
        }
        one = one.choosing("rounds_down", f64::from(u8::from(first.rounds_down)));
        named.push(one);
    }
    if logs.iter().all(|log| log.held_share > 0.0) {
        let fitted = stages.sampling.train().iter().zip(stages.logs.train());
        let (mut held, mut variance, mut count) = (0.0, 0.0, 0.0);
        for (sampling, log) in fitted {
            let cycles = log.cycle_count() as f64;
            held += sampling.held_share * cycles;
            variance += sampling.held_variance * cycles;
            count += cycles;
        }
        let count = f64::max(count, 1.0);
        let (share, sigma) = (held / count, variance.sqrt() / count);
        named.push(Named::new("ft_dropout", Vec::new()).with("held_share", (share, sigma), "-"));
    }
    named
}

/// A fitted effect on the reading as it stands in a model file.
pub(crate) fn model_of(fitted: &Fitted) -> EffectModel {
    of_reading(fitted).effect
}

/// A fitted effect on the reading.
pub(super) fn of_reading(fitted: &Fitted) -> Named {
    let mut one = Named {
        foretold: fitted.foretold,
        ..Named::new(fitted.id, Vec::new())
    };
    for (name, (value, sigma, unit)) in &fitted.parameters {
        one = if *sigma > 0.0 {
            one.within(name, *value, fitted.interval(name), unit)
        } else {
            one.choosing(name, *value)
        };
    }
    one
}
