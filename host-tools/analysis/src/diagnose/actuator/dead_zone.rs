//! The dead zone of a command, and the gains of what lies beyond it.
//!
//! A user who has to guess the scale of a command takes its slope through zero. Behind a dead zone the true slope is several
//! times as steep, so that neither zone nor gain explains anything without the other. The two sides of the zone act at different
//! times. So for each edge the motion of its side is simulated with gain 1, and the gains for each pair of edges follow by least
//! squares.

use super::cost::{Cost, Term};
use super::tried::{Scale, specs};
use rayon::prelude::*;
use softdock_physics::model::stage::Stage;
use softdock_statistics::dot;

/// Edges of the zone that are tried, as shares of the largest velocity that is sent. A negative edge lies beyond zero: the axis
/// creeps without a command.
const EDGES: [f64; 14] = [
    -0.2, -0.1, -0.05, 0.0, 0.02, 0.05, 0.1, 0.16, 0.24, 0.34, 0.46, 0.58, 0.7, 0.82,
];

/// The best zone on a grid for some axes beside given terms. Its gain and its gain by direction come with it, unless they are
/// excluded or other axes move as well: a scale in m/s that is wrong for three of six axes is no guess. `None` if nothing is
/// sent, or no gain is positive.
pub(super) fn best_zone(
    axes: &[bool; 6],
    cost: &Cost<'_>,
    beside: &[Term],
    excluded: &dyn Fn(&str) -> bool,
) -> Option<Vec<Term>> {
    let fastest = cost.scale(axes).sent_velocity;
    if fastest <= 0.0 {
        return None;
    }
    let may = |stage: Stage| *axes == cost.active && !excluded(stage.id());
    let [gain, direction] = [Stage::Gain, Stage::Direction].map(may);
    let measured = measured(axes, cost);
    let side = |sign: f64| -> Vec<Vec<f64>> {
        let edges = EDGES.par_iter().map(|edge| sign * edge * fastest);
        edges
            .map(|edge| one_side((sign, edge), axes, cost, (beside, &measured)))
            .collect()
    };
    let (forth, back) = (side(1.0), side(-1.0));
    let of_each = |side: &[Vec<f64>]| -> Vec<Side> {
        let of = |series: &Vec<f64>| Side::of(series, &measured);
        side.iter().map(of).collect()
    };
    let sides = [of_each(&forth), of_each(&back)];
    let mut best: Option<(f64, Vec<Term>)> = None;
    for (i, upper) in EDGES.iter().enumerate() {
        for (k, lower) in EDGES
            .iter()
            .enumerate()
            .filter(|(_, lower)| upper + **lower > 0.0)
        {
            let (up, down) = (sides[0][i], sides[1][k]);
            let both = dot(&forth[i], &back[k]);
            let gains = match (gain, direction) {
                (true, true) if up.squares > 0.0 && down.squares > 0.0 => {
                    separate_gains(up, down, both)
                }
                (true, _) => alike(up, down, both),
                (false, _) => Some([1.0; 2]),
            };
            let Some(gains) = gains else {
                continue;
            };
            let less = chi2_reduction(gains, [up, down], both);
            if best.as_ref().is_none_or(|(most, _)| less > *most) {
                let zone = [-lower * fastest, upper * fastest];
                best = Some((less, terms(zone, gains, [gain, direction], axes)));
            }
        }
    }
    best.map(|(_, terms)| terms)
}

/// The zone, with its gain and its gain by direction where these are allowed, limited to the ranges that a search tries.
fn terms(
    [low, high]: [f64; 2],
    [up, down]: [f64; 2],
    [gain, direction]: [bool; 2],
    axes: &[bool; 6],
) -> Vec<Term> {
    let mean = 0.5 * (up + down);
    let differs = direction && up != down;
    let of_gain = gain.then(|| within(Stage::Gain, mean - 1.0));
    let of_direction = differs.then(|| within(Stage::Direction, 0.5 * (up - down) / mean));
    let values = [
        (Stage::DeadZone, Some(vec![high - low, 0.5 * (low + high)])),
        (Stage::Gain, of_gain.map(|value| vec![value])),
        (Stage::Direction, of_direction.map(|value| vec![value])),
    ];
    let term = |(stage, values): (Stage, Option<Vec<f64>>)| {
        Some(Term {
            stage,
            values: values?,
            axes: *axes,
        })
    };
    values.into_iter().filter_map(term).collect()
}

/// Limits a value to the range that a search tries, for a stage whose parameters have no unit of the axes.
fn within(stage: Stage, value: f64) -> f64 {
    let tried = specs(stage, &Scale::of(std::iter::empty(), 1.0, false));
    tried
        .first()
        .map_or(value, |spec| value.clamp(spec.low, spec.high))
}

/// The measured velocities of some axes, in σ: all logs and axes one after the other.
fn measured(axes: &[bool; 6], cost: &Cost<'_>) -> Vec<f64> {
    whitened(axes, cost, &|log, _| {
        vec![0.0; cost.logs[log].cycle_count()]
    })
}

/// The motion of one side beyond an edge with gain 1, in σ, in the order of [`measured`].
fn one_side(
    (sign, edge): (f64, f64),
    axes: &[bool; 6],
    cost: &Cost<'_>,
    (beside, measured): (&[Term], &[f64]),
) -> Vec<f64> {
    let of = |stage, values| Term {
        stage,
        values,
        axes: *axes,
    };
    let zone = of(Stage::DeadZone, vec![0.0, edge]);
    // Direction by ±1 doubles one side and removes the other; a gain of one half restores the one.
    let one = [
        of(Stage::Direction, vec![sign]),
        of(Stage::Gain, vec![-0.5]),
    ];
    let terms = [beside, &[zone], &one].concat();
    let left = whitened(axes, cost, &|log, axis| {
        cost.logs[log].simulate(&cost.chain(&terms, axis), axis)
    });
    measured
        .iter()
        .zip(left)
        .map(|(m, left)| m - left)
        .collect()
}

/// Whitened residuals of a prediction, all logs and axes one after the other. `predicted` is called with log and axis.
fn whitened(
    axes: &[bool; 6],
    cost: &Cost<'_>,
    predicted: &dyn Fn(usize, usize) -> Vec<f64>,
) -> Vec<f64> {
    let mut all = Vec::new();
    for (number, log) in cost.logs.iter().enumerate() {
        for axis in (0..6).filter(|axis| axes[*axis]) {
            let residual = log.residual(&predicted(number, axis), axis);
            all.extend(residual.iter().map(|r| r / log.sigma[axis]));
        }
    }
    all
}

/// Inner products of the motion of one side, in σ.
#[derive(Clone, Copy)]
struct Side {
    /// With what is measured.
    measured: f64,
    /// With itself.
    squares: f64,
}

impl Side {
    fn of(series: &[f64], measured: &[f64]) -> Self {
        Self {
            measured: dot(series, measured),
            squares: dot(series, series),
        }
    }
}

/// By how much χ² falls with the given gains of two sides; `both` is the product of their motions.
fn chi2_reduction([up, down]: [f64; 2], [forth, back]: [Side; 2], both: f64) -> f64 {
    up * (2.0 * forth.measured - up * forth.squares)
        + down * (2.0 * back.measured - down * back.squares)
        - 2.0 * up * down * both
}

/// Gains of two sides by least squares; `None` if one of them is not positive.
fn separate_gains(forth: Side, back: Side, both: f64) -> Option<[f64; 2]> {
    let determinant = forth.squares * back.squares - both * both;
    let gains = [
        (forth.measured * back.squares - back.measured * both) / determinant,
        (back.measured * forth.squares - forth.measured * both) / determinant,
    ];
    gains.iter().all(|gain| *gain > 0.0).then_some(gains)
}

/// One gain for both sides by least squares; `None` if it is not positive or nothing moves.
fn alike(forth: Side, back: Side, both: f64) -> Option<[f64; 2]> {
    let squares = forth.squares + back.squares + 2.0 * both;
    let gain = (forth.measured + back.measured) / squares;
    (gain > 0.0).then_some([gain; 2])
}
