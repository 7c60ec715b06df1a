//! The step to which commands are rounded, found by a search of its own.
//!
//! Rounding to a step that is not the true one leaves an error that is unrelated to the true rounding error. So χ² falls only
//! where both agree over the whole range of velocities: where the number of steps in the largest velocity is right to a small
//! fraction of one. The grid is uniform in that number, and axes without any error do not count.

use super::cost::{AxisCost, Cost, LogCost, Term};
use super::refine::bottom;
use softdock_physics::model::stage::Stage;
use softdock_statistics::rms;

/// Most steps in the largest velocity that are tried; finer rounding is a detail of any error.
const MOST: f64 = 40.0;
/// Fewest steps in the largest velocity: with half a step nothing moves.
const FEWEST: f64 = 0.5;
/// Distance of two values of the grid, in steps. Half of the error in the number of steps is the share of commands that are
/// rounded to the wrong side. Each of these costs the square of a whole step, where no rounding at all costs a twelfth of
/// that. So χ² falls only within a sixth of a step.
const APART: f64 = 0.1;
/// The same as a share of the number of steps: a command that stays close to where two steps meet is rounded to the wrong side
/// for long.
const APART_BY_RATIO: f64 = 0.008;
/// Valleys of the grid that are refined.
const VALLEYS: usize = 4;
/// Fewest different commands on an axis: on a few, a gain or an offset does the same as a step. Set by hand.
const COMMANDS: usize = 10;
/// Ratio of the error to the data sheet's noise above which there is something to explain.
const VISIBLE: f64 = 1.03;

/// The step that explains the axes of one kind best. `None` where no axis has an error, or the commands have too few values.
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
            // Once χ² exceeds that without rounding, its exact value does not matter.
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
            .all(|v| (v - steps).abs() > 2.5 * resolution(steps));
        if is_new && valleys.len() < VALLEYS {
            valleys.push(steps);
        }
    }
    let refined = valleys.into_iter();
    let refined =
        refined.map(|steps| bottom(steps - resolution(steps), steps + resolution(steps), of));
    let best = refined.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(fastest / best.0)
}

fn resolution(steps: f64) -> f64 {
    APART.min(APART_BY_RATIO * steps)
}

/// Numbers of steps in the largest velocity, on the grid.
fn places() -> impl Iterator<Item = f64> {
    std::iter::successors(Some(FEWEST), |steps| Some(steps + resolution(*steps)))
        .take_while(|steps| *steps < MOST)
}

/// Rms error of an axis with the nominal actuator over the data sheet's noise, of the log where it is largest.
fn level(cost: &Cost<'_>, axis: usize) -> f64 {
    let chain = cost.chain(&[], axis);
    let level = |log: &LogCost<'_>| {
        let residual = log.residual(&log.simulate(&chain, axis), axis);
        rms(residual.get(log.known_cycles()).unwrap_or_default()) / log.sheet_sigma[axis]
    };
    cost.logs.iter().map(level).fold(0.0, f64::max)
}
