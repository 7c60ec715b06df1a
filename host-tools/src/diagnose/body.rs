//! What the rig's model of the craft has that the user's does not: another mass, a resistance.
//!
//! The increments of the model velocity are logged without noise, so this is a least-squares fit of
//! logged digits. Columns: the predicted increment itself (a mass that is off by a factor scales
//! it), the same for each rotation, position and velocity of the craft.

use super::wrench::{Problem, Solution, white};
use crate::model::load::Column;
use crate::model::load::effects::Sign;
use crate::model::prediction::Prediction;
use crate::model::{Channel, Model};
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

/// One log: residual and increments of the model velocity.
pub(crate) struct BodySide {
    problem: Problem,
    effects: Vec<(&'static str, Vec<Column>)>,
}

const IDS: [&str; 3] = [
    "sc_mass_error",
    "sc_inertia_error",
    "manipulator_resistance",
];

impl BodySide {
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
        let half = 0.5 * prediction.cycle_s / mass;
        let trace = |n: usize| &recording.cycles[n].trace;
        let effects = vec![
            (
                IDS[0],
                vec![column(&|n, axis| linear(axis) * increment(n, axis))],
            ),
            (
                IDS[1],
                (3..6)
                    .map(|turn| {
                        column(&|n, axis| {
                            if axis == turn {
                                increment(n, axis)
                            } else {
                                0.0
                            }
                        })
                    })
                    .collect(),
            ),
            (
                IDS[2],
                vec![
                    column(&|n, axis| {
                        let sum = trace(n).pose[axis] + trace(n - 1).pose[axis];
                        -linear(axis) * half * sum
                    }),
                    column(&|n, axis| {
                        let sum = trace(n).model_velocity[axis] + trace(n - 1).model_velocity[axis];
                        -linear(axis) * half * sum
                    }),
                ],
            ),
        ];
        let noise = &model.noise;
        let colour = std::array::from_fn(|axis| {
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
            problem: Problem::new(&residual, &tolerances, colour, known),
            effects,
        })
    }
}

/// Searches; `excluded` effects are in the model already.
pub(crate) fn search(
    model: &Model,
    train: &BodySide,
    test: &BodySide,
    excluded: &dyn Fn(&str) -> bool,
) -> Vec<BodyFit> {
    let mut chosen: Vec<usize> = Vec::new();
    let mut reached = (0.0, 0.0);
    loop {
        let candidates = (0..train.effects.len())
            .filter(|k| !chosen.contains(k) && !excluded(train.effects[*k].0))
            .filter_map(|k| {
                let mut more = chosen.clone();
                more.push(k);
                let gain = gains(train, test, &more)?;
                Some((k, gain))
            });
        let best = candidates.max_by(|a, b| a.1.0.total_cmp(&b.1.0));
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
            let count = train.effects[*k].1.len();
            let range = at..at + count;
            at += count;
            let without: Vec<usize> = chosen.iter().copied().filter(|c| c != k).collect();
            let rest = gains(train, test, &without).unwrap_or((0.0, 0.0));
            BodyFit {
                id: train.effects[*k].0,
                parameters: parameters(model, train.effects[*k].0, &solution, range),
                gain: (reached.0 - rest.0, reached.1 - rest.1),
            }
        })
        .collect()
}

fn is_worth(gain: (f64, f64), before: (f64, f64)) -> bool {
    let more = (gain.0 - before.0, gain.1 - before.1);
    more.0 > SIGNIFICANT + ADDED * before.0 && more.1 > CONFIRMED * more.0
}

fn columns(side: &BodySide, chosen: &[usize]) -> Vec<(Column, Sign)> {
    chosen
        .iter()
        .flat_map(|k| {
            let (id, columns) = &side.effects[*k];
            // A resistance that pushes is none.
            let sign = if *id == IDS[2] {
                Sign::Positive
            } else {
                Sign::Free
            };
            columns.iter().map(move |c| (c.clone(), sign))
        })
        .filter(|(column, _)| !column.is_zero())
        .collect()
}

fn solve(side: &BodySide, chosen: &[usize]) -> Option<Solution> {
    if chosen.is_empty() {
        return None;
    }
    side.problem.solve(&columns(side, chosen))
}

/// Fall of χ² on both logs with the coefficients of the first.
fn gains(train: &BodySide, test: &BodySide, chosen: &[usize]) -> Option<(f64, f64)> {
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
    id: &str,
    solution: &Solution,
    range: std::ops::Range<usize>,
) -> BTreeMap<&'static str, (f64, f64, &'static str)> {
    let value = |k: usize| {
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
    if id == IDS[0] {
        let nominal = model.bodies.k.mass_kg.unwrap_or(0.0);
        let (error, sigma) = scaled(nominal, value(0));
        BTreeMap::from([("mass_error_kg", (error, sigma, "kg"))])
    } else if id == IDS[1] {
        let names = ["ixx_kg_m2", "iyy_kg_m2", "izz_kg_m2"];
        let inertia = model.bodies.k.inertia_kg_m2.unwrap_or_default();
        (0..range.len().min(3))
            .map(|k| {
                let (error, sigma) = scaled(inertia[k][k], value(k));
                (names[k], (error, sigma, "kg·m²"))
            })
            .collect()
    } else {
        let (stiffness, damping) = (value(0), value(1));
        BTreeMap::from([
            ("stiffness_n_per_m", (stiffness.0, stiffness.1, "N/m")),
            ("damping_n_s_per_m", (damping.0, damping.1, "N·s/m")),
        ])
    }
}
