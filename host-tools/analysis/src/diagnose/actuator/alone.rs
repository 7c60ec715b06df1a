//! The best values and axes of one stage, alone or beside given terms.

use super::candidate::{AT_NOISE, Candidate, is_a_gain};
use super::cost::{AxisCost, Cost, Term};
use super::dead_zone::best_zone;
use super::grid::combinations;
use super::refine::{improved, refined};
use super::steps::best_step;
use super::tried::specs;
use crate::diagnose::evidence::{self, TOLD_APART, threshold};
use rayon::prelude::*;
use softdock_physics::model::stage::Stage;

/// Gain in χ² on the grid below which a stage is not searched further.
pub(super) const NEGLIGIBLE_GAIN: f64 = 5.0;

/// Sets of axes that may have a stage of their own.
pub(super) fn scopes(active: &[bool; 6]) -> Vec<[bool; 6]> {
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

/// The best values of a stage beside given terms, which are refined with it. A dead zone is searched with the gains of what lies
/// beyond it. `None` if no values are found.
pub(super) fn best_single(
    stage: Stage,
    scopes: &[[bool; 6]],
    cost: &Cost<'_>,
    beside: &[Term],
    excluded: &dyn Fn(&str) -> bool,
) -> Option<Candidate> {
    if stage == Stage::DeadZone {
        return best_dead_zone(cost, beside, excluded);
    }
    let terms = if stage.has_units_of_its_axes() {
        by_kind(cost, beside, &|axes| of_axes(stage, axes, cost, beside))?
    } else {
        vec![best_scope(stage, scopes, cost, beside)?]
    };
    let all = [beside, &terms[..]].concat();
    // A stage that gains nothing on the grid is not worth a search.
    let hopeless = cost.of(beside) - cost.of(&all) < NEGLIGIBLE_GAIN && !slips_through(stage);
    let all = if hopeless {
        all
    } else if stage.has_units_of_its_axes() {
        refined(all, cost)
    } else {
        let scoped = rescoped(refined(all, cost), scopes, cost);
        if beside.is_empty() {
            on_all_axes(scoped, cost)
        } else {
            scoped
        }
    };
    Some(Candidate::new(all, cost))
}

/// The best dead zone beside given terms. Its gain, and its gain by direction, are left out if they are not worth their price.
fn best_dead_zone(
    cost: &Cost<'_>,
    beside: &[Term],
    excluded: &dyn Fn(&str) -> bool,
) -> Option<Candidate> {
    let others = beside.iter().filter(|t| !is_a_gain(t.stage));
    let others: Vec<Term> = others.cloned().collect();
    let of_zone = |axes: &[bool; 6]| best_zone(axes, cost, &others, excluded);
    let terms = by_kind(cost, &others, &of_zone)?;
    let refine = |terms: Vec<Term>| Candidate::new(refined(terms, cost), cost);
    let mut best = refine([&others[..], &terms].concat());
    for stage in [Stage::Direction, Stage::Gain] {
        let mut fewer = best.terms.clone();
        fewer.retain(|term| term.stage != stage);
        let fewer = refine(fewer);
        if fewer.priced(cost) < best.priced(cost) {
            best = fewer;
        }
    }
    Some(best)
}

/// Moves the last term to other axes if these explain clearly more. The axes were chosen on a coarse grid, where a mode that is
/// not quite right is no better even on the axes that have it.
fn rescoped(terms: Vec<Term>, scopes: &[[bool; 6]], cost: &Cost<'_>) -> Vec<Term> {
    let on = |scope: &[bool; 6]| {
        let mut terms = terms.clone();
        if let Some(last) = terms.last_mut() {
            last.axes = *scope;
        }
        (cost.of(&terms), terms)
    };
    let best = scopes.iter().map(on).min_by(|a, b| a.0.total_cmp(&b.0));
    match best {
        Some((chi2, other)) if chi2 + TOLD_APART < cost.of(&terms) => refined(other, cost),
        _ => terms,
    }
}

/// Puts all terms on all axes if that explains the logs as well: what the grid saw on some axes only may act on all, with a value
/// between the grid's.
fn on_all_axes(terms: Vec<Term>, cost: &Cost<'_>) -> Vec<Term> {
    let some = |t: &Term| (0..6).any(|axis| cost.active[axis] && !t.axes[axis]);
    if !terms.iter().any(some) {
        return terms;
    }
    let everywhere = terms.iter().map(|t| Term {
        axes: cost.active,
        ..t.clone()
    });
    let everywhere = refined(everywhere.collect(), cost);
    if cost.of(&everywhere) < cost.of(&terms) + TOLD_APART {
        everywhere
    } else {
        terms
    }
}

/// Whether the best value may lie between two values of the grid that both make things worse.
fn slips_through(stage: Stage) -> bool {
    matches!(
        stage,
        Stage::Delay | Stage::Lag | Stage::Gain | Stage::Direction
    )
}

/// For each combination of values on the grid of a stage: the cost of each axis beside given terms.
fn table(
    stage: Stage,
    axes: &[bool; 6],
    cost: &Cost<'_>,
    beside: &[Term],
) -> Vec<(Vec<f64>, [AxisCost; 6])> {
    combinations(&specs(stage, &cost.scale(axes)))
        .into_par_iter()
        .map(|values| {
            let term = Term {
                stage,
                values: values.clone(),
                axes: *axes,
            };
            let terms = [beside, &[term]].concat();
            let costs = cost.of_axes(&terms, axes);
            (values, costs)
        })
        .collect()
}

/// The best values and the best set of axes for a stage.
fn best_scope(
    stage: Stage,
    scopes: &[[bool; 6]],
    cost: &Cost<'_>,
    beside: &[Term],
) -> Option<Term> {
    let bare = cost.of_axes(beside, &cost.active);
    let table = table(stage, scopes.first()?, cost, beside);
    let mut best: Option<(f64, Term)> = None;
    for scope in scopes {
        for (values, costs) in &table {
            let mixed = std::array::from_fn(|a| if scope[a] { costs[a] } else { bare[a] });
            let chi2 = cost.total(&mixed);
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

/// Terms for translations and for rotations, as `of_axes` finds them for each kind. The kind that gains more is always taken, the
/// other one if its gain is worth its price.
fn by_kind(
    cost: &Cost<'_>,
    beside: &[Term],
    of_axes: &dyn Fn(&[bool; 6]) -> Option<Vec<Term>>,
) -> Option<Vec<Term>> {
    let mut kinds: Vec<(f64, Vec<Term>)> = Vec::new();
    for kind in [0..3_usize, 3..6] {
        let axes: [bool; 6] = std::array::from_fn(|a| kind.contains(&a) && cost.active[a]);
        if !axes.contains(&true) {
            continue;
        }
        let of_kind = |terms: &[Term]| {
            let all = [beside, terms].concat();
            cost.total(&cost.of_axes(&all, &axes))
        };
        let Some(mut terms) = of_axes(&axes) else {
            continue;
        };
        // On a coarse grid a good kind may look poor: where there is something to explain, it is judged by its best value.
        let noise = AT_NOISE * AT_NOISE * cost.count_of(&axes) as f64;
        if of_kind(&[]) > noise {
            terms = improved(terms, cost, &of_kind);
        }
        let rotates = kind.start == 3;
        if !terms.iter().all(|t| t.stage.holds(rotates, &t.values)) {
            continue;
        }
        kinds.push((of_kind(&[]) - of_kind(&terms), terms));
    }
    kinds.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut terms: Vec<Term> = Vec::new();
    for (gain, of_kind) in kinds {
        if terms.is_empty() || gain > threshold(0.0) + evidence::price(cost.count()) {
            terms.extend(of_kind);
        }
    }
    (!terms.is_empty()).then_some(terms)
}

/// The best value of a stage for axes of one kind, from a grid or, for a command step, from a search of its own.
fn of_axes(stage: Stage, axes: &[bool; 6], cost: &Cost<'_>, beside: &[Term]) -> Option<Vec<Term>> {
    let term = |values| {
        vec![Term {
            stage,
            values,
            axes: *axes,
        }]
    };
    let sought = match stage {
        Stage::CommandStep => best_step(axes, cost).map(|step| term(vec![step])),
        _ => None,
    };
    let bare = cost.of_axes(beside, &cost.active);
    let on_grid = || {
        let of = |(values, costs): (Vec<f64>, [AxisCost; 6])| {
            let mixed = std::array::from_fn(|a| if axes[a] { costs[a] } else { bare[a] });
            (cost.total(&mixed), values)
        };
        let best = table(stage, axes, cost, beside).into_iter().map(of);
        best.min_by(|a, b| a.0.total_cmp(&b.0))
    };
    sought.or_else(|| on_grid().map(|best| term(best.1)))
}
