//! Whether a residual is noise, or still has structure; four tests that look at different things.
//!
//! The limits are above the largest values that logs without any missing effect have shown; there is
//! structure only if all logs say so that are long enough to.

use super::rounding::Rounded;
use super::wrench::{Joint, PreparedLog, Remainder, Rest, Tested, sheet_sigma};
use softdock_actuator::Reading;
use softdock_physics::model::load::Column;
use softdock_physics::model::log::Log;
use softdock_physics::model::{Axis, Channel};
use softdock_statistics::{median, periodogram};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Power below [`SLOW_HZ`] over the median power (noise: at most 1.9).
const SLOW: f64 = 3.0;
/// Below this frequency most effects live, Hz.
pub(crate) const SLOW_HZ: f64 = 6.0;
/// Strongest window over the median window, at the least (noise of 4 ms cycles: at most 1.7).
const BURST: f64 = 2.5;
/// Probability with which white noise has a burst in any window of a log: windows of few samples vary more. By their own median
/// it is up to 0.004 where there are few windows.
const BURST_BY_CHANCE: f64 = 1e-3;
/// Fewest cycles of a log in which bursts, lines and slow parts are looked for.
const SHORTEST: usize = 64;
/// Duration of a window, s.
const BURST_S: f64 = 0.25;
/// Strongest line of the spectrum over its median (noise: at most 15).
pub(crate) const LINE: f64 = 22.0;
/// Duration of a piece whose spectrum is taken, s.
const LINE_S: f64 = 1.0;
/// Level over the data sheet's noise (noise of 1.6 times its size: at most 1.7).
pub(super) const LEVEL: f64 = 1.8;

/// Share of the error that may be left without being called structure.
const REMAINDER: f64 = 0.01;
/// The same where each effect stands beside a smooth remainder. Set by hand, not calibrated: friction laws of
/// real joints leave about 3 %, imitations of what is outside of the catalogue 4 % at the least and mostly more than 10 %
/// (`softdock bench diagnose --seed 3`), so that one of them is named.
const MODELLED: f64 = 0.05;
/// The same where a smooth remainder describes all but [`DESCRIBED`] of it without any contact, whose own law it could
/// be: what is named explains at least three times what stays without a name. Set by hand.
const NAMELESS: f64 = 0.25;
/// Share of the error that effects and remainder together may leave then: what a drive's torque, late by some
/// milliseconds, leaves of a swinging weight is a function of none of its quantities. Set by hand.
const DESCRIBED: f64 = 0.1;

/// What is left of a channel after effects.
#[derive(Clone, Debug, Default)]
pub(crate) struct Left {
    /// Axes, with what the tests find on each log.
    pub axes: Vec<(Channel, Axis, Vec<Structure>)>,
    /// Excess over the noise that is left, of what there was.
    pub share: f64,
    /// The same in units of the data sheet's noise, without what the whitening does: what effects gain beside a remainder is no
    /// measure of what they explain.
    plain: f64,
    /// Share that may be left without being called structure.
    allowed: f64,
}

impl Left {
    pub(crate) fn new(axes: Vec<(Channel, Axis, Vec<Structure>)>, share: f64) -> Self {
        Self {
            axes,
            share,
            plain: share,
            allowed: REMAINDER,
        }
    }

    /// Of velocities: `squares` is χ² of `count` values that is left, `nominal` what there was.
    pub(crate) fn of_velocities(
        axes: Vec<(Channel, Axis, Vec<Structure>)>,
        squares: f64,
        nominal: f64,
        count: usize,
    ) -> Self {
        let excess = (squares - count as f64).max(0.0);
        Self::new(axes, excess / (excess + nominal - squares).max(1.0))
    }

    /// The same with effects that stand beside a smooth remainder; `left`: what both leave.
    pub(crate) fn beside(self, remainder: &Remainder, left: &Self) -> Self {
        let described = left.share <= DESCRIBED && !remainder.is_of_contact();
        match described {
            true => Self {
                allowed: NAMELESS,
                share: self.plain,
                ..self
            },
            false => Self {
                allowed: MODELLED,
                ..self
            },
        }
    }

    /// Whether the logs show structure that is more than a remainder.
    pub(crate) fn any(&self) -> bool {
        self.share > self.allowed && self.is_structured()
    }

    /// Whether the logs show any structure.
    pub(crate) fn is_structured(&self) -> bool {
        self.structured().next().is_some()
    }

    /// Axes with structure on all logs.
    pub(crate) fn structured(&self) -> impl Iterator<Item = &(Channel, Axis, Vec<Structure>)> {
        self.axes
            .iter()
            .filter(|(_, _, each)| Structure::in_all(each))
    }
}

/// What effects, and a smooth remainder of each log if there is one, leave of the wrench.
pub(crate) fn left(joint: &Joint, tested: Option<&Tested>, smooth: &[Column]) -> Left {
    let gain = tested.map_or(0.0, |t| t.gain);
    of_rests(joint, &joint.rests(tested, smooth), gain, Constant::Common)
}

/// What effects leave that each log has in amounts of its own, which together gain so much.
pub(crate) fn left_apart(joint: &Joint, own: &[Column], gain: f64) -> Left {
    of_rests(joint, &joint.rests(None, own), gain, Constant::Own)
}

/// What an offset is that nothing else has the merit of.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Constant {
    /// All logs share it.
    Common,
    /// Each log has one of its own.
    Own,
}

fn of_rests(joint: &Joint, rests: &[Rest], gain: f64, constant: Constant) -> Left {
    let each = joint.logs.iter().zip(rests);
    let of_logs: Vec<(Vec<Structure>, Excess)> =
        each.map(|(log, rest)| of_log(joint, log, rest)).collect();
    let axes = Axis::ALL
        .into_iter()
        .map(|axis| {
            let each = of_logs.iter().map(|(s, _)| s[axis.index()].clone());
            (Channel::Wrench, axis, each.collect())
        })
        .collect();
    let sum = |of: &dyn Fn(&Excess) -> f64| of_logs.iter().map(|(_, e)| of(e)).sum::<f64>();
    let plain = share(sum(&|e| e.plain), removed(joint, rests, constant));
    let white = share(sum(&|e| e.white), joint.explained_beyond_zeros(gain));
    Left {
        axes,
        share: if joint.has_remainder {
            plain
        } else {
            plain.max(white)
        },
        plain,
        allowed: REMAINDER,
    }
}

/// Excess that is left, of what there was.
fn share(left: f64, removed: f64) -> f64 {
    let (left, removed) = (left.max(0.0), removed.max(0.0));
    left / (left + removed).max(1.0)
}

/// χ² that a log leaves over its number of values.
struct Excess {
    /// In units of the noise.
    white: f64,
    /// In units of the data sheet's: whitening can swallow what is locked to the motion.
    plain: f64,
}

/// What effects and tolerances have taken of χ² in units of the data sheet's noise, but for what a constant would take: to remove an
/// offset is no merit of what else is believed.
fn removed(joint: &Joint, rests: &[Rest], constant: Constant) -> f64 {
    let changes = |columns: &[Column], axis: usize| {
        let each = joint.logs.iter().zip(columns);
        let sums = each.map(|(log, column)| {
            let count = log.fresh.iter().filter(|fresh| **fresh).count() as f64;
            let (mean, level) = moments(log, column, axis);
            (count, count * mean, count * level * level)
        });
        let about_mean = |(count, sum, power): (f64, f64, f64)| power - sum * sum / count.max(1.0);
        match constant {
            Constant::Own => sums.map(about_mean).sum(),
            Constant::Common => about_mean(sums.fold((0.0, 0.0, 0.0), |all, one| {
                (all.0 + one.0, all.1 + one.1, all.2 + one.2)
            })),
        }
    };
    let nominal = |log: &PreparedLog| {
        let mut nominal = log.scene.known();
        nominal.add(&log.residual.0);
        nominal
    };
    let nominal: Vec<Column> = joint.logs.iter().map(nominal).collect();
    let raw: Vec<Column> = rests.iter().map(|rest| rest.raw.clone()).collect();
    let taken = |axis| changes(&nominal, axis) - changes(&raw, axis);
    (0..6).map(taken).sum()
}

/// Structure of each axis of a log, and the excess of χ² over its number of values.
fn of_log(joint: &Joint, log: &PreparedLog, rest: &Rest) -> (Vec<Structure>, Excess) {
    let (white, levels) = beyond_rounding(log, rest);
    let squares: f64 = white.0.iter().flatten().map(|w| w * w).sum();
    let values = joint.problem.axes * log.fresh.iter().filter(|f| **f).count();
    let structures: Vec<Structure> = (0..6)
        .map(|axis| {
            let level = levels[axis].unwrap_or_else(|| moments(log, &rest.raw, axis).1);
            if log.scene.model.sensor.at_rest {
                // Rows that do not follow each other have no spectrum.
                return Structure {
                    level,
                    ..Structure::default()
                };
            }
            counted(log, &white.0[axis], level)
        })
        .collect();
    let values = values as f64;
    let of_axis = values / joint.problem.axes as f64;
    let left: f64 = structures.iter().map(|s| s.level * s.level).sum();
    let excess = Excess {
        white: squares - values,
        plain: left * of_axis - values,
    };
    (structures, excess)
}

/// Mean and root mean square of the cycles that count, over the data sheet's noise.
fn moments(log: &PreparedLog, column: &Column, axis: usize) -> (f64, f64) {
    let counted = column.0[axis].iter().zip(&log.fresh);
    let counted = counted.filter(|(_, fresh)| **fresh).map(|(r, _)| *r);
    let sums = counted.fold((0.0, 0.0, 0.0), |(sum, power, count), r| {
        (sum + r, power + r * r, count + 1.0)
    });
    let (sum, power, count) = sums;
    let count = f64::max(count, 1.0);
    let sheet = log.sheet_sigma[axis];
    (sum / count / sheet, (power / count).sqrt() / sheet)
}

/// Tests the cycles that count, as if the others had not been.
fn counted(log: &PreparedLog, white: &[f64], level: f64) -> Structure {
    let counts = log.fresh.iter().enumerate();
    let places: Vec<usize> = counts.filter(|(_, c)| **c).map(|(n, _)| n).collect();
    let series: Vec<f64> = places
        .iter()
        .filter_map(|n| white.get(*n).copied())
        .collect();
    let filter = log.scene.model.sensor.filter;
    let cutoff_hz = filter.map_or(f64::INFINITY, |filter| filter.cutoff_hz);
    let mut found = Structure::below(cutoff_hz, &series, log.scene.cycle_s, level);
    let place = |n: usize| places.get(n).copied().unwrap_or_default();
    let of_all = |(first, length): (usize, usize)| {
        let last = place(first + length.saturating_sub(1));
        (place(first), last.saturating_sub(place(first)) + 1)
    };
    found.burst_at = of_all(found.burst_at);
    for line in [&mut found.line, &mut found.narrow] {
        line.at = of_all(line.at);
    }
    found.length = log.fresh.len();
    found
}

/// Rounded readings have residuals of their own, and a level over the data sheet's noise. The
/// tolerances, which were taken as if rounding were noise, count only where they help.
fn beyond_rounding(log: &PreparedLog, rest: &Rest) -> (Column, [Option<f64>; 6]) {
    let sheet = sheet_sigma(&log.scene.model);
    let mut white = rest.white.clone();
    let levels = std::array::from_fn(|axis| {
        let half = log.half_step[axis];
        (half > 0.0).then(|| {
            let [with, exact] =
                [&rest.raw, &rest.exact].map(|r| Rounded::new(&r.0[axis], half, sheet[axis]));
            let mut own = if with.cost < exact.cost { with } else { exact };
            // A repeated reading says nothing new.
            for (residual, fresh) in own.white.iter_mut().zip(&log.fresh) {
                if !fresh {
                    *residual = 0.0;
                }
            }
            let squares: f64 = own.white.iter().map(|r| r * r).sum();
            white.0[axis] = own.white;
            let fresh = log.fresh.iter().filter(|f| **f).count();
            (squares / fresh.max(1) as f64).sqrt() * own.sigma / sheet[axis]
        })
    });
    (white, levels)
}

/// A frequency in the spectrum of a piece of a series.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Line {
    /// Its power over the median of the spectrum.
    pub over_usual: f64,
    /// Its frequency, Hz.
    pub hz: f64,
    /// First cycle of the piece, and its length.
    at: (usize, usize),
}

/// What the tests find in one series.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Structure {
    /// Power below 6 Hz over the median power.
    pub slow: f64,
    /// Strongest window over the median window, divided by the most that noise has: a burst above 1.
    pub burst: f64,
    /// First cycle of the strongest window, and its length.
    pub burst_at: (usize, usize),
    /// Strongest part of the spectrum of a piece.
    pub line: Line,
    /// Strongest one that stands out of the frequencies beside it, too: of what an import has filtered, all that is slow stands out
    /// of the rest.
    pub narrow: Line,
    /// Number of rows that were tested.
    pub count: usize,
    /// Number of cycles.
    pub length: usize,
    /// Root mean square before whitening over the data sheet's noise.
    pub level: f64,
}

impl Structure {
    /// Tests what is left of a velocity. The noise of a difference of poses rises with frequency, and instants that
    /// scatter leave bursts: there only its size counts.
    pub(crate) fn of_velocity(white: &[f64], log: &Log, level: f64, scatters: bool) -> Self {
        let all = Self::of(white, log.cycle_s, level);
        if scatters || log.reading == Reading::Mean {
            all.of_size()
        } else {
            all
        }
    }

    /// Tests a series: `white` in units of its noise, `level` its size over the data sheet's.
    pub(crate) fn of(white: &[f64], cycle_s: f64, level: f64) -> Self {
        Self::below(f64::INFINITY, white, cycle_s, level)
    }

    /// The same of a series that went through a low-pass: what is above its cutoff, if anything, is neither usual nor does it
    /// stand out. Slow is the lower half of what is below, if that is less than [`SLOW_HZ`].
    fn below(cutoff_hz: f64, white: &[f64], cycle_s: f64, level: f64) -> Self {
        if white.len() < SHORTEST {
            return Self {
                level,
                count: white.len(),
                ..Self::default()
            };
        }
        let bin_hz = 1.0 / (cycle_s * white.len() as f64);
        let power = periodogram_below(cutoff_hz, white, bin_hz);
        let slow_bins = ((SLOW_HZ / bin_hz) as usize).clamp(1, power.len() / 2);
        let slow = power[..slow_bins].iter().sum::<f64>() / slow_bins as f64;
        // The median of an exponential variable is ln 2 of its mean.
        let usual = usual(power.clone()) / std::f64::consts::LN_2;
        let (burst, burst_at) = strongest_window(white, cycle_s);
        let [line, narrow] = strongest_lines(cutoff_hz, white, cycle_s);
        Self {
            slow: slow / usual.max(1e-12),
            burst,
            burst_at,
            line,
            narrow,
            count: white.len(),
            length: white.len(),
            level,
        }
    }

    /// Whether the same test fires on all logs. One that is too short for it has no say, but of several two must have one.
    pub(crate) fn in_all(each: &[Self]) -> bool {
        let has_level = !each.is_empty() && each.iter().all(|s| s.level > LEVEL);
        let long: Vec<&Self> = each.iter().filter(|s| s.count >= SHORTEST).collect();
        let all = |fires: &dyn Fn(&Self) -> bool| {
            long.len() >= each.len().clamp(1, 2) && long.iter().all(|s| fires(s))
        };
        all(&|s| s.slow > SLOW)
            || all(&|s| s.burst > 1.0)
            || all(&|s| s.line.over_usual > LINE)
            || has_level
    }

    /// Only its size counts: for what is left of a clock whose jitter was recovered but for noise.
    pub(crate) fn of_size(self) -> Self {
        Self {
            level: self.level,
            count: self.count,
            length: self.length,
            ..Self::default()
        }
    }

    /// What fires, in words.
    pub(crate) fn words(&self) -> String {
        self.strongest().1
    }

    /// The same, with the first cycle of where it is strongest, and the length of that.
    pub(crate) fn strongest(&self) -> ((usize, usize), String) {
        let whole = (0, self.length);
        if self.narrow.over_usual > LINE {
            let line = format!("a spectral line at {:.1} Hz", self.narrow.hz);
            (self.narrow.at, line)
        } else if self.burst > 1.0 {
            (self.burst_at, "bursts".to_owned())
        } else if self.slow > SLOW {
            (whole, format!("slow, below {SLOW_HZ:.0} Hz"))
        } else if self.line.over_usual > LINE {
            (self.line.at, format!("a band near {:.1} Hz", self.line.hz))
        } else {
            (whole, "spread over the whole log".to_owned())
        }
    }
}

/// The strongest window by what noise may have, with its first cycle and its length.
fn strongest_window(white: &[f64], cycle_s: f64) -> (f64, (usize, usize)) {
    let length = ((BURST_S / cycle_s) as usize).clamp(8, white.len());
    let powers: Vec<(usize, f64)> = white
        .windows(length)
        .enumerate()
        .step_by((length / 2).max(1))
        .map(|(n, window)| (n, window.iter().map(|w| w * w).sum::<f64>() / length as f64))
        .collect();
    let usual = usual(powers.iter().map(|p| p.1).collect());
    let strongest = powers
        .iter()
        .copied()
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or_default();
    let most = most_of_windows(length, powers.len()).max(BURST);
    (strongest.1 / usual.max(1e-12) / most, (strongest.0, length))
}

/// Power of a window of white noise over the median one that the strongest of so many exceeds by [`BURST_BY_CHANCE`].
fn most_of_windows(length: usize, windows: usize) -> f64 {
    let Ok(law) = ChiSquared::new(length as f64) else {
        return f64::INFINITY;
    };
    let chance = BURST_BY_CHANCE / windows.max(1) as f64;
    law.inverse_cdf(1.0 - chance) / law.inverse_cdf(0.5)
}

/// Median of powers; 0 of nothing.
fn usual(mut powers: Vec<f64>) -> f64 {
    median(&mut powers).unwrap_or(0.0)
}

/// The powers from one to the next `bin_hz` up to a cutoff, two at the least.
fn periodogram_below(cutoff_hz: f64, white: &[f64], bin_hz: f64) -> Vec<f64> {
    let mut power = periodogram(white);
    power.truncate(((cutoff_hz / bin_hz) as usize).max(2));
    power
}

/// The strongest part of the spectrum of any piece, and the strongest one that is narrow.
fn strongest_lines(cutoff_hz: f64, white: &[f64], cycle_s: f64) -> [Line; 2] {
    /// Frequencies below a cutoff, out of whose median noise does not stand by [`LINE`].
    const FREQUENCIES: f64 = 32.0;
    /// Periods in a piece from which a line is one: with fewer, what changes slowly looks like it.
    const PERIODS: usize = 3;
    /// Frequencies to either side out of which a line stands as out of the whole spectrum.
    const BESIDE: usize = 4;
    let piece_s = LINE_S.max(FREQUENCIES / cutoff_hz);
    let length = ((piece_s / cycle_s) as usize).clamp(32, white.len());
    let nothing = Line {
        at: (0, length),
        ..Line::default()
    };
    let [mut strongest, mut narrow] = [nothing; 2];
    let bin_hz = 1.0 / (cycle_s * length as f64);
    for (n, piece) in white.chunks_exact(length).enumerate() {
        let power = periodogram_below(cutoff_hz, piece, bin_hz);
        let of_all = usual(power.clone()) / std::f64::consts::LN_2;
        for (k, p) in power.iter().enumerate() {
            let line = Line {
                over_usual: p / of_all.max(1e-12),
                hz: (k + 1) as f64 * bin_hz,
                at: (n * length, length),
            };
            if line.over_usual > strongest.over_usual {
                strongest = line;
            }
            let around = k.saturating_sub(BESIDE)..(k + BESIDE + 1).min(power.len());
            let beside = [k.checked_sub(1), Some(k + 1)].into_iter().flatten();
            let is_peak = beside.filter_map(|n| power.get(n)).all(|other| other < p);
            let level = || usual(power[around].to_vec()) / std::f64::consts::LN_2;
            let is_narrow = || is_peak && *p > LINE * level();
            if line.over_usual > narrow.over_usual && k + 1 >= PERIODS && is_narrow() {
                narrow = line;
            }
        }
    }
    [strongest, narrow]
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_statistics::{LowPass, RandomStream};
    use std::f64::consts::TAU;

    /// What is left of 20 s at 500 Hz, with waves of so many sigma at these frequencies, Hz.
    fn words(waves: &[(f64, f64)]) -> String {
        let mut state = 1_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
            (state >> 40) as f64 / (1_u64 << 24) as f64 - 0.5
        };
        let at = |n: usize| n as f64 * 0.002;
        let wave = |n: usize| {
            waves
                .iter()
                .map(move |(hz, size)| size * (TAU * hz * at(n) + hz * hz).sin())
        };
        let series: Vec<f64> = (0..10_000)
            .map(|n| 12_f64.sqrt() * uniform() + wave(n).sum::<f64>())
            .collect();
        Structure::of(&series, 0.002, 1.0).words()
    }

    /// A band is no line, and hides none that is lower than it.
    #[test]
    fn a_line_stands_out_of_what_is_beside_it() {
        let band: Vec<(f64, f64)> = (0..24).map(|k| (20.0 + k as f64, 3.0)).collect();
        assert_eq!(words(&[(100.0, 2.0)]), "a spectral line at 100.0 Hz");
        assert!(words(&band).starts_with("a band near"), "{}", words(&band));
        let both = [&band[..], &[(100.0, 2.0)]].concat();
        assert_eq!(words(&both), "a spectral line at 100.0 Hz");
    }

    fn white(seed: u64, count: usize) -> Vec<f64> {
        let mut noise = RandomStream::new(seed, 0);
        (0..count).map(|_| noise.normal()).collect()
    }

    /// Noise that went through a low-pass is nothing but noise below its cutoff; a wave there is a line all the same.
    #[test]
    fn above_a_low_pass_nothing_is_usual() {
        let low_pass = LowPass::new(4, 40.0 * 0.002);
        let with = |amplitude: f64| {
            let wave = |n: usize| amplitude * (TAU * 20.0 * 0.002 * n as f64).sin();
            let noise = white(7, 10_000).into_iter().enumerate();
            let all: Vec<f64> = noise.map(|(n, noise)| noise + wave(n)).collect();
            low_pass.zero_phase(&all)
        };
        let lines = |found: Structure| found.line.over_usual > LINE || found.slow > SLOW;
        assert!(lines(Structure::of(&with(0.0), 0.002, 1.0)));
        assert!(!lines(Structure::below(40.0, &with(0.0), 0.002, 1.0)));
        let waves = Structure::below(40.0, &with(2.0), 0.002, 1.0);
        assert_eq!(waves.words(), "a spectral line at 20.0 Hz");
    }

    /// However few frequencies a second has below the cutoff.
    #[test]
    fn noise_behind_a_low_cutoff_is_no_line() {
        for cutoff_hz in [3.0, 5.0, 10.0] {
            let low_pass = LowPass::new(4, cutoff_hz * 0.01);
            for seed in 0..40 {
                let noise = low_pass.zero_phase(&white(seed, 12_000));
                let found = Structure::below(cutoff_hz, &noise, 0.01, 1.0);
                let over = found.line.over_usual;
                assert!(over < LINE, "{cutoff_hz} Hz, {seed}: {over}");
            }
        }
    }

    /// Of a log of five minutes at 10 Hz, whose windows have eight samples, and of 100 s at 250 Hz.
    #[test]
    fn white_noise_has_no_bursts_however_few_samples_a_window_has() {
        for (cycle_s, count) in [(0.1, 3000), (0.02, 5000), (0.004, 25_000)] {
            for seed in 0..20 {
                let burst = Structure::of(&white(seed, count), cycle_s, 1.0).burst;
                assert!(burst < 1.0, "{cycle_s} s, {seed}: {burst}");
            }
        }
        let mut loud = white(1, 3000);
        loud[1000..1010].iter_mut().for_each(|value| *value *= 5.0);
        let found = Structure::of(&loud, 0.1, 1.0);
        assert_eq!(found.words(), "bursts");
        assert!((990..1010).contains(&found.burst_at.0));
    }

    /// A line that all long logs show is one, whatever a log of 50 cycles can say.
    #[test]
    fn a_log_that_is_too_short_has_no_say() {
        let line = |n: usize| 2.0 * (TAU * 0.2 * n as f64).sin();
        let mut series = white(2, 10_000);
        series
            .iter_mut()
            .enumerate()
            .for_each(|(n, value)| *value += line(n));
        let long = Structure::of(&series, 0.002, 1.0);
        let short = Structure::of(&white(3, 50), 0.002, 1.0);
        let quiet = Structure::of(&white(4, 10_000), 0.002, 1.0);
        assert!(Structure::in_all(std::slice::from_ref(&long)));
        assert!(Structure::in_all(&[
            long.clone(),
            long.clone(),
            short.clone()
        ]));
        assert!(!Structure::in_all(&[long.clone(), short.clone()]));
        assert!(!Structure::in_all(&[long, short.clone(), quiet]));
        assert!(!Structure::in_all(&[short]));
    }

    /// The whitened share is another before and after `add`: what the model has is no gain of the search. The answer is the same.
    #[test]
    fn beside_a_remainder_the_plain_share_decides() {
        let left = Left {
            share: 0.27,
            plain: 0.16,
            ..Left::default()
        };
        let remainder = Remainder::default();
        let described = left.clone().beside(&remainder, &Left::default());
        assert_eq!((described.share, described.allowed), (0.16, NAMELESS));
        let much = Left {
            share: 0.2,
            ..Left::default()
        };
        let undescribed = left.beside(&remainder, &much);
        assert_eq!((undescribed.share, undescribed.allowed), (0.27, MODELLED));
    }
}
