//! The true duration of every cycle, recovered from the motion.
//!
//! Gauss-Newton on the durations: measured executed velocities and displacements between poses are compared with their simulation
//! with these durations, with the spread of the jitter as prior. A duration acts on the velocities of a few cycles only, so
//! several columns of the Jacobian are found together: one perturbed simulation perturbs all cycles that are far enough apart.

use crate::effects::body::clock_jitter::Scatter;
use crate::model::Model;
use crate::model::log::Log;
use nalgebra::Vector3;
use softdock_actuator::{Reading, Timing, simulate};

/// Iterations of Gauss and Newton; the problem is nearly linear.
const ITERATIONS: usize = 4;
/// Iterations of the conjugate gradients inside.
const SOLVER: usize = 30;
/// Perturbation for the derivatives, s.
const STEP_S: f64 = 1e-6;

/// Residuals and their derivatives, row by row.
#[derive(Default)]
struct Linear {
    residual: Vec<f64>,
    /// (column, derivative) of each row.
    rows: Vec<Vec<(usize, f64)>>,
}

impl Linear {
    fn push(&mut self, residual: f64, row: Vec<(usize, f64)>) {
        self.residual.push(residual);
        self.rows.push(row);
    }
}

/// Velocities of an axis by the model, m/s or rad/s.
struct Simulated {
    /// With the durations as they are.
    base: Vec<f64>,
    /// With every `reach`-th duration, counted from the phase, longer by [`STEP_S`]; one series per phase.
    perturbed: Vec<Vec<f64>>,
}

impl Simulated {
    fn new(model: &Model, log: &Log, axis: usize, intervals: &[f64], reach: usize) -> Self {
        let chain = model.chain(axis);
        let simulated = |intervals: &[f64]| {
            let timing = Timing {
                cycle_s: log.cycle_s,
                intervals_s: intervals,
            };
            let mut velocity = simulate(&chain, &log.sent[axis], &timing, log.reading);
            timing.as_recorded(&mut velocity, log.reading);
            log.as_imported(velocity)
        };
        let perturbed = |phase: usize| {
            let mut shifted = intervals.to_vec();
            let apart = shifted.iter_mut().skip(phase).step_by(reach);
            apart.for_each(|i| *i += STEP_S);
            simulated(&shifted)
        };
        Self {
            base: simulated(intervals),
            perturbed: (0..reach).map(perturbed).collect(),
        }
    }

    /// Derivatives of the velocity of a cycle, in units of its noise, with respect to the durations that act on it: (cycle, per
    /// s).
    fn slopes(&self, n: usize, sigma: f64) -> Vec<(usize, f64)> {
        let reach = self.perturbed.len();
        let slope = |k: usize| (self.perturbed[k % reach][n] - self.base[n]) / STEP_S / sigma;
        ((n + 1).saturating_sub(reach)..=n)
            .map(|k| (k, slope(k)))
            .filter(|(_, slope)| slope.abs() > 1e-9)
            .collect()
    }
}

/// Durations of all cycles, s; entry n belongs to the cycle that ends with cycle n.
pub fn recover(model: &Model, log: &Log, jitter: &Scatter) -> Vec<f64> {
    let mut intervals = vec![log.cycle_s; log.cycle_count()];
    let chain = model.chain(0);
    let reach = ((chain.delay_s + 5.0 * chain.lag_s) / log.cycle_s) as usize + 2;
    let smallest = 0.05 * log.cycle_s;
    let spread_s = jitter.duration_s();
    for _ in 0..ITERATIONS {
        let linear = linearise(model, log, &intervals, reach);
        let deviation: Vec<f64> = intervals.iter().map(|i| i - log.cycle_s).collect();
        let change = solve(&linear, &deviation, spread_s);
        for (interval, change) in intervals.iter_mut().zip(change) {
            *interval = (*interval + change).max(smallest);
        }
    }
    intervals
}

fn linearise(model: &Model, log: &Log, intervals: &[f64], reach: usize) -> Linear {
    let mut linear = Linear::default();
    for axis in model.rig.active_axes.iter().map(|a| a.index()) {
        let sigma = log.velocity_sigma[axis];
        let simulated = Simulated::new(model, log, axis, intervals, reach);
        let base = &simulated.base;
        for n in 1..log.cycle_count() {
            let residual = (log.executed[axis][n] - base[n]) / sigma;
            linear.push(residual, simulated.slopes(n, sigma));
            // A velocity that is a difference of poses carries the same information as the poses.
            if axis < 3 && log.reading == Reading::AtEnd {
                let (displacement, _) = increments(log, n);
                let velocity = 0.5 * (base[n] + base[n - 1]);
                let sigma = std::f64::consts::SQRT_2 * model.noise.position_m;
                let residual = (displacement[axis] - velocity * intervals[n]) / sigma;
                linear.push(residual, vec![(n, velocity / sigma)]);
            }
        }
    }
    linear
}

/// Change of the durations: conjugate gradients on `(JᵀJ + 1/s²) x = Jᵀr − d/s²`.
fn solve(linear: &Linear, deviation: &[f64], jitter_s: f64) -> Vec<f64> {
    let prior = 1.0 / (jitter_s * jitter_s).max(1e-18);
    let apply = |x: &[f64]| -> Vec<f64> {
        let mut out: Vec<f64> = x.iter().map(|x| prior * x).collect();
        for row in &linear.rows {
            let along: f64 = row.iter().map(|(k, slope)| slope * x[*k]).sum();
            row.iter().for_each(|(k, slope)| out[*k] += slope * along);
        }
        out
    };
    let mut left: Vec<f64> = deviation.iter().map(|d| -prior * d).collect();
    for (row, r) in linear.rows.iter().zip(&linear.residual) {
        row.iter().for_each(|(k, slope)| left[*k] += slope * r);
    }
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut x = vec![0.0; deviation.len()];
    let mut direction = left.clone();
    let mut norm = dot(&left, &left);
    let enough = 1e-12 * norm;
    for _ in 0..SOLVER {
        if norm <= enough {
            break;
        }
        let image = apply(&direction);
        let step = norm / dot(&direction, &image);
        x.iter_mut()
            .zip(&direction)
            .for_each(|(x, d)| *x += step * d);
        left.iter_mut()
            .zip(&image)
            .for_each(|(l, i)| *l -= step * i);
        let next = dot(&left, &left);
        let share = next / norm;
        direction
            .iter_mut()
            .zip(&left)
            .for_each(|(d, l)| *d = l + share * *d);
        norm = next;
    }
    x
}

/// Displacement between two poses, and the mean of the velocities measured at them.
pub fn increments(log: &Log, n: usize) -> (Vector3<f64>, Vector3<f64>) {
    let velocity = |k: usize| Vector3::from_fn(|i, _| log.executed[i][k]);
    (
        log.position(n) - log.position(n - 1),
        (velocity(n) + velocity(n - 1)) * 0.5,
    )
}
