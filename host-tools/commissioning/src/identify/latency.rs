//! Age of the reported pose, from the force that accelerates the tool.
//!
//! A recording of poses shows the robot's delay and the age of its poses only as a sum. The inertial force of the tool reaches
//! the sensor without that age: the force of a cycle belongs to the acceleration that the pose shows some cycles later.

use super::outcome::{AxisActuator, Estimate};
use super::track::Track;
use nalgebra::{DMatrix, DVector};
use softdock_actuator::{Reading, Timing, simulate};
use softdock_physics::model::log::Log;
use softdock_statistics::{correlated_cycles, f_p};

/// Shift of the delay, s, with which each age is tried in both directions. A robot moves on the edges of its cycles: with the
/// longer delay a jump of the velocity at an edge belongs to the cycle behind it, even if the delay was found a little too short.
/// With the shorter delay it is seen a cycle earlier; ages that this allows count as possible.
const EDGE_S: f64 = 3e-4;
/// Ages that are tried, cycles.
const OLDEST: usize = 8;
/// Cycles with a new sample of the sensor that are needed.
const FEWEST: usize = 200;
/// p-value below which the force follows the acceleration.
const IMPROBABLE: f64 = 1e-6;
/// Difference of 2 log L by which an age is refuted (99.9 % for one parameter).
const REFUTED: f64 = 10.8;

/// Age of the reported pose in cycles, with the range of possible ages; None if no force shows it.
pub(super) fn feedback(log: &Log, track: &Track, found: &AxisActuator) -> Option<Estimate> {
    if track.axis.index() >= 3 {
        return None;
    }
    // The same cycles for every age, so that fits can be compared.
    let last = track.sent.len().saturating_sub(OLDEST + 1);
    let felt = |n: &usize| {
        log.fresh.get(*n).copied().unwrap_or(false) && (0..3).all(|k| log.wrench[k][*n].is_finite())
    };
    let cycles: Vec<usize> = (track.first.max(1)..last).filter(felt).collect();
    if cycles.len() < FEWEST {
        return None;
    }
    let resting = Fit::new(log, &cycles, None);
    let by_age = |edge_s: f64| -> Vec<Fit> {
        let velocity = velocity(track, found, edge_s);
        let of_age = |age: usize| {
            let change = |n: usize| (velocity[n + age] - velocity[n + age - 1]) / track.cycle_s;
            Fit::new(log, &cycles, Some(&change))
        };
        (0..=OLDEST).map(of_age).collect()
    };
    let fits = by_age(EDGE_S);
    let earlier = by_age(-EDGE_S);
    let (age, best) = fits
        .iter()
        .enumerate()
        .min_by(|a, b| a.1.squares.total_cmp(&b.1.squares))?;
    let independent = 3.0 * cycles.len() as f64 / best.correlated;
    let gain = (resting.squares - best.squares) / 3.0;
    let noise = best.squares / independent;
    if noise > 0.0 && f_p(gain / noise, 3.0, independent) > IMPROBABLE {
        return None;
    }
    let possible = |fit: &Fit| {
        independent * (fit.squares / best.squares.max(f64::MIN_POSITIVE)).ln() < REFUTED
    };
    let ages: Vec<usize> = (0..=OLDEST)
        .filter(|age| possible(&fits[*age]) || possible(&earlier[*age]))
        .collect();
    Some(Estimate {
        value: age as f64,
        low: ages.first().copied().unwrap_or(age) as f64,
        // If the oldest age that is tried is possible, there is no upper bound.
        high: Some(ages.last().copied().unwrap_or(age))
            .filter(|oldest| *oldest < OLDEST)
            .map(|oldest| oldest as f64),
    })
}

/// Velocity at each instant of a cycle, with the delay longer by `edge_s`.
fn velocity(track: &Track, found: &AxisActuator, edge_s: f64) -> Vec<f64> {
    let mut chain = found.evidence.chain;
    chain.delay_s = (chain.delay_s + edge_s).max(0.0);
    let timing = Timing::uniform(track.cycle_s);
    simulate(&chain, &track.sent, &timing, Reading::AtEnd)
}

/// Regression of the three forces on a constant, a drift, and, if it is given, the acceleration.
struct Fit {
    squares: f64,
    correlated: f64,
}

impl Fit {
    fn new(log: &Log, cycles: &[usize], acceleration: Option<&dyn Fn(usize) -> f64>) -> Self {
        let count = 2 + usize::from(acceleration.is_some());
        let middle = 0.5 * (cycles[0] + cycles[cycles.len() - 1]) as f64;
        let rows = DMatrix::from_fn(cycles.len(), count, |row, column| match column {
            0 => 1.0,
            1 => (cycles[row] as f64 - middle) / middle.max(1.0),
            _ => acceleration.map_or(0.0, |a| a(cycles[row])),
        });
        let normal = (rows.transpose() * &rows).pseudo_inverse(1e-14);
        let mut fit = Self {
            squares: 0.0,
            correlated: 1.0,
        };
        for axis in 0..3 {
            let force = DVector::from_fn(cycles.len(), |row, _| log.wrench[axis][cycles[row]]);
            let left = match &normal {
                Ok(normal) => &force - &rows * (normal * (rows.transpose() * &force)),
                Err(_) => force,
            };
            fit.squares += left.norm_squared();
            fit.correlated = fit.correlated.max(correlated_cycles(left.as_slice()));
        }
        fit
    }
}
