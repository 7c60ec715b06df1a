//! The search over stages of the actuator, alone and in pairs.

use super::cost::{AxisCost, Cost, Term};
use super::forms::other_forms;
use super::grid::combinations;
use super::pairs::best_pair;
use super::refine::{improved, refined};
use super::steps::best_step;
use super::tried::specs;
use crate::model::actuator::Stage;
use rayon::prelude::*;

/// 2 Δ log L below which a stage is noise (14 stages are tried, each with scanned parameters).
const SIGNIFICANT: f64 = 30.0;
/// Share of the explained error below which a further stage is a detail of the first.
const DETAIL: f64 = 0.01;
/// Share of the gain on the fitted log that unseen data has to confirm.
const CONFIRMED: f64 = 0.15;
/// Gain on the grid below which a stage is not searched further.
const NEGLIGIBLE_GAIN: f64 = 5.0;
/// Residual over noise at which nothing is left to explain.
const AT_NOISE: f64 = 1.03;

/// A hypothesis with its best parameters.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    /// One stage, or two.
    pub terms: Vec<Term>,
    /// χ² on the log of the fit.
    pub train: f64,
    /// χ² on unseen data with the same parameters.
    pub test: f64,
}

/// Result of the search.
#[derive(Clone, Debug)]
pub(crate) struct Search {
    /// χ² of the nominal actuator on both logs.
    pub nominal: (f64, f64),
    /// Stages alone, best first.
    pub singles: Vec<Candidate>,
    /// What is accepted, if anything.
    pub accepted: Option<Candidate>,
    /// Other forms of what is accepted that explain the log as well.
    pub equal_forms: Vec<Candidate>,
}

impl Search {
    /// Takes the noise of a log from what the best hypotheses leave; returns whether it is less.
    pub(crate) fn quieten(&self, cost: &mut Cost<'_>) -> bool {
        /// Hypotheses whose remainder is looked at.
        const BEST: usize = 3;
        let accepted = self.accepted.iter();
        let best = accepted.chain(self.singles.iter().take(BEST));
        cost.quieten(best.map(|c| &c.terms[..]))
    }

    /// Residual over noise of a χ².
    pub(crate) fn level(chi2: f64, cost: &Cost<'_>) -> f64 {
        (chi2 / cost.count().max(1) as f64).sqrt()
    }
}

/// What is asked of a search.
pub(crate) struct Ask<'a> {
    /// Effects that are not tried.
    pub excluded: &'a (dyn Fn(&str) -> bool + Sync),
    /// The best stage is taken although it is not significant.
    pub forced: bool,
    /// No pairs: what is left is known not to be the actuator's.
    pub alone: bool,
}

/// Searches; `test` is the unseen log.
pub(crate) fn search(train: &Cost<'_>, test: &Cost<'_>, ask: &Ask<'_>) -> Search {
    let nominal = (train.of(&[]), test.of(&[]));
    let scopes = scopes(&train.active);
    let mut singles: Vec<Candidate> = Stage::ALL
        .par_iter()
        .filter(|stage| !(ask.excluded)(stage.id()))
        .filter_map(|stage| best_single(*stage, &scopes, train, test))
        .collect();
    singles.sort_by(|a, b| penalised(a).total_cmp(&penalised(b)));
    let mut accepted = singles
        .iter()
        .find(|c| is_a_cause(c) && is_accepted(c, nominal, nominal))
        .cloned();
    let unfinished = accepted.as_ref().map_or_else(
        || Search::level(nominal.0, train) > AT_NOISE,
        |c| Search::level(c.train, train) > AT_NOISE,
    );
    if unfinished && let Some(servo) = complete_servo(&singles, train) {
        let before = accepted.as_ref().map_or(nominal, |c| (c.train, c.test));
        if is_accepted(servo, nominal, before) {
            accepted = Some(servo.clone());
        }
    }
    if unfinished && !ask.alone {
        let alone = accepted.as_ref().map_or(nominal, |c| (c.train, c.test));
        if let Some(pair) = best_pair(&singles, train, test)
            && is_accepted(&pair, nominal, alone)
        {
            accepted = Some(pair);
        }
    }
    if ask.forced && accepted.is_none() {
        accepted = singles.first().cloned();
    }
    let mut equal_forms = Vec::new();
    if let Some(candidate) = &mut accepted {
        equal_forms = choose_form(candidate, train, test);
        prefer_exact_nominal(candidate, train, test);
    }
    Search {
        nominal,
        singles,
        accepted,
        equal_forms,
    }
}

/// Takes the form that explains the log best; returns those that it does not tell from it.
fn choose_form(candidate: &mut Candidate, train: &Cost<'_>, test: &Cost<'_>) -> Vec<Candidate> {
    let mut others = other_forms(candidate, train, test);
    others.sort_by(|a, b| a.train.total_cmp(&b.train));
    if let Some(best) = others.first_mut()
        && best.train < candidate.train
        // Unseen data has the last word on what the log of the fit only just prefers.
        && (best.train + SIGNIFICANT < candidate.train || best.test < candidate.test)
    {
        std::mem::swap(best, candidate);
    }
    // In units of the noise that the best form leaves.
    let noise = (candidate.train / train.count().max(1) as f64).max(1.0);
    let as_good = candidate.train + SIGNIFICANT * noise;
    others.retain(|other| other.train < as_good);
    others
}

/// What a stage explains is not left to the tolerances: its parameters are fitted once more with
/// exact nominal values, if that explains the log as well.
fn prefer_exact_nominal(candidate: &mut Candidate, train: &Cost<'_>, test: &Cost<'_>) {
    let exact = improved(candidate.terms.clone(), train, &|terms| {
        train.exactly(terms)
    });
    if train.exactly(&exact) < candidate.train + SIGNIFICANT {
        candidate.train = train.of(&exact);
        candidate.test = test.of(&exact);
        candidate.terms = exact;
    }
}

/// A servo that leaves nothing but noise: where no other stage does so alone, it is simpler than
/// two of them together.
fn complete_servo<'c>(singles: &'c [Candidate], train: &Cost<'_>) -> Option<&'c Candidate> {
    let servo = |c: &&Candidate| c.terms.iter().all(|term| term.stage == Stage::Servo);
    let found = singles.iter().find(servo)?;
    (Search::level(found.train, train) < AT_NOISE).then_some(found)
}

/// A damped second order imitates delay, lag and limits together: it is a rival of theirs, but no
/// cause beside others. A structure rings.
pub(super) fn is_a_cause(candidate: &Candidate) -> bool {
    /// Damping ratio up to which a mode rings.
    const RINGS: f64 = 0.25;
    candidate.terms.iter().all(|term| match term.stage {
        Stage::Servo => false,
        Stage::Resonance => term.values.get(1).is_some_and(|damping| *damping < RINGS),
        _ => true,
    })
}

/// χ² with a price for each parameter, so that among equals the simplest is first.
pub(super) fn penalised(candidate: &Candidate) -> f64 {
    let parameters: usize = candidate.terms.iter().map(|t| t.values.len()).sum();
    candidate.train + 10.0 * parameters as f64
}

/// Whether a candidate beats `before`, where `nominal` is the error of the nominal actuator.
fn is_accepted(candidate: &Candidate, nominal: (f64, f64), before: (f64, f64)) -> bool {
    let gain = before.0 - candidate.train;
    let on_test = before.1 - candidate.test;
    gain > SIGNIFICANT + DETAIL * (nominal.0 - candidate.train).max(0.0)
        // Unseen data may hold less of an effect: its own error before sets the scale.
        && on_test > CONFIRMED * gain * (before.1 / before.0.max(1e-9)).min(1.0)
}

/// Sets of axes that may have a stage of their own.
fn scopes(active: &[bool; 6]) -> Vec<[bool; 6]> {
    let linear = std::array::from_fn(|i| i < 3 && active[i]);
    let angular = std::array::from_fn(|i| i >= 3 && active[i]);
    let mut scopes = vec![*active];
    let count = active.iter().filter(|a| **a).count();
    if count > 1 {
        for scope in [linear, angular] {
            if scope != *active && scope.contains(&true) {
                scopes.push(scope);
            }
        }
        for axis in (0..6).filter(|a| active[*a]) {
            scopes.push(std::array::from_fn(|i| i == axis));
        }
    }
    scopes
}

fn best_single(
    stage: Stage,
    scopes: &[[bool; 6]],
    train: &Cost<'_>,
    test: &Cost<'_>,
) -> Option<Candidate> {
    let terms = if stage.has_units_of_its_axes() {
        by_kind(stage, train)?
    } else {
        vec![best_scope(stage, scopes, train)?]
    };
    // What the grid does not show at all is not worth a search.
    let hopeless =
        train.total(&train.bare()) - train.of(&terms) < NEGLIGIBLE_GAIN && !slips_through(stage);
    let terms = if hopeless {
        terms
    } else if stage.has_units_of_its_axes() {
        refined(terms, train)
    } else {
        on_all_axes(refined(terms, train), train)
    };
    Some(Candidate {
        train: train.of(&terms),
        test: test.of(&terms),
        terms,
    })
}

/// What the grid saw on some axes only may be on all of them, with a value between its own.
fn on_all_axes(terms: Vec<Term>, train: &Cost<'_>) -> Vec<Term> {
    let some = |t: &Term| (0..6).any(|axis| train.active[axis] && !t.axes[axis]);
    if !terms.iter().any(some) {
        return terms;
    }
    let everywhere = terms.iter().map(|t| Term {
        axes: train.active,
        ..t.clone()
    });
    let everywhere = refined(everywhere.collect(), train);
    if train.of(&everywhere) < train.of(&terms) + SIGNIFICANT {
        everywhere
    } else {
        terms
    }
}

/// Whether the best value may lie between two values of the grid that both make things worse.
fn slips_through(stage: Stage) -> bool {
    matches!(stage, Stage::Delay | Stage::Lag | Stage::Gain)
}

/// The costs of all axes on the grid of a stage.
fn table(stage: Stage, axes: &[bool; 6], train: &Cost<'_>) -> Vec<(Vec<f64>, [AxisCost; 6])> {
    combinations(&specs(stage, &train.scale(axes)))
        .into_par_iter()
        .map(|values| {
            let term = [Term {
                stage,
                values: values.clone(),
                axes: *axes,
            }];
            let costs = std::array::from_fn(|a| {
                if axes[a] {
                    train.of_axis(&train.chain(&term, a), a)
                } else {
                    AxisCost::default()
                }
            });
            (values, costs)
        })
        .collect()
}

/// The best values and the best set of axes for a stage.
fn best_scope(stage: Stage, scopes: &[[bool; 6]], train: &Cost<'_>) -> Option<Term> {
    let bare = train.bare();
    let table = table(stage, scopes.first()?, train);
    let mut best: Option<(f64, Term)> = None;
    for scope in scopes {
        for (values, costs) in &table {
            let mixed = std::array::from_fn(|a| if scope[a] { costs[a] } else { bare[a] });
            let chi2 = train.total(&mixed);
            if best.as_ref().is_none_or(|(least, _)| chi2 < least - 1e-9) {
                let term = Term {
                    stage,
                    values: values.clone(),
                    axes: *scope,
                };
                best = Some((chi2, term));
            }
        }
    }
    best.map(|b| b.1)
}

/// Translations and rotations with a value each, as far as both gain by it.
fn by_kind(stage: Stage, train: &Cost<'_>) -> Option<Vec<Term>> {
    let bare = train.bare();
    let mut kinds: Vec<(f64, Term)> = Vec::new();
    for kind in [0..3, 3..6] {
        let axes: [bool; 6] = std::array::from_fn(|a| kind.contains(&a) && train.active[a]);
        if !axes.contains(&true) {
            continue;
        }
        let of = |(values, costs): (Vec<f64>, [AxisCost; 6])| {
            let mixed = std::array::from_fn(|a| if axes[a] { costs[a] } else { bare[a] });
            (train.total(&mixed), values)
        };
        let best = table(stage, &axes, train).into_iter().map(of);
        let mut values = best.min_by(|a, b| a.0.total_cmp(&b.0))?.1;
        if stage == Stage::CommandStep
            && let Some(step) = best_step(&axes, train)
        {
            values = vec![step];
        }
        let mut term = vec![Term {
            stage,
            values,
            axes,
        }];
        // The grid is coarse: where there is something to explain, a kind is judged by its best
        // value.
        let of_kind = |terms: &[Term]| train.total(&train.of_axes(terms, &axes));
        let noise = AT_NOISE * AT_NOISE * train.count_of(&axes) as f64;
        if of_kind(&[]) > noise {
            term = improved(term, train, &of_kind);
        }
        kinds.push((of_kind(&[]) - of_kind(&term), term.swap_remove(0)));
    }
    kinds.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut terms: Vec<Term> = Vec::new();
    for (gain, term) in kinds {
        if terms.is_empty() || gain > SIGNIFICANT {
            terms.push(term);
        }
    }
    (!terms.is_empty()).then_some(terms)
}
