//! The step to which commands are rounded.
//!
//! Rounding to another step than the true one leaves an error that has nothing to do with the true
//! one. χ² therefore falls only where both agree in the whole range of velocities: where the number
//! of steps in the largest velocity is right to a small fraction of one. The grid is uniform in that
//! number, and axes without any error do not count.

use super::cost::{AxisCost, Cost, LogCost, Term};
use super::refine::bottom;
use softdock_physics::model::stage::Stage;
use softdock_statistics::rms;

/// Steps in the largest velocity that are tried, at most; finer rounding is a detail of any error.
const MOST: f64 = 40.0;
/// Fewest: with half a step nothing moves.
const FEWEST: f64 = 0.5;
/// Distance of two values of the grid. Half of an error of the number of steps is the share of
/// commands that are rounded to the wrong side, by a whole step each, where no rounding at all costs
/// a twelfth of that: only within a sixth of a step χ² falls.
const APART: f64 = 0.1;
/// The same as a share: a command that stands still close to where two steps meet is rounded to
/// the wrong side for long.
const APART_BY_RATIO: f64 = 0.008;
/// Valleys that are looked into.
const VALLEYS: usize = 4;
/// Values of an axis' command that a step has to round, at least: of a few a gain or an offset does the same. Set by
/// hand.
const COMMANDS: usize = 10;
/// Error over the data sheet's noise above which there is something to explain.
const VISIBLE: f64 = 1.03;

/// The step of the axes of one kind that explains them best; None where nothing is wrong.
pub(super) fn best_step(axes: &[bool; 6], cost: &Cost<'_>) -> Option<f64> {
    let wrong: Vec<usize> = (0..6)
        .filter(|axis| axes[*axis] && level(cost, *axis) > VISIBLE)
        .collect();
    let fastest = cost.scale(axes).sent_velocity;
    if fastest <= 0.0
        || wrong.is_empty()
        || !wrong.iter().any(|axis| cost.commands(*axis) >= COMMANDS)
    {
        return None;
    }
    let mut unrounded = [AxisCost::default(); 6];
    for axis in &wrong {
        unrounded[*axis] = cost.of_axis(&cost.chain(&[], *axis), *axis);
    }
    let unrounded = cost.total(&unrounded);
    let of = |steps: f64| {
        let term = [Term {
            stage: Stage::CommandStep,
            values: vec![fastest / steps],
            axes: *axes,
        }];
        let mut costs = [AxisCost::default(); 6];
        let mut sum = 0.0;
        for axis in &wrong {
            costs[*axis] = cost.of_axis(&cost.chain(&term, *axis), *axis);
            sum = cost.total(&costs);
            // What is worse than no rounding need not be known exactly.
            if sum > unrounded {
                break;
            }
        }
        sum
    };
    let mut grid: Vec<(f64, f64)> = places().map(|steps| (of(steps), steps)).collect();
    grid.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut valleys: Vec<f64> = Vec::new();
    for (_, steps) in grid {
        let is_new = valleys
            .iter()
            .all(|v| (v - steps).abs() > 2.5 * apart(steps));
        if is_new && valleys.len() < VALLEYS {
            valleys.push(steps);
        }
    }
    let refined = valleys.into_iter();
    let refined = refined.map(|steps| bottom(steps - apart(steps), steps + apart(steps), of));
    let best = refined.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(fastest / best.0)
}

fn apart(steps: f64) -> f64 {
    APART.min(APART_BY_RATIO * steps)
}

/// Numbers of steps on the grid.
fn places() -> impl Iterator<Item = f64> {
    std::iter::successors(Some(FEWEST), |steps| Some(steps + apart(*steps)))
        .take_while(|steps| *steps < MOST)
}

/// Error of an axis with the nominal actuator, over the data sheet's noise.
fn level(cost: &Cost<'_>, axis: usize) -> f64 {
    let chain = cost.chain(&[], axis);
    let level = |log: &LogCost<'_>| {
        let residual = log.residual(&log.simulate(&chain, axis), axis);
        rms(residual.get(log.known()).unwrap_or_default()) / log.sheet_sigma[axis]
    };
    cost.logs.iter().map(level).fold(0.0, f64::max)
}
