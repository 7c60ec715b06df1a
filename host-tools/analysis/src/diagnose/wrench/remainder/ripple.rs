//! A ripple: a part of the residual that repeats along the axis, as the teeth of a gear, the poles of a motor or the pitch of a
//! screw cause it.

use super::functions::Motion;
use crate::diagnose::noise::structure::LINE;
use crate::diagnose::wrench::regression::joint::Joint;
use crate::diagnose::wrench::regression::prepared_log::PreparedLog;
use crate::diagnose::wrench::regression::tested::TestedHypothesis;
use nalgebra::{DMatrix, DVector};
use softdock_physics::model::Axis;
use softdock_physics::optimise::brent;
use softdock_report::number;
use softdock_statistics::{median, periodogram};
use std::f64::consts::TAU;

/// Fewest periods in the travel: with fewer, a smooth function of the position looks the same.
const FEWEST_PERIODS: usize = 3;
/// Most periods in the travel that are looked for.
const MOST_PERIODS: usize = 4096;
/// Fewest rows in a period at the median speed.
const ROWS: f64 = 4.0;
/// Bins in the shortest period; the rows in each bin are summed.
const PARTS: usize = 8;
/// How much finer the grid of lines is than the resolution that the travel gives.
const FINER: usize = 2;
/// Lines on either side with whose median a line is compared.
const BESIDE: usize = 16;
/// Precision of the period, as a share of the distance between two lines.
const PRECISE: f64 = 1e-3;
/// Most lines of one axis that are looked at: the teeth, their fractions and multiples.
const MOST: usize = 4;
/// Share of the residual's square from which a ripple is reported.
const SHARE: f64 = 0.05;

/// What repeats along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ripple {
    /// The axis.
    pub axis: Axis,
    /// Length after which it repeats, m or rad.
    pub period: f64,
    /// Number of periods in the travel of all logs.
    pub periods: f64,
    /// Amplitude over all logs that show it, N or N·m.
    pub amplitude: f64,
    /// Share in the square of the residual on this axis, in the log where that is smallest.
    pub share: f64,
    /// Whether the position is that along the guide, or about the bearing, with one origin in all logs, as `position` of an own
    /// hypothesis is.
    pub of_guide: bool,
}

impl Ripple {
    /// In words.
    pub(crate) fn words(&self) -> String {
        let number = |value| number::significant(value, 3);
        let (period, amplitude) = (number(self.period), number(self.amplitude));
        let share = 100.0 * self.share;
        match self.axis.is_rotation() {
            true => format!(
                "{share:.0} % or more on each log that travels {FEWEST_PERIODS} periods repeats every {period} rad ({} in a turn), with an amplitude of {amplitude} N·m",
                number(TAU / self.period)
            ),
            false => format!(
                "{share:.0} % or more on each log that travels {FEWEST_PERIODS} periods repeats every {period} m, with an amplitude of {amplitude} N"
            ),
        }
    }

    /// The own hypothesis that describes it, in words; `None` if its position is not that of the guide.
    pub(crate) fn hypothesis(&self) -> Option<String> {
        let (force, length) = match self.axis.is_rotation() {
            true => ("n_m", "rad"),
            false => ("n", "m"),
        };
        let angle = format!("2 * PI * position / pitch_{length}");
        let within = 0.5 * self.period / self.periods;
        let [low, high] = [self.period - within, self.period + within];
        let [low, high] = [low, high].map(|end| number::significant(end, 5));
        self.of_guide.then(|| format!(
            "formula = \"sine_{force} * sin({angle}) + cosine_{force} * cos({angle})\" on acts_on = \"guide\", with a pitch from {low} to {high} {length}"
        ))
    }
}

/// The residual of one log on an axis, its mean removed, with the positions.
#[derive(Clone)]
struct Rest {
    position: Vec<f64>,
    values: Vec<f64>,
    /// Difference between the highest and the lowest position.
    travel: f64,
}

impl Rest {
    fn new(rows: impl Iterator<Item = (f64, f64)>) -> Self {
        let finite = rows.filter(|(x, r)| x.is_finite() && r.is_finite());
        let (position, mut values): (Vec<f64>, Vec<f64>) = finite.unzip();
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        values.iter_mut().for_each(|value| *value -= mean);
        let low = position.iter().copied().fold(f64::INFINITY, f64::min);
        let high = position.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Self {
            position,
            values,
            travel: (high - low).max(0.0),
        }
    }

    /// Whether the log travels enough of these periods; `rate`: periods per m or rad.
    fn shows(&self, rate: f64) -> bool {
        self.travel * rate >= FEWEST_PERIODS as f64
    }

    /// Sum of squares.
    fn power(&self) -> f64 {
        self.values.iter().map(|r| r * r).sum()
    }

    /// Subtracts the sine and cosine of a period from the residual, fitted by least squares beside a constant. Returns the square
    /// of their amplitude.
    fn take(&mut self, period: f64) -> f64 {
        let waves = self.position.iter().map(|x| (TAU * x / period).sin_cos());
        let rows: Vec<[f64; 3]> = waves.map(|(sin, cos)| [1.0, sin, cos]).collect();
        let functions = DMatrix::from_fn(rows.len(), 3, |n, k| rows[n][k]);
        let values = DVector::from_column_slice(&self.values);
        let normal = functions.tr_mul(&functions).cholesky();
        let Some(amplitudes) = normal.map(|normal| normal.solve(&functions.tr_mul(&values))) else {
            return 0.0;
        };
        for (value, [_, sin, cos]) in self.values.iter_mut().zip(&rows) {
            *value -= amplitudes[1] * sin + amplitudes[2] * cos;
        }
        amplitudes[1].hypot(amplitudes[2]).powi(2)
    }

    /// Power of each line in the residual over position, relative to the lines beside it. 0 where the positions alone have a
    /// line: a motion in equal steps has one, and all that follows such a motion repeats with it.
    fn lines(&self, grid: &Grid) -> Vec<f64> {
        let of_values = grid.lines(
            self.position
                .iter()
                .copied()
                .zip(self.values.iter().copied()),
        );
        let of_positions = grid.lines(self.position.iter().map(|x| (*x, 1.0)));
        let both = of_values.into_iter().zip(of_positions);
        both.map(|(line, at)| if at > LINE { 0.0 } else { line })
            .collect()
    }
}

/// The ripples in what effects leave on some axes, the largest of each axis first.
pub(crate) fn ripples(
    joint: &Joint,
    accepted: Option<&TestedHypothesis>,
    axes: &[Axis],
) -> Vec<Ripple> {
    let rests = joint.rests(accepted, &[]);
    let of_axis = |axis: &Axis| {
        let each = joint.logs.iter().zip(&rests).map(|(log, rest)| {
            let position = Motion::new(&log.scene, axis.index()).position;
            let rows = position.into_iter().zip(&rest.raw.0[axis.index()]);
            let rows = rows.zip(&log.fresh).filter(|(_, fresh)| **fresh);
            Rest::new(rows.map(|((x, r), _)| (x, *r)))
        });
        let of_guide = joint.logs.iter().all(|log| is_of_guide(log, *axis));
        let mut all = of_rests(*axis, each.collect());
        all.iter_mut().for_each(|ripple| ripple.of_guide = of_guide);
        all
    };
    axes.iter().flat_map(of_axis).collect()
}

fn is_of_guide(log: &PreparedLog, axis: Axis) -> bool {
    /// Cosine of the angle up to which two axes are called the same.
    const ALONG: f64 = 0.999_999;
    let scene = &log.scene;
    let is_it = match scene.model.bearing() {
        Some(bearing) => bearing == axis,
        None => !axis.is_rotation() && scene.axis[axis.index()] > ALONG,
    };
    is_it && !log.has_own_origin
}

fn of_rests(axis: Axis, mut rests: Vec<Rest>) -> Vec<Ripple> {
    let before: Vec<f64> = rests.iter().map(Rest::power).collect();
    let mut all: Vec<Ripple> = Vec::new();
    for _ in 0..MOST {
        let Some((line, within)) = strongest_line(&rests) else {
            break;
        };
        let period = refined(&rests, (line, within));
        let mut least = f64::INFINITY;
        let (mut square, mut count) = (0.0, 0.0);
        for (rest, before) in rests.iter_mut().zip(&before) {
            let (was, rows) = (rest.power(), rest.values.len() as f64);
            let amplitude = rest.take(period);
            if rest.shows(line) {
                square += amplitude * rows;
                count += rows;
                least = least.min((was - rest.power()) / before);
            }
        }
        let is_beside = |other: &Ripple| (other.period.recip() - period.recip()).abs() <= within;
        if least >= SHARE && least.is_finite() && !all.iter().any(is_beside) {
            all.push(Ripple {
                axis,
                period,
                periods: line / (FINER as f64 * within),
                amplitude: f64::sqrt(square / count),
                share: least,
                of_guide: false,
            });
        }
    }
    all.sort_by(|a, b| b.share.total_cmp(&a.share));
    all
}

/// The period with which least is left, near a line.
fn refined(rests: &[Rest], (line, within): (f64, f64)) -> f64 {
    let left = |rate: f64| -> f64 {
        let of = |rest: &Rest| {
            let mut rest = rest.clone();
            rest.take(rate.recip());
            rest.power()
        };
        rests.iter().map(of).sum()
    };
    let (rate, _) = brent((line - within, line, line + within), PRECISE * within, left);
    rate.recip()
}

/// The lines that are looked for: their number, and the range of positions.
struct Grid {
    low: f64,
    travel: f64,
    periods: usize,
}

impl Grid {
    /// A grid over the travel of all logs, as fine as their median step allows. `None` where they hardly move.
    fn of(rests: &[Rest]) -> Option<Self> {
        let all = || rests.iter().flat_map(|rest| &rest.position).copied();
        let low = all().reduce(f64::min)?;
        let travel = all().reduce(f64::max)? - low;
        let steps = rests.iter().flat_map(|rest| rest.position.array_windows());
        let steps = steps.map(|[a, b]| (b - a).abs());
        let mut moving: Vec<f64> = steps.filter(|step| *step > 0.0).collect();
        let usual = median(&mut moving)?;
        let periods = ((travel / (ROWS * usual)) as usize).min(MOST_PERIODS);
        (periods >= FEWEST_PERIODS).then_some(Self {
            low,
            travel,
            periods,
        })
    }

    /// Periods per m or rad of a line.
    fn rate(&self, line: usize) -> f64 {
        (line + 1) as f64 / (FINER as f64 * self.travel)
    }

    /// Power of each line of values over positions, relative to the lines beside it.
    fn lines(&self, rows: impl Iterator<Item = (f64, f64)>) -> Vec<f64> {
        let parts = PARTS * self.periods;
        let mut sums = vec![0.0; FINER * parts];
        for (x, r) in rows {
            let part = ((x - self.low) / self.travel * parts as f64) as usize;
            sums[part.min(parts - 1)] += r;
        }
        let power = periodogram(&sums);
        let beside = |k: usize| {
            let around = k.saturating_sub(BESIDE)..(k + BESIDE + 1).min(power.len());
            median(&mut power[around].to_vec()).unwrap_or(0.0) / std::f64::consts::LN_2
        };
        let over = |k: usize| power[k] / beside(k).max(f64::MIN_POSITIVE);
        (0..power.len().min(FINER * self.periods))
            .map(over)
            .collect()
    }
}

/// The strongest line over the position that stands out in each log that travels far enough: its rate in periods per m or rad,
/// and the distance between two lines.
fn strongest_line(rests: &[Rest]) -> Option<(f64, f64)> {
    let grid = Grid::of(rests)?;
    let each: Vec<Vec<f64>> = rests.iter().map(|rest| rest.lines(&grid)).collect();
    let in_all = |k: usize| {
        let showing = rests
            .iter()
            .zip(&each)
            .filter(|(rest, _)| rest.shows(grid.rate(k)));
        let lines = showing.map(|(_, lines)| lines.get(k).copied().unwrap_or(0.0));
        lines.reduce(f64::min).unwrap_or(0.0)
    };
    let lines = FINER * FEWEST_PERIODS - 1..FINER * grid.periods;
    let strongest = lines
        .map(|k| (k, in_all(k)))
        .max_by(|a, b| a.1.total_cmp(&b.1));
    let (k, _) = strongest.filter(|(_, over_beside)| *over_beside > LINE)?;
    Some((grid.rate(k), grid.rate(0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_statistics::RandomStream;

    /// Swings of 0.3 m, with `force`, a function of time and position, and noise of 1.
    fn logs(force: impl Fn(f64, f64) -> f64) -> Vec<Rest> {
        let log = |seed: u64| {
            let mut random = RandomStream::new(seed, 0);
            let times = (0..5000).map(|n| 0.004 * n as f64);
            let rows = times.map(|t| {
                let x = 0.2 * (0.7 * t + seed as f64).sin() + 0.1 * (1.9 * t).sin();
                (x, random.normal() + force(t, x))
            });
            Rest::new(rows)
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

    /// Jogs of 10 mm with a rest after each: what follows the acceleration repeats every 10 mm, and so do the positions.
    #[test]
    fn what_follows_a_motion_in_equal_steps_is_no_ripple() {
        let log = |seed: u64| {
            let mut random = RandomStream::new(seed, 0);
            let rows = (0..8000).map(|n| {
                let (step, within) = (n / 200, (n % 200) as f64 / 100.0);
                let part = within.min(1.0);
                let x = 0.01 * (step as f64 + part - (TAU * part).sin() / TAU);
                (x, random.normal() + 5.0 * (TAU * part).sin())
            });
            Rest::new(rows)
        };
        assert_eq!(of_rests(Axis::X, vec![log(1), log(2)]), []);
    }

    /// A log that rests is not asked.
    #[test]
    fn a_log_that_hardly_moves_hides_no_ripple() {
        let mut both = logs(|_, x| 0.9 * (TAU * x / 0.0123).sin());
        let still = (0..5000).map(|n| (0.1 + 1e-5 * f64::from(n % 2), f64::from(n % 7)));
        both.push(Rest::new(still));
        assert_eq!(of_rests(Axis::X, both).len(), 1);
    }

    #[test]
    fn of_what_stands_still_nothing_is_said() {
        let rest = || Rest::new((0..1000).map(|n| (0.1, f64::from(n).sin())));
        assert_eq!(of_rests(Axis::X, vec![rest(), rest()]), []);
    }
}
