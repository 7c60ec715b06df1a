//! Fits a hypothesis to rows of the logs: refines its shapes, solves for its coefficients, and tells which values cannot be.

use super::fitted::{Fitted, FittedParameter};
use super::hypothesis::{Hypothesis, Part};
use super::joint::Joint;
use super::memo::Key;
use super::problem::{Problem, Solution};
use super::refined::Refined;
use super::shaped::{Care, Shaped};
use super::tested::TestedHypothesis;
use super::variants::Library;
use crate::diagnose::evidence::Foretold;
use softdock_physics::effects::Difference;
use softdock_physics::model::Model;
use softdock_physics::model::load::Column;
use softdock_physics::model::load::effects::{Coefficient, LoadEffect};
use softdock_report::number;
use softdock_statistics::DEVIATIONS_95;
use std::collections::BTreeMap;

/// Fits a hypothesis to all logs, with the effort of a screening.
pub(crate) fn tested(
    library: &Library,
    hypothesis: &Hypothesis,
    joint: &Joint,
) -> TestedHypothesis {
    let mut tested = fitted_to(&joint.problem, library, hypothesis, joint, Care::Screening);
    tested.beyond_rounding = joint.gain_beyond_rounding(&tested);
    tested
}

/// The same, fitted to some rows of the logs with a given effort.
pub(crate) fn fitted_to(
    problem: &Problem,
    library: &Library,
    hypothesis: &Hypothesis,
    joint: &Joint,
    care: Care,
) -> TestedHypothesis {
    let key = key([problem, &joint.problem], library, hypothesis, care);
    let fit = || fit(problem, library, hypothesis, joint, care);
    joint.memo.fit(key, fit)
}

fn fit(
    problem: &Problem,
    library: &Library,
    hypothesis: &Hypothesis,
    joint: &Joint,
    care: Care,
) -> TestedHypothesis {
    let mut shaped = Shaped::new(joint, problem, library, &hypothesis.parts);
    let mut refined = Refined::of(hypothesis, &mut shaped, library, joint, care);
    let (solution, white) = solved(hypothesis, &mut shaped, library, &refined, care);
    if care == Care::Estimating {
        refined.estimate(&shaped, &solution);
    }
    let (effects, wrong) = effects_of(hypothesis, &solution, library, refined, joint);
    let first = joint.logs.iter().take(1);
    let known = first.flat_map(|log| &log.scene.model.effects);
    TestedHypothesis {
        effects,
        beside: known.map(|e| e.id.clone()).collect(),
        to_explain: problem.chi2,
        gain: solution.gain,
        gains: problem.gains(&white),
        evidence: hypothesis.evidence + (solution.gain - hypothesis.solution.gain),
        parameters: hypothesis.parameters,
        wrong,
        beyond_rounding: f64::INFINITY,
        of_all_logs: None,
    }
}

/// Solves for the coefficients with the refined shapes. Also returns what they contribute to the whitened reading.
fn solved(
    hypothesis: &Hypothesis,
    shaped: &mut Shaped<'_>,
    library: &Library,
    refined: &Refined,
    care: Care,
) -> (Solution, Column) {
    let shapes = &refined.shapes;
    let solution = shaped.solution().unwrap_or_else(|| Solution {
        gain: 0.0,
        ..hypothesis.solution.clone()
    });
    let linear = |part: &Part| library.variants[part.variant].effect.is_linear();
    let solution = if hypothesis.parts.iter().all(linear) {
        solution
    } else {
        exact(solution, shaped, shapes)
    };
    match shaped.solve_together(&solution, shapes, refined.steps(), care) {
        Some(together) => together,
        None => {
            let white = shaped.sum(&solution.coefficients);
            (solution, white)
        }
    }
}

/// The effects with their parameters, and for each value that cannot be the reason, in words.
fn effects_of(
    hypothesis: &Hypothesis,
    solution: &Solution,
    library: &Library,
    refined: Refined,
    joint: &Joint,
) -> (Vec<Fitted>, Vec<String>) {
    let model = &joint.logs[0].scene.model;
    let (mut effects, mut wrong) = (Vec::new(), Vec::new());
    let mut at = 0;
    for (i, part) in hypothesis.parts.iter().enumerate() {
        let effect = library.variants[part.variant].effect;
        let mut parameters = BTreeMap::new();
        for &k in &part.used {
            if let Some(coefficient) = effect.coefficients.get(k) {
                let value = solution.coefficients[at];
                let deviation = refined.deviations.get(at).unwrap_or(&solution.sigma[at]);
                let parameter = FittedParameter {
                    value,
                    sigma: *deviation,
                    unit: coefficient.unit,
                };
                parameters.insert(coefficient.name, parameter);
                if solution.wrong.contains(&at)
                    || effect.is_implausible(model, coefficient.name, value)
                {
                    wrong.push(forbidden(effect, coefficient, value));
                }
            }
            at += 1;
        }
        for (k, shape) in effect.shapes.iter().enumerate() {
            let parameter = FittedParameter {
                value: refined.shapes[i][k],
                sigma: refined.sigmas.get(&(i, k)).copied().unwrap_or(0.0),
                unit: shape.unit,
            };
            parameters.insert(shape.name, parameter);
        }
        effects.push(Fitted {
            beside_remainder: 1.0,
            elsewhere: BTreeMap::new(),
            foretold: Foretold::UNKNOWN,
            id: effect.id,
            parameters,
        });
    }
    wrong.extend(effects.iter().filter_map(|effect| joint.oversized(effect)));
    wrong.extend(
        effects
            .iter()
            .filter_map(|effect| driving(effect, &effects, model)),
    );
    (effects, wrong)
}

/// A message if a difference between two directions is larger than the amount that differs, which is among the effects or in the
/// model: in one direction the law would then drive. It has to be larger by more than the standard deviations allow, and by more
/// than errors of form make of a damper that acts in one direction only.
fn driving(effect: &Fitted, effects: &[Fitted], model: &Model) -> Option<String> {
    let own = LoadEffect::find(model, effect.id)?;
    let Difference {
        place,
        of,
        of_place,
    } = own.effect.difference_of?;
    let name = own.parameters[place].name;
    let other_name = LoadEffect::find(model, of)?.parameters[of_place].name;
    let FittedParameter { value, sigma, unit } = *effect.parameters.get(name)?;
    let found = effects.iter().find(|one| one.id == of);
    let found = found.and_then(|one| one.parameters.get(other_name));
    let known = model.effects.iter().filter(|one| one.id == of);
    let known: f64 = known.filter_map(|one| one.parameters.get(other_name)).sum();
    let (there, other_sigma) = found.map_or((0.0, 0.0), |other| (other.value, other.sigma));
    let whole = there + known;
    /// Slope with which it drives one way, as a share of that with which it brakes the other.
    const DRIVES: f64 = 0.1;
    let drives = value.abs() - whole;
    let is_sure = drives > DEVIATIONS_95 * sigma.hypot(other_sigma);
    (is_sure && drives > DRIVES * (value.abs() + whole)).then(|| {
        let [value, whole] = [value, whole].map(|v| number::significant(v, 3));
        format!("{name} = {value} {unit} is of larger size than the {whole} {unit} of {of}: in one direction that would drive")
    })
}

/// Why an amount is refused, in words. Of an amount that the logs leave open the end of its range is given instead.
fn forbidden(effect: &LoadEffect, coefficient: &Coefficient, value: f64) -> String {
    /// Beyond so many times its range a value is no estimate.
    const OPEN: f64 = 1e3;
    let unit = match coefficient.unit {
        "-" => String::new(),
        unit => format!(" {unit}"),
    };
    let known = effect
        .parameters
        .iter()
        .find(|p| p.name == coefficient.name);
    let farthest = known.map_or(f64::INFINITY, |p| p.low.abs().max(p.high.abs()));
    let is_beyond = known.is_some_and(|p| value > p.high);
    let is_of_the_tool = known.is_some_and(|p| p.of_the_tool != 0.0 && p.is_plausible(value));
    let (compared, value) = match value.abs() > OPEN * farthest {
        true => (
            if value < 0.0 { "<" } else { ">" },
            farthest.copysign(value),
        ),
        false => ("=", value),
    };
    let digits = number::significant(value, 3);
    let amount = format!("{} {compared} {digits}{unit}", coefficient.name);
    match known {
        Some(_) if is_of_the_tool => format!("{amount} is too little for the tool of the model"),
        Some(p) if p.low < 0.0 || is_beyond => format!(
            "{amount} is not plausible ({} to {}{unit})",
            number::significant(p.low, 3),
            number::significant(p.high, 3)
        ),
        _ => format!("physics forbids {amount}"),
    }
}

/// All on which a fit to `problem` depends, as a key of the memo; the regression of all logs is `of_all`.
fn key(
    [problem, of_all]: [&Problem; 2],
    library: &Library,
    hypothesis: &Hypothesis,
    care: Care,
) -> Key {
    let mut key = vec![u64::from(care == Care::Estimating)];
    for problem in [problem, of_all] {
        key.extend(problem.fingerprint());
    }
    for part in &hypothesis.parts {
        let variant = &library.variants[part.variant];
        // Each entry of a catalogue has an address of its own.
        key.push(std::ptr::from_ref(variant.effect).addr() as u64);
        key.extend(variant.shapes.iter().map(|shape| shape.to_bits()));
        key.push(part.used.len() as u64);
        key.extend(part.used.iter().map(|place| *place as u64));
    }
    let start = &hypothesis.solution;
    let numbers = [start.gain, hypothesis.evidence].into_iter();
    let numbers = numbers.chain(start.coefficients.iter().copied());
    key.extend(numbers.map(f64::to_bits));
    key.push(hypothesis.parameters as u64);
    key
}

/// How often coefficients are solved again with columns linearised around the last ones.
const ROUNDS: usize = 4;

/// For effects that are not linear in their coefficients: the best solution of some rounds, each with columns linearised around
/// the coefficients of the last one.
fn exact(start: Solution, shaped: &mut Shaped<'_>, shapes: &[Vec<f64>]) -> Solution {
    let mut best = start;
    best.gain = shaped
        .gain_around(&best.coefficients, shapes)
        .unwrap_or(best.gain);
    let mut last = best.clone();
    for _ in 0..ROUNDS {
        shaped.set_around(&last.coefficients, shapes);
        let Some(mut next) = shaped.solution() else {
            break;
        };
        let gain = shaped.gain_around(&next.coefficients, shapes);
        next.gain = gain.unwrap_or(f64::NEG_INFINITY);
        if next.gain > best.gain {
            best = next.clone();
        }
        last = next;
    }
    shaped.set_around(&best.coefficients, shapes);
    best
}
