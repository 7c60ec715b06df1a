//! The clock of the log: whether its cycles last as long as the log says.
//!
//! Where velocity and pose are measured separately, the displacement between two poses is the velocity times the true duration of
//! the cycle. A duration with standard deviation s_t adds v² s_t² to the variance of `dp − v Ts`, and nothing where the rig
//! stands still. No other effect does that.

pub(crate) mod timed_logs;

use super::actuator::{Cost, LogCost, Term};
use softdock_actuator::Reading;
use softdock_physics::effects::body::clock_jitter::Scatter;
use softdock_physics::model::Model;
use softdock_physics::model::clock::increments;
use softdock_physics::model::log::Log;
use softdock_physics::optimise::{brent, lowest_valley};
use std::f64::consts::SQRT_2;

/// 2 Δ log L above which the clock jitters (quiet clocks stay below 10).
pub(super) const SIGNIFICANT: f64 = 40.0;
/// 2 Δ log L above which rate or offset of the clock are wrong.
const SIGNIFICANT_LINEAR: f64 = 40.0;

/// The unmodelled error of the clock.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ClockFinding {
    /// Scatter of the durations of cycles.
    pub jitter: Option<Jitter>,
    /// Relative error of all durations, and its standard deviation.
    pub rate: Option<(f64, f64)>,
    /// Offset of the pose, s, and its standard deviation.
    pub offset_s: Option<(f64, f64)>,
}

/// What one log says about its clock.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Clock {
    /// Standard deviation of the duration of a cycle, s.
    pub duration_s: f64,
    /// Standard deviation of that estimate, s.
    pub sigma_s: f64,
    /// Correlation of a duration with the one before: −1/2 where each instant scatters independently, 0 where each duration does.
    pub correlation: f64,
    /// 2 Δ log L of the jitter.
    pub jitter_gain: f64,
    /// Relative error of the duration of all cycles, with its standard deviation.
    pub rate: (f64, f64),
    /// By how much the pose is later than the velocity, s, with its standard deviation.
    pub offset_s: (f64, f64),
}

/// Scatter of the instants of the cycles, as the logs show it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Jitter {
    /// How they scatter.
    pub scatter: Scatter,
    /// Standard deviation of the estimate, s.
    pub sigma_s: f64,
    /// 2 Δ log L for it over all logs.
    pub gain: f64,
}

impl Clock {
    /// Whether the log tests the clock. It does not if its velocity is the difference of its poses.
    pub(crate) fn says_something(&self) -> bool {
        self.rate.1 > 0.0
    }

    /// Combines logs of one clock: rate and offset weighted by inverse variance, jitter with equal weights.
    pub(crate) fn common(all: &[Self]) -> Self {
        let said: Vec<&Self> = all.iter().filter(|clock| clock.says_something()).collect();
        let count = said.len().max(1) as f64;
        let squares: f64 = said.iter().map(|c| c.duration_s * c.duration_s).sum();
        let variance: f64 = said.iter().map(|c| c.sigma_s * c.sigma_s).sum();
        Self {
            duration_s: (squares / count).sqrt(),
            sigma_s: variance.sqrt() / count,
            correlation: said.iter().map(|c| c.correlation).sum::<f64>() / count,
            jitter_gain: said.iter().map(|c| c.jitter_gain).sum(),
            rate: weighed(said.iter().map(|c| c.rate)),
            offset_s: weighed(said.iter().map(|c| c.offset_s)),
        }
    }

    /// The scatter of the instants, with `gain` as evidence.
    pub(crate) fn jitter(&self, gain: f64) -> Jitter {
        let scatter = Scatter::of_durations(self.duration_s, self.correlation > -0.25);
        Jitter {
            scatter,
            sigma_s: self.sigma_s * scatter.jitter_s / self.duration_s.max(1e-12),
            gain,
        }
    }

    /// Whether all cycles are longer or shorter than stated, beyond a tolerance.
    pub(crate) fn has_rate_error(&self, tolerance: f64) -> bool {
        beyond(self.rate, tolerance)
    }

    /// Whether pose and velocity belong to different instants.
    pub(crate) fn has_offset(&self, tolerance_s: f64) -> bool {
        beyond(self.offset_s, tolerance_s)
    }
}

/// The mean of values with weights of inverse variance, and its standard deviation; 0 and 0 if there are none.
fn weighed(values: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    let known = values.filter(|(_, sigma)| *sigma > 0.0);
    let (sum, weight) = known.fold((0.0, 0.0), |(sum, weight), (value, sigma)| {
        let own = 1.0 / (sigma * sigma);
        (sum + own * value, weight + own)
    });
    match weight > 0.0 {
        true => (sum / weight, 1.0 / weight.sqrt()),
        false => (0.0, 0.0),
    }
}

fn beyond((value, sigma): (f64, f64), tolerance: f64) -> bool {
    let variance = sigma * sigma + tolerance * tolerance;
    variance > 0.0 && value * value / variance > SIGNIFICANT_LINEAR
}

/// Tests the clock of one log; all 0 if the log cannot test it.
pub(crate) fn test(model: &Model, log: &Log) -> Clock {
    if log.reading == Reading::Mean || log.cycle_count() < 50 || model.sensor.at_rest {
        return Clock::default();
    }
    let axes: Vec<usize> = model
        .rig
        .active_axes
        .iter()
        .map(|axis| axis.index())
        .filter(|axis| *axis < 3)
        .collect();
    let (errors, changes) = displacements(log, &axes);
    if errors.is_empty() {
        return Clock::default();
    }
    let sheet = SQRT_2 * model.noise.position_m;
    let found = jitter(&errors, sheet);
    let duration_s = found.value;
    let squares = errors.iter().map(|e| e.0 * e.0).sum::<f64>();
    let noise = (squares / errors.len() as f64).sqrt().max(sheet);
    Clock {
        duration_s,
        // Errors of differences of poses have a correlation of −1/2 from one to the next, which makes them worth less: Σ ρ² =
        // 1.5.
        sigma_s: 1.5_f64.sqrt() * found.sigma,
        correlation: correlation(&errors, axes.len(), duration_s),
        jitter_gain: found.gain,
        rate: slope(&errors, &|k| errors[k].1 * log.cycle_s, noise),
        // On any other machine the reading shows the offset.
        offset_s: match log.of_a_rig {
            true => slope(&errors, &|k| -changes[k], noise),
            false => (0.0, 0.0),
        },
    }
}

/// For each cycle and axis: error of the displacement, m, and velocity, m/s; and the change of the velocity, m/s.
fn displacements(log: &Log, axes: &[usize]) -> (Vec<(f64, f64)>, Vec<f64>) {
    let of_cycle = |n: usize| {
        let (way, velocity) = increments(log, n);
        axes.iter().map(move |&axis| {
            let error = way[axis] - velocity[axis] * log.cycle_s;
            let change = log.executed[axis][n] - log.executed[axis][n - 1];
            ((error, velocity[axis]), change)
        })
    };
    (1..log.cycle_count()).flat_map(of_cycle).unzip()
}

/// Slope of the errors over a regressor, and its standard deviation by the noise; 0 and 0 where the regressor is 0.
fn slope(errors: &[(f64, f64)], regressor: &dyn Fn(usize) -> f64, noise: f64) -> (f64, f64) {
    let (mut xx, mut xy) = (0.0, 0.0);
    for (k, (error, _)) in errors.iter().enumerate() {
        xx += regressor(k) * regressor(k);
        xy += regressor(k) * error;
    }
    match xx > 0.0 {
        true => (xy / xx, noise / xx.sqrt()),
        false => (0.0, 0.0),
    }
}

/// Correlation from cycle to cycle of the scatter that is proportional to velocity: of each error and the next one on its axis,
/// where the scatter exceeds the noise.
fn correlation(errors: &[(f64, f64)], axes: usize, duration_s: f64) -> f64 {
    let quiet = errors.iter().map(|(e, v)| e * e - (duration_s * v).powi(2));
    let noise = (quiet.sum::<f64>() / errors.len() as f64).max(0.0);
    let pairs = errors.iter().zip(&errors[axes..]);
    let loud = pairs.filter(|((_, v), (_, w))| (duration_s * duration_s * v * w).abs() > noise);
    let sums = loud.fold((0.0, 0.0), |(products, squares), ((e, v), (f, w))| {
        let scale = v * w;
        (
            products + e * f / scale,
            squares + 0.5 * (e * e / (v * v) + f * f / (w * w)),
        )
    });
    if sums.1 > 0.0 { sums.0 / sums.1 } else { 0.0 }
}

/// What scatters in proportion to the velocity in a log whose velocity is the difference of poses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PoseScatter {
    /// Standard deviation of the instants of the poses, s.
    pub scatter_s: f64,
    /// Standard deviation of that estimate, s.
    pub sigma_s: f64,
    /// 2 Δ log L of it.
    pub gain: f64,
}

impl PoseScatter {
    /// Whether it is no chance.
    pub(crate) fn is_significant(&self) -> bool {
        self.gain > SIGNIFICANT
    }
}

/// Looks for scattering instants of the poses in what actuator terms leave of a log. Second differences of the residual are third
/// differences of the poses, which smooth errors of a model do not reach. Of these every fourth is independent. Values far
/// outside are edges of the motion and no scatter.
pub(crate) fn scatter(cost: &Cost<'_>, log: &LogCost<'_>, terms: &[Term]) -> PoseScatter {
    /// Cycles between values that share no pose.
    const APART: usize = 4;
    /// Multiples of the standard deviation from which a value is an edge.
    const EDGE: f64 = 4.0;
    /// Ratio of the variance of a second difference of pose differences to that of one pose difference.
    const BY_DIFFERENCES: f64 = 10.0;
    if log.is_sampled() {
        return PoseScatter::default();
    }
    let mut values = Vec::new();
    for axis in (0..6).filter(|axis| cost.active[*axis]) {
        let predicted = log.simulate(&cost.chain(terms, axis), axis);
        let residual = log.residual(&predicted, axis);
        let sigma = log.sheet_sigma[axis];
        let scale = 1.0 / (sigma * BY_DIFFERENCES.sqrt());
        // The variance of a pose is half that of a difference of two.
        let per_second = SQRT_2 / (log.cycle_s() * sigma);
        let bends = residual.windows(3).zip(&predicted[1..]);
        let known = log.known_cycles();
        let bends = bends.take(known.end).skip(known.start).step_by(APART);
        values.extend(
            bends.map(|(w, velocity)| ((w[2] - 2.0 * w[1] + w[0]) * scale, velocity * per_second)),
        );
    }
    let deviation =
        |(scatter_s, noise): (f64, f64), velocity: f64| noise.hypot(scatter_s * velocity);
    let first_s = jitter(&values, 0.0).value;
    let squares = values
        .iter()
        .map(|(e, v)| e * e / (1.0 + (first_s * v).powi(2)));
    let noise = (squares.sum::<f64>() / values.len().max(1) as f64).sqrt();
    values.retain(|(e, v)| e.abs() < EDGE * deviation((first_s, noise), *v));
    let found = jitter(&values, 0.0);
    PoseScatter {
        scatter_s: found.value,
        sigma_s: found.sigma,
        gain: found.gain,
    }
}

/// A delay by which all velocities are later than the nominal actuator says (negative: earlier).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CommonDelay {
    /// The delay, s, and its standard deviation.
    pub late_s: (f64, f64),
    /// χ² over all logs with this delay.
    pub chi2: f64,
}

/// The best common delay of all axes. `None` if it explains too little, or the velocities were measured.
pub(crate) fn common_delay(logs: &Cost<'_>) -> Option<CommonDelay> {
    /// Longest delay that is tried, s.
    const LATEST_S: f64 = 0.06;
    /// Cells of the grid.
    const GRID: u32 = 24;
    if logs.is_sampled() {
        return None;
    }
    let low = -logs.delay_s();
    let step = (LATEST_S - low) / f64::from(GRID);
    let cost = |late_s: f64| logs.of_later(late_s);
    let (late_s, least) = lowest_valley((low, LATEST_S), GRID, 1e-4, cost);
    if cost(0.0) - least < SIGNIFICANT_LINEAR {
        return None;
    }
    let near = 0.01 * logs.cycle_s();
    let curvature = (cost(late_s + near) + cost(late_s - near) - 2.0 * least) / (near * near);
    let sigma = (2.0 / curvature.max(1e-12)).sqrt().min(step);
    Some(CommonDelay {
        late_s: (late_s, sigma),
        chi2: least,
    })
}

/// The rate error that would follow from a common factor of all velocities, and its standard deviation.
pub(crate) fn proportion(cost: &Cost<'_>) -> (f64, f64) {
    let (mut xx, mut xy) = (0.0, 0.0);
    for axis in (0..6).filter(|axis| cost.active[*axis]) {
        let chain = cost.chain(&[], axis);
        for log in &cost.logs {
            let predicted = log.simulate(&chain, axis);
            let weight = log.sigma[axis].powi(-2);
            let both = predicted.iter().zip(log.residual(&predicted, axis));
            for (p, r) in both
                .take(log.known_cycles().end)
                .skip(log.known_cycles().start)
            {
                xx += weight * p * p;
                xy += weight * p * r;
            }
        }
    }
    (xy / xx.max(1e-300), xx.max(1e-300).sqrt().recip())
}

/// Estimate of a scatter that is proportional to velocity.
#[derive(Clone, Copy, Debug, Default)]
struct Proportional {
    value: f64,
    sigma: f64,
    /// 2 Δ log L.
    gain: f64,
}

/// Likelihood ratio of `Var = s² + v² s_t²` against `s_t = 0`. The noise s is free in both, but at least that of the data sheet,
/// below which a measurement may be rounded or computed from the other one. The standard deviation of s_t follows from the Fisher
/// information of both parameters.
fn jitter(errors: &[(f64, f64)], sheet: f64) -> Proportional {
    let speed = errors.iter().fold(0.0_f64, |m, e| m.max(e.1.abs()));
    if speed <= 0.0 {
        return Proportional::default();
    }
    // −2 log L with the ratio of the two variances given; s is profiled out.
    let cost = |ratio: f64| {
        let mut logs = 0.0;
        let mut squares = 0.0;
        for (error, velocity) in errors {
            let weight = 1.0 + (ratio * velocity / speed).powi(2);
            logs += weight.ln();
            squares += error * error / weight;
        }
        let count = errors.len() as f64;
        let variance = (squares / count).max(sheet * sheet).max(1e-300);
        (count * variance.ln() + squares / variance + logs, variance)
    };
    let quiet = cost(0.0);
    let (at, _) = brent((-3.0, 0.0, 6.0), 1e-4, |x| cost(x.exp()).0);
    let best = cost(at.exp());
    let (noise, value) = (best.1.sqrt(), at.exp() / speed * best.1.sqrt());
    let information = |a: &dyn Fn(f64) -> f64, b: &dyn Fn(f64) -> f64| -> f64 {
        let of = errors.iter().map(|(_, v)| {
            let variance = noise * noise + (value * v).powi(2);
            2.0 * a(*v) * b(*v) / (variance * variance)
        });
        of.sum()
    };
    let (of_value, of_noise) = (|v: f64| value * v * v, |_: f64| noise);
    let own = information(&of_value, &of_value);
    let (other, both) = (
        information(&of_noise, &of_noise),
        information(&of_value, &of_noise),
    );
    let left = own - both * both / other.max(1e-300);
    Proportional {
        value,
        sigma: left.max(1e-300).sqrt().recip().min(value),
        gain: (quiet.0 - best.0).max(0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A log without a measured velocity says nothing; of two that have one, the more precise one counts more.
    #[test]
    fn what_several_logs_say_is_weighed_by_how_well_they_know_it() {
        let log = |rate, sigma| Clock {
            rate: (rate, sigma),
            offset_s: (2.0 * rate, 0.0),
            duration_s: 1e-4,
            sigma_s: 1e-5,
            ..Clock::default()
        };
        let both = Clock::common(&[log(1e-3, 1e-4), log(2e-3, 3e-4), Clock::default()]);
        // By weights of 9 to 1.
        assert!((both.rate.0 - 1.1e-3).abs() < 1e-12, "{both:?}");
        assert!(
            (both.rate.1 - 1e-4 * 0.9_f64.sqrt()).abs() < 1e-12,
            "{both:?}"
        );
        assert_eq!(both.offset_s, (0.0, 0.0));
        assert!((both.duration_s - 1e-4).abs() < 1e-15, "{both:?}");
        assert_eq!(Clock::common(&[Clock::default()]).rate, (0.0, 0.0));
    }

    #[test]
    fn a_variance_that_grows_with_speed_is_a_jitter() {
        // Signs that repeat every 4 are uncorrelated with the slow speed.
        let sign = |n: usize| [1.0, -1.0, -1.0, 1.0][n % 4];
        let speed = |n: usize| 0.02 * (n as f64 * 0.01).sin();
        let with = |jitter: f64| -> Vec<(f64, f64)> {
            (0..2000)
                .map(|n| {
                    let v = speed(n);
                    let noise = 7e-6_f64.hypot(jitter * v);
                    (sign(n) * noise, v)
                })
                .collect()
        };
        let found = jitter(&with(1e-3), 0.0);
        assert!(
            (found.value / 1e-3 - 1.0).abs() < 0.05 && found.gain > 100.0,
            "{found:?}"
        );
        // Without noise its relative standard deviation would be 1/√2n; at half of the speeds there is more noise.
        let share = found.sigma / found.value * (2.0 * 2000.0_f64).sqrt();
        assert!((1.0..2.0).contains(&share), "{share}");
        assert!(jitter(&with(0.0), 0.0).gain < 1.0);
        // Nothing is found where all of it is less than the noise of the data sheet.
        assert!(jitter(&with(1e-3), 1e-4).gain < 1.0);
    }
}
