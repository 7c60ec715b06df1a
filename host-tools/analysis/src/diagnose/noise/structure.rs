//! Whether a residual is noise, or still has structure; four tests that look at different things.
//!
//! The limits are above the largest values that logs without any missing effect have shown; there is
//! structure only if all logs say so that are long enough to.

use softdock_actuator::Reading;
use softdock_physics::model::log::Log;
use softdock_report::number;
use softdock_statistics::{median, periodogram};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Power below [`SLOW_HZ`] over the usual power, at the least (noise of long logs: at most 1.9).
const SLOW: f64 = 3.0;
/// Below this frequency most effects live, Hz.
pub(crate) const SLOW_HZ: f64 = 6.0;
/// Strongest window over the median window, at the least (noise of 4 ms cycles: at most 1.7).
const BURST: f64 = 2.5;
/// Probability with which white noise has a burst in any window of a log, or is slow: windows of few samples and few frequencies vary
/// more. By the windows' own median it is up to 0.004 where there are few.
const BY_CHANCE: f64 = 1e-3;
/// Fewest cycles of a log in which bursts, lines and slow parts are looked for.
const SHORTEST: usize = 64;
/// Duration of a window, s.
const BURST_S: f64 = 0.25;
/// Strongest line of the spectrum over its median (noise: at most 15).
pub(crate) const LINE: f64 = 22.0;
/// Duration of a piece whose spectrum is taken, s.
const LINE_S: f64 = 1.0;
/// Level over the data sheet's noise (noise of 1.6 times its size: at most 1.7).
pub(crate) const LEVEL: f64 = 1.8;

/// A frequency in the spectrum of a piece of a series.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Line {
    /// Its power over the median of the spectrum.
    pub over_usual: f64,
    /// Its frequency, Hz.
    pub hz: f64,
    /// First cycle of the piece, and its length.
    pub at: (usize, usize),
}

/// What the tests find in one series.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Structure {
    /// Power below `slow_hz` over the usual power, divided by the most that noise has: slow above 1.
    pub slow: f64,
    /// 6 Hz, or half of the band if that is less.
    pub slow_hz: f64,
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
    pub(crate) fn below(cutoff_hz: f64, white: &[f64], cycle_s: f64, level: f64) -> Self {
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
            slow: slow / usual.max(1e-12) / most_of_bins(slow_bins).max(SLOW),
            slow_hz: SLOW_HZ.min(slow_bins as f64 * bin_hz),
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
        all(&|s| s.slow > 1.0)
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
        } else if self.slow > 1.0 {
            (
                whole,
                format!("slow, below {} Hz", number::significant(self.slow_hz, 2)),
            )
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

/// Power of a window of white noise over the median one that the strongest of so many exceeds by [`BY_CHANCE`].
fn most_of_windows(length: usize, windows: usize) -> f64 {
    let Ok(law) = ChiSquared::new(length as f64) else {
        return f64::INFINITY;
    };
    let chance = BY_CHANCE / windows.max(1) as f64;
    law.inverse_cdf(1.0 - chance) / law.inverse_cdf(0.5)
}

/// Mean power of so many frequencies of white noise over that of all, which it exceeds by [`BY_CHANCE`].
fn most_of_bins(bins: usize) -> f64 {
    let freedom = 2.0 * bins as f64;
    ChiSquared::new(freedom).map_or(f64::INFINITY, |law| {
        law.inverse_cdf(1.0 - BY_CHANCE) / freedom
    })
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
        let mut noise = RandomStream::new(1, 0);
        let at = |n: usize| n as f64 * 0.002;
        let wave = |n: usize| {
            waves
                .iter()
                .map(move |(hz, size)| size * (TAU * hz * at(n) + hz * hz).sin())
        };
        let series: Vec<f64> = (0..10_000)
            .map(|n| noise.normal() + wave(n).sum::<f64>())
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
    /// One frequency alone is below 6 Hz, which has three times the usual power in one of twenty.
    #[test]
    fn short_noise_is_rarely_slow() {
        let is_slow = |seed: &u64| Structure::of(&white(*seed, 160), 1e-3, 1.0).slow > 1.0;
        let slow = (0..1000).filter(is_slow).count();
        assert!(slow < 8, "{slow} of 1000");
    }

    #[test]
    fn above_a_low_pass_nothing_is_usual() {
        let low_pass = LowPass::new(4, 40.0 * 0.002);
        let with = |amplitude: f64| {
            let wave = |n: usize| amplitude * (TAU * 20.0 * 0.002 * n as f64).sin();
            let noise = white(7, 10_000).into_iter().enumerate();
            let all: Vec<f64> = noise.map(|(n, noise)| noise + wave(n)).collect();
            low_pass.zero_phase(&all)
        };
        let lines = |found: Structure| found.line.over_usual > LINE || found.slow > 1.0;
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
}
