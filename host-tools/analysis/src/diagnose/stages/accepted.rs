//! What the stages accepted, as effects of a model file.

use super::Stages;
use crate::diagnose::actuator::{Candidate, Search, Term};
use crate::diagnose::evidence::{NEARLY_AS_GOOD, Support};
use crate::diagnose::named::{NamedEffect, of_reading};
use crate::diagnose::wrench::FittedParameter;
use softdock_physics::effects::body::{clock_jitter, clock_offset, clock_rate};
use softdock_physics::model::stage::Stage;
use softdock_physics::model::{Axis, Model};

/// All accepted effects, in the order of the stages.
pub(crate) fn all(model: &Model, stages: &Stages) -> Vec<NamedEffect> {
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
        let one = NamedEffect::new(fit.id, Vec::new());
        let mut one = one.with_support(Support::without_rival(fit.evidence));
        for (name, FittedParameter { value, sigma, unit }) in &fit.parameters {
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
    named.into_iter().map(|one| one.bounded(model)).collect()
}

/// For a tool without nominal mass the fit gives mass times centre of mass: divides by the fitted mass.
fn divide_by_mass(named: &mut [NamedEffect]) {
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

fn clock(stages: &Stages) -> Vec<NamedEffect> {
    let clock = &stages.clock;
    let one = |id: &str, name: &str, value: (f64, f64), unit: &str| {
        NamedEffect::new(id, Vec::new()).with(name, value, unit)
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
    // Jitter biases the estimates of rate and offset, so these are left out beside it.
    match jitter {
        Some(jitter) => vec![jitter],
        None => rate.into_iter().chain(offset).collect(),
    }
}

fn actuator(stages: &Stages) -> Vec<NamedEffect> {
    let Some(found) = &stages.actuator else {
        return Vec::new();
    };
    let (Some(accepted), Some(active)) = (&found.search.accepted, found.white.first()) else {
        return Vec::new();
    };
    let active = active.each_ref().map(|series| !series.is_empty());
    let mut named: Vec<NamedEffect> = Vec::new();
    for (term, intervals) in accepted.terms.iter().zip(&found.intervals) {
        let id = term.stage.id();
        let same = |one: &NamedEffect| one.effect.id == id;
        let one = match named.iter().position(same) {
            // A limit for translations and one for rotations are the same effect.
            Some(at) => named.remove(at),
            None => {
                let of_id = found.search.support.iter().find(|(other, _)| *other == id);
                let support = of_id.map_or(Support::without_rival(f64::INFINITY), |(_, s)| *s);
                NamedEffect::new(id, axes_of(term, &active)).with_support(support)
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
        // If translations and rotations each have a value, axes need not be listed.
        let stage = Stage::of(&one.effect.id, &one.effect.parameters);
        if stage.is_some_and(Stage::has_units_of_its_axes) && one.effect.axes.len() == 3 {
            one.effect.axes.clear();
        }
    }
    named
}

/// Widens the interval of a parameter of a pair so that it covers the estimates of all hypotheses that explain nearly as much:
/// its value depends on which other stage is assumed.
fn widen(one: &mut NamedEffect, search: &Search) {
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

/// The axes of a term; empty if all axes that move have it.
fn axes_of(term: &Term, active: &[bool; 6]) -> Vec<Axis> {
    if term.axes == *active {
        return Vec::new();
    }
    let own = Axis::ALL.into_iter().filter(|a| term.axes[a.index()]);
    own.collect()
}

fn sampling(stages: &Stages) -> Vec<NamedEffect> {
    let logs = &stages.sampling.all;
    let mut named = Vec::new();
    let Some(first) = logs.first() else {
        return named;
    };
    if logs.iter().all(|log| log.is_rounded()) {
        // The step is known to the digits of the log.
        let [force, torque] = first.lsb;
        let mut one = NamedEffect::new("ft_quantisation", Vec::new());
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
        named.push(NamedEffect::new("ft_dropout", Vec::new()).with(
            "held_share",
            (share, sigma),
            "-",
        ));
    }
    named
}
