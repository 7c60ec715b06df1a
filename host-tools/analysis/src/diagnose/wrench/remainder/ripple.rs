//! A ripple: what is left of the reading and repeats along the axis, as the teeth of a gear, the poles of a motor or the
//! pitch of a screw make it.

use super::functions::Motion;
use crate::diagnose::structure::LINE;
use crate::diagnose::wrench::joint::Joint;
use crate::diagnose::wrench::tested::Tested;
use nalgebra::{DMatrix, DVector};
use softdock_physics::model::Axis;
use softdock_physics::optimise::brent;
use softdock_report::number;
use softdock_statistics::{median, periodogram};
use std::f64::consts::TAU;

/// Periods in the travel from which something repeats: with fewer, a smooth function of the position looks so.
const FEWEST_PERIODS: usize = 3;
/// Most of them that are looked for.
const MOST_PERIODS: usize = 4096;
/// Rows in a period at the usual speed, at the least.
const ROWS: f64 = 4.0;
/// Parts of the shortest period whose rows are summed up.
const PARTS: usize = 8;
/// How much finer than the travel resolves them the periods are looked for.
const FINER: usize = 2;
/// Lines to either side out of which one has to stand.
const BESIDE: usize = 16;
/// How exactly a period is looked for, in the distance of two lines.
const PRECISE: f64 = 1e-3;
/// Most lines of one axis that are looked at: the teeth, their fractions and multiples.
const MOST: usize = 4;
/// Share of what is left from which a ripple is told.
const SHARE: f64 = 0.05;

/// What repeats along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ripple {
    /// The axis.
    pub axis: Axis,
    /// After which it repeats, m or rad.
    pub period: f64,
    /// How often it does so over the travel.
    pub periods: f64,
    /// In all logs together, N or N·m.
    pub amplitude: f64,
    /// Share in the square of what is left of the axis, in the log where it is least.
    pub share: f64,
}

impl Ripple {
    /// In words.
    pub(crate) fn words(&self) -> String {
        let number = |value| number::significant(value, 3);
        let (period, amplitude) = (number(self.period), number(self.amplitude));
        let share = 100.0 * self.share;
        match self.axis.is_rotation() {
            true => format!(
                "{share:.0} % repeats every {period} rad ({} in a turn) with {amplitude} N·m",
                number(TAU / self.period)
            ),
            false => format!("{share:.0} % repeats every {period} m with {amplitude} N"),
        }
    }

    /// How an own hypothesis says so.
    pub(crate) fn hypothesis(&self) -> String {
        let (force, length) = match self.axis.is_rotation() {
            true => ("n_m", "rad"),
            false => ("n", "m"),
        };
        let angle = format!("2 * PI * position / pitch_{length}");
        let within = 0.5 * self.period / self.periods;
        let [low, high] = [self.period - within, self.period + within];
        let [low, high] = [low, high].map(|end| number::significant(end, 5));
        format!(
            "formula = \"sine_{force} * sin({angle}) + cosine_{force} * cos({angle})\" on acts_on = \"guide\", with a pitch from {low} to {high} {length}"
        )
    }
}

/// What one log leaves on an axis.
#[derive(Clone)]
struct Rest {
    position: Vec<f64>,
    values: Vec<f64>,
}

/// The ripples in what effects leave on some axes, the largest of each axis first.
pub(crate) fn ripples(joint: &Joint, accepted: Option<&Tested>, axes: &[Axis]) -> Vec<Ripple> {
    let rests = joint.rests(accepted, &[]);
    let of_axis = |axis: &Axis| {
        let each = joint.logs.iter().zip(&rests).map(|(log, rest)| {
            let position = Motion::new(&log.scene, axis.index()).position;
            let rows = position.into_iter().zip(&rest.raw.0[axis.index()]);
            let rows = rows.zip(&log.fresh).filter(|(_, fresh)| **fresh);
            let (position, values) = rows.map(|((x, r), _)| (x, *r)).unzip();
            Rest { position, values }
        });
        of_rests(*axis, each.collect())
    };
    axes.iter().flat_map(of_axis).collect()
}

fn of_rests(axis: Axis, mut rests: Vec<Rest>) -> Vec<Ripple> {
    let before: Vec<f64> = rests.iter().map(power).collect();
    let mut all = Vec::new();
    for _ in 0..MOST {
        let Some(line) = strongest_line(&rests) else {
            break;
        };
        let period = refined(&rests, line);
        let mut least = f64::INFINITY;
        let (mut square, mut count) = (0.0, 0.0);
        for (rest, before) in rests.iter_mut().zip(&before) {
            let was = power(rest);
            square += take(rest, period) * rest.values.len() as f64;
            count += rest.values.len() as f64;
            least = least.min((was - power(rest)) / before);
        }
        all.push(Ripple {
            axis,
            period,
            periods: line.0 / (FINER as f64 * line.1),
            amplitude: (square / count).sqrt(),
            share: least,
        });
    }
    all.retain(|ripple| ripple.share >= SHARE);
    all.sort_by(|a, b| b.share.total_cmp(&a.share));
    all
}

/// The period with which least is left, near a line.
fn refined(rests: &[Rest], (line, within): (f64, f64)) -> f64 {
    let left = |rate: f64| -> f64 {
        let of = |rest: &Rest| {
            let mut rest = rest.clone();
            take(&mut rest, rate.recip());
            power(&rest)
        };
        rests.iter().map(of).sum()
    };
    let (rate, _) = brent((line - within, line, line + within), PRECISE * within, left);
    rate.recip()
}

/// Sum of squares.
fn power(rest: &Rest) -> f64 {
    rest.values.iter().map(|r| r * r).sum()
}

/// Takes what repeats after a period out of what is left, by least squares beside a constant; the square of its amplitude.
fn take(rest: &mut Rest, period: f64) -> f64 {
    let functions = DMatrix::from_fn(rest.values.len(), 3, |n, k| {
        let angle = TAU * rest.position[n] / period;
        [1.0, angle.sin(), angle.cos()][k]
    });
    let values = DVector::from_column_slice(&rest.values);
    let normal = functions.tr_mul(&functions).cholesky();
    let Some(amplitudes) = normal.map(|normal| normal.solve(&functions.tr_mul(&values))) else {
        return 0.0;
    };
    for (n, value) in rest.values.iter_mut().enumerate() {
        *value -= amplitudes[1] * functions[(n, 1)] + amplitudes[2] * functions[(n, 2)];
    }
    amplitudes[1].hypot(amplitudes[2]).powi(2)
}

/// The strongest line over the position that stands out in each of the logs: periods per m or rad, and how exactly.
fn strongest_line(rests: &[Rest]) -> Option<(f64, f64)> {
    let all = || rests.iter().flat_map(|rest| &rest.position).copied();
    let low = all().reduce(f64::min)?;
    let travel = all().reduce(f64::max)? - low;
    let steps = rests.iter().flat_map(|rest| rest.position.array_windows());
    let mut steps: Vec<f64> = steps.map(|[a, b]| (b - a).abs()).collect();
    let usual = median(&mut steps)?;
    if travel <= 0.0 || usual <= 0.0 {
        return None;
    }
    let periods = ((travel / (ROWS * usual)) as usize).min(MOST_PERIODS);
    if periods < FEWEST_PERIODS {
        return None;
    }
    let parts = PARTS * periods;
    let over_beside = |rest: &Rest| -> Vec<f64> {
        let mut sums = vec![0.0; FINER * parts];
        for (x, r) in rest.position.iter().zip(&rest.values) {
            let part = ((x - low) / travel * parts as f64) as usize;
            sums[part.min(parts - 1)] += r;
        }
        let power = periodogram(&sums);
        let beside = |k: usize| {
            let around = k.saturating_sub(BESIDE)..(k + BESIDE + 1).min(power.len());
            median(&mut power[around].to_vec()).unwrap_or(0.0) / std::f64::consts::LN_2
        };
        (0..power.len().min(FINER * periods))
            .map(|k| power[k] / beside(k).max(f64::MIN_POSITIVE))
            .collect()
    };
    let each: Vec<Vec<f64>> = rests.iter().map(over_beside).collect();
    let in_all = |k: usize| {
        let of_log = |lines: &Vec<f64>| lines[k];
        each.iter().map(of_log).fold(f64::INFINITY, f64::min)
    };
    let lines = FINER * FEWEST_PERIODS - 1..FINER * periods;
    let strongest = lines
        .map(|k| (k, in_all(k)))
        .max_by(|a, b| a.1.total_cmp(&b.1));
    let (k, _) = strongest.filter(|(_, over_beside)| *over_beside > LINE)?;
    let between = (FINER as f64 * travel).recip();
    Some(((k + 1) as f64 * between, between))
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_statistics::RandomStream;

    /// Swings of 0.3 m, with noise of 1 and what `force` says of time and position beside it.
    fn logs(force: impl Fn(f64, f64) -> f64) -> Vec<Rest> {
        let log = |seed: u64| {
            let mut random = RandomStream::new(seed, 0);
            let times = (0..5000).map(|n| 0.004 * n as f64);
            let rows = times.map(|t| {
                let x = 0.2 * (0.7 * t + seed as f64).sin() + 0.1 * (1.9 * t).sin();
                (x, random.normal() + force(t, x))
            });
            let (position, values) = rows.unzip();
            Rest { position, values }
        };
        [1, 2].map(log).into()
    }

    #[test]
    fn a_pitch_is_found_with_its_amplitude() {
        const PITCH: f64 = 0.0123;
        let found = of_rests(Axis::X, logs(|_, x| 0.9 * (TAU * x / PITCH + 0.4).sin()));
        assert_eq!(found.len(), 1, "{found:?}");
        assert!((found[0].period / PITCH - 1.0).abs() < 1e-3, "{found:?}");
        assert!((found[0].amplitude / 0.9 - 1.0).abs() < 0.05, "{found:?}");
        // 0.9² / 2 of 1 + 0.9² / 2.
        assert!((found[0].share - 0.29).abs() < 0.03, "{found:?}");
    }

    #[test]
    fn what_follows_time_or_a_smooth_law_is_no_ripple() {
        let hum = |t: f64, _: f64| 2.0 * (50.0 * t).sin();
        let spring = |_: f64, x: f64| 50.0 * x + 300.0 * x.powi(3);
        let dry = |t: f64, _: f64| 3.0 * (0.14 * (0.7 * t).cos() + 0.19 * (1.9 * t).cos()).signum();
        let laws: [&dyn Fn(f64, f64) -> f64; 4] = [&|_, _| 0.0, &hum, &spring, &dry];
        for (k, law) in laws.into_iter().enumerate() {
            let found = of_rests(Axis::X, logs(law));
            assert_eq!(found, [], "{k}");
        }
    }

    #[test]
    fn of_what_stands_still_nothing_is_said() {
        let rest = || Rest {
            position: vec![0.1; 1000],
            values: (0..1000).map(|n| f64::from(n).sin()).collect(),
        };
        assert_eq!(of_rests(Axis::X, vec![rest(), rest()]), []);
    }
}
