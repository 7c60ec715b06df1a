//! The dead zone of a command, with the gains of what lies beyond it.
//!
//! Who has to guess the scale of a command takes the slope through zero. Behind a dead zone the true one is several times as
//! steep, so that neither explains anything without the other. The two sides of the zone act at different times: for each
//! edge the motion of its side is simulated with gain 1, and the gains of each pair of edges follow by least squares.

use super::cost::{Cost, Term};
use rayon::prelude::*;
use softdock_physics::model::stage::Stage;
use softdock_statistics::dot;

/// Edges of the zone that are tried, in the largest velocity that is sent. One beyond zero is that of an axis which creeps
/// without a command.
const EDGES: [f64; 14] = [
    -0.2, -0.1, -0.05, 0.0, 0.02, 0.05, 0.1, 0.16, 0.24, 0.34, 0.46, 0.58, 0.7, 0.82,
];

/// The best zone on a grid for some axes beside terms, with its gain and its gain by direction if all axes that move are of
/// one kind; a scale in m/s that is wrong for three of six axes is no guess.
pub(super) fn best_zone(axes: &[bool; 6], cost: &Cost<'_>, beside: &[Term]) -> Option<Vec<Term>> {
    let fastest = cost.scale(axes).sent_velocity;
    if fastest <= 0.0 {
        return None;
    }
    let guessed = *axes == cost.active;
    let measured = measured(axes, cost);
    let side = |sign: f64| -> Vec<Vec<f64>> {
        let edges = EDGES.par_iter().map(|edge| sign * edge * fastest);
        edges
            .map(|edge| one_side((sign, edge), axes, cost, (beside, &measured)))
            .collect()
    };
    let (forth, back) = (side(1.0), side(-1.0));
    let [with_forth, with_back] = [&forth, &back].map(|side| Projections::new(side, &measured));
    let mut best: Option<(f64, Vec<Term>)> = None;
    for (i, upper) in EDGES.iter().enumerate() {
        for (k, lower) in EDGES
            .iter()
            .enumerate()
            .filter(|(_, lower)| upper + **lower > 0.0)
        {
            let both = dot(&forth[i], &back[k]);
            let gains = match guessed {
                true => gains(with_forth.at(i), with_back.at(k), both),
                false => Some([1.0; 2]),
            };
            let Some([up, down]) = gains else {
                continue;
            };
            let (y_forth, forth_2) = with_forth.at(i);
            let (y_back, back_2) = with_back.at(k);
            let less = up * (2.0 * y_forth - up * forth_2) + down * (2.0 * y_back - down * back_2)
                - 2.0 * up * down * both;
            if best.as_ref().is_none_or(|(most, _)| less > *most) {
                let zone = [-lower * fastest, upper * fastest];
                best = Some((less, terms(zone, guessed.then_some([up, down]), axes)));
            }
        }
    }
    best.map(|(_, terms)| terms)
}

/// The zone, with its gain and its gain by direction where they are fitted.
fn terms([low, high]: [f64; 2], gains: Option<[f64; 2]>, axes: &[bool; 6]) -> Vec<Term> {
    let of = |stage, values| Term {
        stage,
        values,
        axes: *axes,
    };
    let zone = of(Stage::DeadZone, vec![high - low, 0.5 * (low + high)]);
    let gains = gains.map(|[up, down]| {
        let mean = 0.5 * (up + down);
        [
            of(Stage::Gain, vec![mean - 1.0]),
            of(Stage::Direction, vec![0.5 * (up - down) / mean]),
        ]
    });
    std::iter::once(zone)
        .chain(gains.into_iter().flatten())
        .collect()
}

/// What is measured of some axes, in σ, one after the other.
fn measured(axes: &[bool; 6], cost: &Cost<'_>) -> Vec<f64> {
    whitened(axes, cost, &|log, _| {
        vec![0.0; cost.logs[log].cycle_count()]
    })
}

/// The motion of one side beyond an edge with gain 1, in σ, like what is [`measured`].
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
    // Twice one side and none of the other, halved.
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

/// Residuals of a prediction of each log and axis, in σ.
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

/// Products of each of several series with what is measured, and with themselves.
struct Projections(Vec<(f64, f64)>);

impl Projections {
    fn new(series: &[Vec<f64>], measured: &[f64]) -> Self {
        let both = |series: &Vec<f64>| (dot(series, measured), dot(series, series));
        Self(series.iter().map(both).collect())
    }

    fn at(&self, n: usize) -> (f64, f64) {
        self.0[n]
    }
}

/// Gains of two series by least squares; none where one is not positive or nothing moves.
fn gains(forth: (f64, f64), back: (f64, f64), both: f64) -> Option<[f64; 2]> {
    let ((y_forth, forth), (y_back, back)) = (forth, back);
    let determinant = forth * back - both * both;
    let gains = [
        (y_forth * back - y_back * both) / determinant,
        (y_back * forth - y_forth * both) / determinant,
    ];
    gains.iter().all(|gain| *gain > 0.0).then_some(gains)
}
