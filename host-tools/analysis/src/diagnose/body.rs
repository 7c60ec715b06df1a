//! What the rig's model of the spacecraft has that the user's does not: another mass, a resistance.
//!
//! The increments of the model velocity are logged without noise, so this is a least-squares fit of
//! logged digits. Columns: the predicted increment itself (a mass that is off by a factor scales
//! it), the same for each rotation, and what the prediction changes by with a resistance of one
//! unit, in which it is linear.

use super::wrench::{Problem, Solution, white};
use crate::model::load::Column;
use crate::model::load::effects::Sign;
use crate::model::prediction::signals::Signals;
use crate::model::prediction::{Prediction, Six, bodies};
use crate::model::{Channel, EffectModel, Model};
use crate::recording::Recording;
use std::collections::BTreeMap;

/// Fall of χ² that a parameter has to bring.
const SIGNIFICANT: f64 = 40.0;
/// Share of the gain that unseen data has to confirm.
const CONFIRMED: f64 = 0.15;
/// A second effect has to add this share.
const ADDED: f64 = 0.02;

/// An effect on the model velocity.
#[derive(Clone, Debug)]
pub(crate) struct BodyFit {
    /// Its id.
    pub id: &'static str,
    /// Value, standard deviation and unit of its parameters.
    pub parameters: BTreeMap<&'static str, (f64, f64, &'static str)>,
    /// Fall of χ² on the log of the fit, and on unseen data.
    pub gain: (f64, f64),
}

/// Name and unit of a parameter.
type Named = (&'static str, &'static str);

/// A hypothesis: an effect with some of its parameters, one for each column.
struct Hypothesis {
    id: &'static str,
    parameters: &'static [Named],
    columns: Vec<Column>,
}

/// One log: residual and increments of the model velocity.
pub(crate) struct BodyRegression {
    problem: Problem,
    hypotheses: Vec<Hypothesis>,
}

const MASS: &str = "sc_mass_error";
const INERTIA: &str = "sc_inertia_error";
const RESISTANCE: &str = "manipulator_resistance";

const MASS_ERROR: [Named; 1] = [("mass_error_kg", "kg")];
const INERTIA_ERRORS: [Named; 3] = [
    ("ixx_kg_m2", "kg·m²"),
    ("iyy_kg_m2", "kg·m²"),
    ("izz_kg_m2", "kg·m²"),
];
const SPRING: Named = ("stiffness_n_per_m", "N/m");
const DAMPER: Named = ("damping_n_s_per_m", "N·s/m");

impl BodyRegression {
    /// From a prediction with the nominal model; None where the channel is not predicted.
    pub(crate) fn new(
        model: &Model,
        recording: &Recording,
        prediction: &Prediction,
    ) -> Option<Self> {
        let channel = prediction.channel(Channel::ModelVelocity);
        let known: Vec<bool> = channel.predicted.iter().map(Option::is_some).collect();
        if !known.contains(&true) {
            return None;
        }
        let judged = prediction.judged(Channel::ModelVelocity);
        let active: [bool; 6] = std::array::from_fn(|i| judged.iter().any(|a| a.index() == i));
        let column = |of: &dyn Fn(usize, usize) -> f64| {
            Column::of(known.len(), |n| {
                std::array::from_fn(|axis| {
                    let value = if n > 0 && known[n] && active[axis] {
                        of(n, axis)
                    } else {
                        0.0
                    };
                    if value.is_finite() { value } else { 0.0 }
                })
            })
        };
        let predicted = |n: usize, axis: usize| channel.predicted[n].map_or(0.0, |p| p[axis]);
        let residual = column(&|n, axis| channel.measured[n][axis] - predicted(n, axis));
        let increment = |n: usize, axis: usize| predicted(n, axis) - channel.measured[n - 1][axis];
        let linear = |axis: usize| f64::from(u8::from(axis < 3));
        let mass = model.bodies.k.mass_kg.unwrap_or(1.0);
        let turning = |turn: usize| {
            column(&|n, axis| {
                if axis == turn {
                    increment(n, axis)
                } else {
                    0.0
                }
            })
        };
        let mut hypotheses = vec![
            Hypothesis {
                id: MASS,
                parameters: &MASS_ERROR,
                columns: vec![column(&|n, axis| linear(axis) * increment(n, axis))],
            },
            Hypothesis {
                id: INERTIA,
                parameters: &INERTIA_ERRORS,
                columns: (3..6).map(turning).collect(),
            },
        ];
        hypotheses.extend(resistances(model, recording, &|other| {
            column(&|n, axis| {
                let other = other[n].map_or(0.0, |other| other[axis]);
                other - predicted(n, axis)
            })
        }));
        let noise = &model.noise;
        let noise_model = std::array::from_fn(|axis| {
            white(if axis < 3 {
                noise.model_velocity_m_s
            } else {
                noise.model_rate_rad_s
            })
        });
        let tolerance = model.tolerance.body_mass_kg / mass;
        let tolerances = if tolerance > 0.0 {
            vec![column(&|n, axis| {
                tolerance * linear(axis) * increment(n, axis)
            })]
        } else {
            Vec::new()
        };
        Some(Self {
            problem: Problem::new(&residual, &tolerances, noise_model, known),
            hypotheses,
        })
    }
}

/// A spring alone, a damper alone, and both: of a parameter that is 0 a fit finds a small value of
/// either sign, and a negative one is refused. `difference` is that to the prediction.
fn resistances(
    model: &Model,
    recording: &Recording,
    difference: &dyn Fn(&[Option<Six>]) -> Column,
) -> Vec<Hypothesis> {
    let of_unit = |(name, _): Named| with_unit(model, recording, name).map(|o| difference(&o));
    let (Some(spring), Some(damper)) = (of_unit(SPRING), of_unit(DAMPER)) else {
        return Vec::new();
    };
    let one = |parameters: &'static [Named], columns: Vec<Column>| Hypothesis {
        id: RESISTANCE,
        parameters,
        columns,
    };
    vec![
        one(&[SPRING], vec![spring.clone()]),
        one(&[DAMPER], vec![damper.clone()]),
        one(&[SPRING, DAMPER], vec![spring, damper]),
    ]
}

/// The model velocity with a resistance of one unit beside what the model has.
fn with_unit(model: &Model, recording: &Recording, name: &str) -> Option<Vec<Option<Six>>> {
    let mut model = model.clone();
    model.effects.push(EffectModel {
        id: RESISTANCE.to_owned(),
        parameters: BTreeMap::from([(name.to_owned(), 1.0)]),
        ..EffectModel::default()
    });
    let signals = Signals::new(recording).ok()?;
    Some(bodies::predict(&model, &signals, &mut Vec::new()).predicted)
}

/// Searches; `excluded` effects are in the model already.
pub(crate) fn search(
    model: &Model,
    train: &BodyRegression,
    test: &BodyRegression,
    excluded: &dyn Fn(&str) -> bool,
) -> Vec<BodyFit> {
    let mut chosen: Vec<usize> = Vec::new();
    let mut reached = (0.0, 0.0);
    loop {
        let is_new = |k: &usize| {
            let id = train.hypotheses[*k].id;
            !excluded(id) && chosen.iter().all(|c| train.hypotheses[*c].id != id)
        };
        let candidates = (0..train.hypotheses.len()).filter(is_new).filter_map(|k| {
            let mut more = chosen.clone();
            more.push(k);
            let gain = gains(train, test, &more)?;
            Some((k, gain))
        });
        let worth = |(k, gain): &(usize, (f64, f64))| {
            gain.0 - SIGNIFICANT * train.hypotheses[*k].columns.len() as f64
        };
        let best = candidates.max_by(|a, b| worth(a).total_cmp(&worth(b)));
        match best {
            Some((k, gain)) if is_worth(gain, reached) => {
                chosen.push(k);
                reached = gain;
            }
            _ => break,
        }
    }
    let Some(solution) = solve(train, &chosen) else {
        return Vec::new();
    };
    let mut at = 0;
    chosen
        .iter()
        .map(|k| {
            let hypothesis = &train.hypotheses[*k];
            let range = at..at + hypothesis.columns.len();
            at = range.end;
            let without: Vec<usize> = chosen.iter().copied().filter(|c| c != k).collect();
            let rest = gains(train, test, &without).unwrap_or((0.0, 0.0));
            BodyFit {
                id: hypothesis.id,
                parameters: parameters(model, hypothesis, &solution, range),
                gain: (reached.0 - rest.0, reached.1 - rest.1),
            }
        })
        .collect()
}

fn is_worth(gain: (f64, f64), before: (f64, f64)) -> bool {
    let more = (gain.0 - before.0, gain.1 - before.1);
    more.0 > SIGNIFICANT + ADDED * before.0 && more.1 > CONFIRMED * more.0
}

fn columns(regression: &BodyRegression, chosen: &[usize]) -> Vec<(Column, Sign)> {
    chosen
        .iter()
        .flat_map(|k| {
            let hypothesis = &regression.hypotheses[*k];
            // A resistance that pushes is none.
            let sign = if hypothesis.id == RESISTANCE {
                Sign::Positive
            } else {
                Sign::Free
            };
            hypothesis.columns.iter().map(move |c| (c.clone(), sign))
        })
        .filter(|(column, _)| !column.is_zero())
        .collect()
}

fn solve(regression: &BodyRegression, chosen: &[usize]) -> Option<Solution> {
    if chosen.is_empty() {
        return None;
    }
    regression.problem.solve(&columns(regression, chosen))
}

/// Fall of χ² on both logs with the coefficients of the first.
fn gains(train: &BodyRegression, test: &BodyRegression, chosen: &[usize]) -> Option<(f64, f64)> {
    if chosen.is_empty() {
        return Some((0.0, 0.0));
    }
    let own = columns(train, chosen);
    let other = columns(test, chosen);
    let solution = train.problem.solve(&own)?;
    if !solution.wrong.is_empty() || own.len() != other.len() {
        return None;
    }
    let count = other
        .iter()
        .flat_map(|(c, _)| c.0.iter().map(Vec::len))
        .max()?;
    let mut sum: [Vec<f64>; 6] = std::array::from_fn(|_| vec![0.0; count]);
    for ((column, _), coefficient) in other.iter().zip(&solution.coefficients) {
        column.add_to(*coefficient, &mut sum);
    }
    Some((solution.gain, test.problem.gain_of(&Column(sum))))
}

fn parameters(
    model: &Model,
    hypothesis: &Hypothesis,
    solution: &Solution,
    range: std::ops::Range<usize>,
) -> BTreeMap<&'static str, (f64, f64, &'static str)> {
    let inertia = model.bodies.k.inertia_kg_m2.unwrap_or_default();
    let fitted = |k: usize| {
        let place = range.start + k;
        (
            solution.coefficients.get(place).copied().unwrap_or(0.0),
            solution.sigma.get(place).copied().unwrap_or(0.0),
        )
    };
    // An increment that is larger by c belongs to a mass that is smaller by 1 + c.
    let scaled = |nominal: f64, (c, sigma): (f64, f64)| {
        let mass = nominal / (1.0 + c);
        (mass - nominal, mass * sigma / (1.0 + c))
    };
    let value = |k: usize| match hypothesis.id {
        MASS => scaled(model.bodies.k.mass_kg.unwrap_or(0.0), fitted(k)),
        INERTIA => scaled(inertia[k][k], fitted(k)),
        _ => fitted(k),
    };
    let named = hypothesis.parameters.iter().enumerate();
    named
        .map(|(k, (name, unit))| {
            let (value, sigma) = value(k);
            (*name, (value, sigma, *unit))
        })
        .collect()
}
