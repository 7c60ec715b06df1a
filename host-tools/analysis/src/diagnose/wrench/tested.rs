//! A hypothesis with refined shapes.

use super::fits;
use super::fitted::Fitted;
use super::joint::Joint;
use super::problem::{Problem, Solution};
use super::refined::{Care, Refined};
use super::search::{Hypothesis, Part};
use super::shaped::Shaped;
use super::variants::Library;
use crate::diagnose::evidence::Foretold;
use crate::diagnose::finding::Trial;
use softdock_physics::effects::Difference;
use softdock_physics::model::load::effects::{
    Coefficient, LoadEffect, Loaded, Valued, contribution,
};
use softdock_physics::model::load::{Column, Scene};
use softdock_physics::model::{Channel, Model};
use softdock_report::number;
use softdock_statistics::DEVIATIONS_95;
use std::collections::BTreeMap;

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
    pub(super) fn trial(&self) -> Trial {
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
    pub(super) fn loads(&self, scene: &Scene) -> Vec<Valued<'static>> {
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

/// Refines the shapes of a hypothesis on all logs.
pub(super) fn tested(library: &Library, hypothesis: &Hypothesis, joint: &Joint) -> Tested {
    let mut tested = fitted_to(&joint.problem, library, hypothesis, joint, Care::Screening);
    tested.beyond_rounding = joint.gain_beyond_rounding(&tested);
    tested
}

/// The same, fitted to some rows of the logs.
pub(super) fn fitted_to(
    problem: &Problem,
    library: &Library,
    hypothesis: &Hypothesis,
    joint: &Joint,
    care: Care,
) -> Tested {
    let key = fits::key([problem, &joint.problem], library, hypothesis, care);
    let fit = || fit(problem, library, hypothesis, joint, care);
    joint.fits.known_or(key, fit)
}

fn fit(
    problem: &Problem,
    library: &Library,
    hypothesis: &Hypothesis,
    joint: &Joint,
    care: Care,
) -> Tested {
    let mut shaped = Shaped::new(joint, problem, library, &hypothesis.parts);
    let mut refined = Refined::of(hypothesis, &mut shaped, library, joint, care);
    let (solution, white) = solved(hypothesis, &mut shaped, library, &refined, care);
    if care == Care::Estimating {
        refined.estimate(&shaped, &solution);
    }
    let (effects, wrong) = effects_of(hypothesis, &solution, library, refined, joint);
    let first = joint.logs.iter().take(1);
    let known = first.flat_map(|log| &log.scene.model.effects);
    Tested {
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

/// The coefficients with refined shapes, and what they make of the whitened reading.
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
    match shaped.together(&solution, shapes, refined.steps(), care) {
        Some(together) => together,
        None => {
            let white = shaped.sum(&solution.coefficients);
            (solution, white)
        }
    }
}

/// The effects with their parameters, and which of these cannot be.
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
                parameters.insert(coefficient.name, (value, *deviation, coefficient.unit));
                if solution.wrong.contains(&at)
                    || effect.is_implausible(model, coefficient.name, value)
                {
                    wrong.push(forbidden(effect, coefficient, value));
                }
            }
            at += 1;
        }
        for (k, shape) in effect.shapes.iter().enumerate() {
            let sigma = refined.sigmas.get(&(i, k)).copied().unwrap_or(0.0);
            parameters.insert(shape.name, (refined.shapes[i][k], sigma, shape.unit));
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

/// Says so of a difference between two directions that is larger than what differs, which is among the effects or in the model: by
/// more than their deviations, and more than errors of form make of a damper that acts in one direction only.
fn driving(effect: &Fitted, effects: &[Fitted], model: &Model) -> Option<String> {
    let own = LoadEffect::find(model, effect.id)?;
    let Difference {
        place,
        of,
        of_place,
    } = own.effect.difference_of?;
    let name = own.parameters[place].name;
    let other_name = LoadEffect::find(model, of)?.parameters[of_place].name;
    let (value, sigma, unit) = *effect.parameters.get(name)?;
    let found = effects.iter().find(|one| one.id == of);
    let found = found.and_then(|one| one.parameters.get(other_name));
    let known = model.effects.iter().filter(|one| one.id == of);
    let known: f64 = known.filter_map(|one| one.parameters.get(other_name)).sum();
    let (there, other_sigma, _) = found.copied().unwrap_or((0.0, 0.0, unit));
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

/// Why an amount is refused; of one that the logs leave open, the end of its range is said.
fn forbidden(effect: &LoadEffect, coefficient: &Coefficient, value: f64) -> String {
    /// Ranges beyond which a value is no estimate.
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

/// Times that coefficients are found anew with the columns around the last ones.
const ROUNDS: usize = 4;

/// The solution with columns that fit its own coefficients, the best of some rounds.
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
