//! Differences between the rig's own model of the spacecraft and the user's: another mass or inertia, a resistance.
//!
//! The increments of the model velocity are logged without noise, so this is a least-squares fit to logged digits. Its columns
//! are the predicted increment itself (a wrong mass scales it), the same for each rotation (moments of inertia), and the change
//! of the prediction by a resistance of one unit, in which it is linear.

use super::evidence::{self, threshold};
use super::logs::Logs;
use super::noise::autoregressive::AutoregressiveNoise;
use super::wrench::{FittedParameter, Problem, Segment, Solution};
use softdock_io::recording::Recording;
use softdock_physics::effects::body::{sc_inertia_error, sc_mass_error};
use softdock_physics::effects::mechanism::manipulator_resistance;
use softdock_physics::model::load::Column;
use softdock_physics::model::load::effects::Sign;
use softdock_physics::model::prediction::signals::Signals;
use softdock_physics::model::prediction::{ChannelPrediction, Prediction, Six, bodies};
use softdock_physics::model::{Channel, EffectModel, Model};
use std::collections::BTreeMap;

/// An effect on the model velocity.
#[derive(Clone, Debug)]
pub(crate) struct BodyFit {
    /// Its id.
    pub id: &'static str,
    /// Its parameters by name.
    pub parameters: BTreeMap<&'static str, FittedParameter>,
    /// Fall of χ² on each log, beside the other accepted effects.
    pub gains: Vec<f64>,
    /// Evidence for it beside the other accepted effects.
    pub evidence: f64,
    /// The logs disagree about it.
    pub disagrees: bool,
}

/// Result of the search.
#[derive(Clone, Debug, Default)]
pub(crate) struct BodySearch {
    /// Accepted effects.
    pub accepted: Vec<BodyFit>,
    /// The largest evidence of any effect beside those that were found before it.
    pub strongest: Option<f64>,
}

/// Name and unit of a parameter.
type ParameterName = (&'static str, &'static str);

/// A hypothesis: an effect with some of its parameters, one for each column.
struct Hypothesis {
    id: &'static str,
    /// A choice of its form, if it is not the default one.
    form: Option<&'static str>,
    parameters: &'static [ParameterName],
    columns: Vec<Column>,
}

/// The regression of one log: residual and columns of the model velocity, cycle by cycle.
pub(crate) struct BodyRegression {
    segment: Segment,
    residual: Column,
    tolerances: Vec<Column>,
    hypotheses: Vec<Hypothesis>,
}

const MASS: &str = sc_mass_error::EFFECT.id;
const INERTIA: &str = sc_inertia_error::EFFECT.id;
const RESISTANCE: &str = manipulator_resistance::EFFECT.id;

const MASS_ERROR: [ParameterName; 1] = [("mass_error_kg", "kg")];
const INERTIA_ERRORS: [ParameterName; 3] = [
    ("ixx_kg_m2", "kg·m²"),
    ("iyy_kg_m2", "kg·m²"),
    ("izz_kg_m2", "kg·m²"),
];
const SPRING: ParameterName = ("stiffness_n_per_m", "N/m");
/// Choice of a spring that is relaxed where the log begins.
const ABOUT_START: &str = "about_start";
const DAMPER: ParameterName = ("damping_n_s_per_m", "N·s/m");

impl BodyRegression {
    /// From a prediction with the nominal model. `None` if it does not predict this channel.
    pub(crate) fn new(
        model: &Model,
        recording: &Recording,
        prediction: &Prediction,
    ) -> Option<Self> {
        let changes = Changes::of(prediction)?;
        let of_mass = |share: f64| {
            changes.column(&|n, axis| share * linear(axis) * changes.increment(n, axis))
        };
        let turning = |turn: usize| {
            changes.column(&|n, axis| match axis == turn {
                true => changes.increment(n, axis),
                false => 0.0,
            })
        };
        let one = |id, parameters, columns| Hypothesis {
            id,
            form: None,
            parameters,
            columns,
        };
        let mut hypotheses = vec![
            one(MASS, &MASS_ERROR, vec![of_mass(1.0)]),
            one(INERTIA, &INERTIA_ERRORS, (3..6).map(turning).collect()),
        ];
        hypotheses.extend(resistances(model, recording, &|other| {
            changes.column(&|n, axis| {
                let other = other[n].map_or(0.0, |other| other[axis]);
                other - changes.predicted(n, axis)
            })
        }));
        let noise = &model.noise;
        let digits = [noise.model_velocity_m_s, noise.model_rate_rad_s];
        let tolerance = model.tolerance.body_mass_kg / model.bodies.k.mass_kg.unwrap_or(1.0);
        let tolerances = (tolerance > 0.0).then(|| of_mass(tolerance));
        Some(Self {
            residual: changes
                .column(&|n, axis| changes.channel.measured[n][axis] - changes.predicted(n, axis)),
            tolerances: tolerances.into_iter().collect(),
            hypotheses,
            segment: Segment {
                noise_model: std::array::from_fn(|axis| {
                    AutoregressiveNoise::white(digits[axis / 3])
                }),
                fresh: changes.known,
            },
        })
    }
}

/// 1 for a translation.
fn linear(axis: usize) -> f64 {
    if axis < 3 { 1.0 } else { 0.0 }
}

/// Predicted changes of the model velocity from cycle to cycle.
struct Changes<'a> {
    channel: &'a ChannelPrediction,
    known: Vec<bool>,
    active: [bool; 6],
}

impl<'a> Changes<'a> {
    /// None where the channel is not predicted.
    fn of(prediction: &'a Prediction) -> Option<Self> {
        let channel = prediction.channel(Channel::ModelVelocity);
        let judged = prediction.judged(Channel::ModelVelocity);
        let known: Vec<bool> = channel.predicted.iter().map(Option::is_some).collect();
        known.contains(&true).then(|| Self {
            channel,
            known,
            active: std::array::from_fn(|i| judged.iter().any(|axis| axis.index() == i)),
        })
    }

    fn predicted(&self, n: usize, axis: usize) -> f64 {
        self.channel.predicted[n].map_or(0.0, |p| p[axis])
    }

    fn increment(&self, n: usize, axis: usize) -> f64 {
        self.predicted(n, axis) - self.channel.measured[n - 1][axis]
    }

    /// A column with the values of `of` (cycle, axis) in each predicted cycle and on each axis that moves; 0 elsewhere.
    fn column(&self, of: &dyn Fn(usize, usize) -> f64) -> Column {
        let value = |n: usize, axis: usize| {
            let counts = n > 0 && self.known[n] && self.active[axis];
            let value = if counts { of(n, axis) } else { 0.0 };
            if value.is_finite() { value } else { 0.0 }
        };
        Column::of(self.known.len(), |n| {
            std::array::from_fn(|axis| value(n, axis))
        })
    }
}

/// A spring alone, a damper alone, and both. If a parameter is 0, a fit of both finds a small value of either sign, and a
/// negative one is refused. The spring is relaxed at the origin of C, or where the log begins. `difference` gives the column of a
/// changed prediction.
fn resistances(
    model: &Model,
    recording: &Recording,
    difference: &dyn Fn(&[Option<Six>]) -> Column,
) -> Vec<Hypothesis> {
    let of_unit = |(name, _): ParameterName, form: Option<&str>| {
        with_unit(model, recording, name, form).map(|other| difference(&other))
    };
    let one = |form, parameters: &'static [ParameterName], columns: Vec<Column>| Hypothesis {
        id: RESISTANCE,
        form,
        parameters,
        columns,
    };
    let Some(damper) = of_unit(DAMPER, None) else {
        return Vec::new();
    };
    let mut all = vec![one(None, &[DAMPER], vec![damper.clone()])];
    for form in [None, Some(ABOUT_START)] {
        if let Some(spring) = of_unit(SPRING, form) {
            all.push(one(form, &[SPRING], vec![spring.clone()]));
            all.push(one(form, &[SPRING, DAMPER], vec![spring, damper.clone()]));
        }
    }
    all
}

/// The predicted model velocity with a resistance of one unit beside the effects of the model; `None` if the signals cannot be
/// read.
fn with_unit(
    model: &Model,
    recording: &Recording,
    name: &str,
    form: Option<&str>,
) -> Option<Vec<Option<Six>>> {
    let mut model = model.clone();
    let form = form.map(|form| (form.to_owned(), 1.0));
    model.effects.push(EffectModel {
        id: RESISTANCE.to_owned(),
        parameters: std::iter::once((name.to_owned(), 1.0))
            .chain(form)
            .collect(),
        ..EffectModel::default()
    });
    let signals = Signals::new(recording).ok()?;
    Some(bodies::predict(&model, &signals, &mut Vec::new()).predicted)
}

/// All logs with one regression.
struct Joint<'a> {
    logs: &'a Logs<BodyRegression>,
    problem: Problem,
    /// Whitened columns of each hypothesis over all logs.
    white: Vec<Vec<Column>>,
    price: f64,
}

impl<'a> Joint<'a> {
    fn new(logs: &'a Logs<BodyRegression>, keeps: impl Fn(usize) -> bool) -> Self {
        let segment = |(k, log): (usize, &BodyRegression)| {
            let mut segment = log.segment.clone();
            if !keeps(k) {
                segment.fresh.fill(false);
            }
            segment
        };
        let residuals: Vec<&Column> = logs.all.iter().map(|log| &log.residual).collect();
        let tolerances: Vec<&[Column]> = logs.all.iter().map(|log| &log.tolerances[..]).collect();
        let segments = logs.all.iter().enumerate().map(segment).collect();
        let problem = Problem::new(segments, &residuals, &tolerances);
        let hypotheses = &logs.all[0].hypotheses;
        let white = (0..hypotheses.len())
            .map(|h| {
                let column = |k: usize| {
                    let each = logs.all.iter().map(|log| &log.hypotheses[h].columns[k]);
                    problem.whitened(&each.collect::<Vec<_>>())
                };
                (0..hypotheses[h].columns.len()).map(column).collect()
            })
            .collect();
        Self {
            price: evidence::price(problem.count),
            logs,
            problem,
            white,
        }
    }

    fn hypothesis(&self, k: usize) -> &Hypothesis {
        &self.logs.all[0].hypotheses[k]
    }

    /// Columns of some hypotheses with their sign constraints. Columns of axes that do not move are left out, as they are 0.
    fn columns(&self, chosen: &[usize]) -> (Vec<&Column>, Vec<Sign>) {
        let each = chosen.iter().flat_map(|k| {
            // A resistance must not push.
            let sign = if self.hypothesis(*k).id == RESISTANCE {
                Sign::Positive
            } else {
                Sign::Free
            };
            self.white[*k].iter().map(move |c| (c, sign))
        });
        each.filter(|(column, _)| !column.is_zero()).unzip()
    }

    /// For each column of a hypothesis: whether it is not 0.
    fn acting(&self, k: usize) -> Vec<bool> {
        self.white[k]
            .iter()
            .map(|column| !column.is_zero())
            .collect()
    }

    fn solve(&self, chosen: &[usize]) -> Option<Solution> {
        if chosen.is_empty() {
            return None;
        }
        let (columns, signs) = self.columns(chosen);
        let solution = self.problem.solve_whitened(&columns, &signs)?;
        solution.wrong.is_empty().then_some(solution)
    }

    fn evidence(&self, chosen: &[usize]) -> Option<f64> {
        if chosen.is_empty() {
            return Some(0.0);
        }
        let acting = |k: &usize| self.acting(*k).iter().filter(|acts| **acts).count();
        let parameters: usize = chosen.iter().map(acting).sum();
        let price = self.price * parameters as f64 + evidence::prior() * chosen.len() as f64;
        Some(self.solve(chosen)?.gain - price)
    }

    /// The whitened contribution of some hypotheses.
    fn part(&self, chosen: &[usize]) -> Column {
        let mut sum = Column::default();
        if let Some(solution) = self.solve(chosen) {
            for (column, factor) in self.columns(chosen).0.iter().zip(&solution.coefficients) {
                let scaled = column.0.each_ref();
                sum.add(&scaled.map(|s| s.iter().map(|v| factor * v).collect()));
            }
        }
        sum
    }

    /// χ² of each log beside some hypotheses.
    fn squares(&self, chosen: &[usize]) -> Vec<f64> {
        let part = self.part(chosen);
        let rest = self
            .problem
            .rest(&part, &self.problem.tolerances_with(&part));
        let of = |log: usize| {
            let rest = self.problem.part(&rest, log);
            rest.0.iter().flatten().map(|r| r * r).sum()
        };
        (0..self.logs.all.len()).map(of).collect()
    }

    /// The largest gain in χ² if one log gets an amount of hypothesis `k` of its own, beside all that is chosen.
    fn contrast(&self, chosen: &[usize], k: usize) -> f64 {
        let (mut columns, mut signs) = self.columns(chosen);
        signs.fill(Sign::Free);
        let gain = |columns: &[&Column], signs: &[Sign]| {
            let solution = self.problem.solve_whitened(columns, signs);
            solution.map_or(f64::NEG_INFINITY, |s| s.gain)
        };
        let common = gain(&columns, &signs);
        let own = self.part(&[k]);
        signs.push(Sign::Free);
        let masked = (0..self.logs.all.len()).map(|log| self.problem.masked(&own, log));
        let masked: Vec<Column> = masked.collect();
        let mut most = 0.0_f64;
        for column in &masked {
            columns.push(column);
            most = most.max(gain(&columns, &signs) - common);
            columns.pop();
        }
        most
    }
}

/// Searches for effects; `excluded` ones are in the model already.
pub(crate) fn search(
    model: &Model,
    logs: &Logs<BodyRegression>,
    excluded: &dyn Fn(&str) -> bool,
) -> BodySearch {
    let joint = Joint::new(logs, |_| true);
    let fitted = Joint::new(logs, |log| log < logs.fitted);
    let chosen = joint.chosen(excluded);
    let solution = fitted.solve(&chosen.places);
    let solution = solution.or_else(|| joint.solve(&chosen.places));
    BodySearch {
        accepted: solution.map_or_else(Vec::new, |s| joint.fits(model, &chosen, &s)),
        strongest: chosen.strongest,
    }
}

/// Hypotheses that were accepted one after the other.
#[derive(Default)]
struct Chosen {
    places: Vec<usize>,
    /// Evidence of all of them together.
    evidence: f64,
    /// See [`BodySearch::strongest`].
    strongest: Option<f64>,
}

impl Joint<'_> {
    /// Adds the best hypothesis beside those that were added before, as long as its evidence exceeds the threshold.
    fn chosen(&self, excluded: &dyn Fn(&str) -> bool) -> Chosen {
        let mut chosen = Chosen::default();
        loop {
            let before = &chosen.places;
            let is_new = |k: &usize| {
                let id = self.hypothesis(*k).id;
                !excluded(id) && before.iter().all(|c| self.hypothesis(*c).id != id)
            };
            let candidates = (0..self.white.len()).filter(is_new).filter_map(|k| {
                let more = [&before[..], &[k]].concat();
                Some((k, self.evidence(&more)?))
            });
            let explained = self.solve(before).map_or(0.0, |s| s.gain);
            let best = candidates.max_by(|a, b| a.1.total_cmp(&b.1));
            let more = best.map(|(_, evidence)| evidence - chosen.evidence);
            let strongest = chosen.strongest.into_iter().chain(more);
            chosen.strongest = strongest.max_by(f64::total_cmp);
            match best {
                Some((k, evidence)) if evidence - chosen.evidence > threshold(explained) => {
                    chosen.places.push(k);
                    chosen.evidence = evidence;
                }
                _ => return chosen,
            }
        }
    }

    /// The chosen effects with the parameters of a solution.
    fn fits(&self, model: &Model, chosen: &Chosen, solution: &Solution) -> Vec<BodyFit> {
        let all = self.squares(&chosen.places);
        let left = all.iter().sum::<f64>() - self.problem.count as f64;
        // Logged digits have no noise, so evidence alone says little: logs disagree only if own amounts also explain most of what
        // is left.
        let disagrees = |k: usize, evidence: f64| {
            let own = self.contrast(&chosen.places, k);
            own > 0.5 * left && evidence::disagree(own, evidence, 1, self.problem.count)
        };
        let mut at = 0;
        let fit = |k: &usize| {
            let hypothesis = self.hypothesis(*k);
            let places: Vec<Option<usize>> = self
                .acting(*k)
                .into_iter()
                .map(|acts| {
                    at += usize::from(acts);
                    acts.then(|| at - 1)
                })
                .collect();
            let others = chosen.places.iter().copied().filter(|c| c != k);
            let others: Vec<usize> = others.collect();
            let without = self.squares(&others);
            let evidence = chosen.evidence - self.evidence(&others).unwrap_or(0.0);
            BodyFit {
                id: hypothesis.id,
                parameters: parameters(model, hypothesis, solution, &places),
                gains: without.iter().zip(&all).map(|(w, a)| w - a).collect(),
                evidence,
                disagrees: disagrees(*k, evidence),
            }
        };
        chosen.places.iter().map(fit).collect()
    }
}

/// The parameters of a hypothesis with their values. `places` maps each to a coefficient of the solution, or to none.
fn parameters(
    model: &Model,
    hypothesis: &Hypothesis,
    solution: &Solution,
    places: &[Option<usize>],
) -> BTreeMap<&'static str, FittedParameter> {
    let inertia = model.bodies.k.inertia_kg_m2.unwrap_or_default();
    let fitted = |place: usize| {
        (
            solution.coefficients.get(place).copied().unwrap_or(0.0),
            solution.sigma.get(place).copied().unwrap_or(0.0),
        )
    };
    // If the increment is larger by a share c, the mass is smaller by a factor 1 + c.
    let scaled = |nominal: f64, (c, sigma): (f64, f64)| {
        let mass = nominal / (1.0 + c);
        (mass - nominal, mass * sigma / (1.0 + c))
    };
    let value = |k: usize, place: usize| match hypothesis.id {
        MASS => scaled(model.bodies.k.mass_kg.unwrap_or(0.0), fitted(place)),
        INERTIA => scaled(inertia[k][k], fitted(place)),
        _ => fitted(place),
    };
    let named = hypothesis.parameters.iter().zip(places).enumerate();
    let named = named.filter_map(|(k, ((name, unit), place))| {
        let (value, sigma) = value(k, (*place)?);
        let unit = *unit;
        Some((*name, FittedParameter { value, sigma, unit }))
    });
    let chosen = FittedParameter {
        value: 1.0,
        sigma: 0.0,
        unit: "-",
    };
    let form = hypothesis.form.map(|form| (form, chosen));
    named.chain(form).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rig that turns about z alone does not show the other moments of inertia.
    #[test]
    fn a_moment_of_inertia_is_that_of_the_axis_that_turns() {
        let mut model = Model::default();
        let inertia = [[100.0, 0.0, 0.0], [0.0, 200.0, 0.0], [0.0, 0.0, 300.0]];
        model.bodies.k.inertia_kg_m2 = Some(inertia);
        let hypothesis = Hypothesis {
            id: INERTIA,
            form: None,
            parameters: &INERTIA_ERRORS,
            columns: Vec::new(),
        };
        let solution = Solution {
            gain: 0.0,
            coefficients: vec![0.25],
            sigma: vec![0.01],
            wrong: Vec::new(),
        };
        let found = parameters(&model, &hypothesis, &solution, &[None, None, Some(0)]);
        let names: Vec<&str> = found.keys().copied().collect();
        assert_eq!(names, ["izz_kg_m2"]);
        assert!((found["izz_kg_m2"].value + 60.0).abs() < 1e-9);
    }
}
