//! Four tests that tell noise from structure in a residual; each looks at another property.
//!
//! The limits are above the largest values that logs without any missing effect have shown. There is structure only if all logs
//! that are long enough for a test show it.

use softdock_actuator::Reading;
use softdock_physics::model::log::Log;
use softdock_report::number;
use softdock_statistics::{median, periodogram};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Power below [`SLOW_HZ`] over the median power from which a residual is slow (noise of long logs: at most 1.9).
const SLOW: f64 = 3.0;
/// Most effects act below this frequency, Hz.
pub(crate) const SLOW_HZ: f64 = 6.0;
/// Power of the strongest window over that of the median window from which it is a burst (noise of 4 ms cycles: at most 1.7).
const BURST: f64 = 2.5;
/// Probability that white noise has a burst in any window of a log, or is slow; it raises the limits where windows have few
/// samples or the slow part few frequencies. As the median is that of the windows themselves, it is up to 0.004 where there are
/// few.
const BY_CHANCE: f64 = 1e-3;
/// Fewest rows with which bursts, lines and slow parts are looked for.
const SHORTEST: usize = 64;
/// Duration of a window, s.
const BURST_S: f64 = 0.25;
/// Strongest line of the spectrum over its median from which it is structure (noise: at most 15).
pub(crate) const LINE: f64 = 22.0;
/// Duration of a piece whose spectrum is taken, s.
const LINE_S: f64 = 1.0;
/// Level over the data sheet's noise from which it is structure (noise of 1.6 times its size: at most 1.7).
pub(crate) const LEVEL: f64 = 1.8;

/// A peak in the spectrum of a piece of a series.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Line {
    /// Its power over the median of the spectrum.
    pub over_usual: f64,
    /// Its frequency, Hz.
    pub hz: f64,
    /// First cycle of the piece, and its length.
    pub at: (usize, usize),
    /// Sum of squares of the series that the peak accounts for: a sine wave has two lines in a spectrum, of which one is counted.
    pub squares: f64,
}

/// Results of the tests on one series.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Structure {
    /// Power below `slow_hz` over the median power, divided by the limit for noise: the residual is slow above 1.
    pub slow: f64,
    /// 6 Hz, or half of the band if that is lower.
    pub slow_hz: f64,
    /// Strongest window over the median window, divided by the limit for noise: a burst above 1.
    pub burst: f64,
    /// First cycle of the strongest window, and its length.
    pub burst_at: (usize, usize),
    /// Sum of squares of the series in the strongest window.
    pub burst_squares: f64,
    /// Strongest peak over the whole spectrum of its piece.
    pub line: Line,
    /// Strongest peak that also exceeds the frequencies beside it: behind the filter of an import, all slow parts exceed the rest
    /// of the spectrum.
    pub narrow: Line,
    /// Number of rows that were tested.
    pub count: usize,
    /// Number of cycles.
    pub length: usize,
    /// Rms before whitening, over the data sheet's noise.
    pub level: f64,
}

impl Structure {
    /// Tests the residual of a velocity. If it is a difference of poses, its noise rises with frequency, and scattering instants
    /// leave bursts; then only its level counts.
    pub(crate) fn of_velocity(white: &[f64], log: &Log, level: f64, scatters: bool) -> Self {
        let all = Self::of(white, log.cycle_s, level);
        if scatters || log.reading == Reading::Mean {
            all.of_size()
        } else {
            all
        }
    }

    /// Tests a series: `white` is the whitened residual, `level` its rms over the data sheet's noise.
    pub(crate) fn of(white: &[f64], cycle_s: f64, level: f64) -> Self {
        Self::below(f64::INFINITY, white, cycle_s, level)
    }

    /// The same for a series behind a low-pass. Frequencies above the cutoff are not used. The slow part is the lower half of
    /// what is below the cutoff, if that is less than [`SLOW_HZ`].
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
        // The median of an exponential variable is ln 2 times its mean.
        let usual = usual(power.clone()) / std::f64::consts::LN_2;
        let (burst, burst_at) = strongest_window(white, cycle_s);
        let (first, length) = burst_at;
        let in_burst = &white[first..first + length];
        let [line, narrow] = strongest_lines(cutoff_hz, white, cycle_s);
        Self {
            slow: slow / usual.max(1e-12) / most_of_bins(slow_bins).max(SLOW),
            slow_hz: SLOW_HZ.min(slow_bins as f64 * bin_hz),
            burst,
            burst_at,
            burst_squares: in_burst.iter().map(|w| w * w).sum(),
            line,
            narrow,
            count: white.len(),
            length: white.len(),
            level,
        }
    }

    /// Whether one test fires on all logs. Logs that are too short for it do not count, but of several logs at least two must
    /// count.
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

    /// Keeps only the level: for residuals of a clock whose jitter was recovered with an error.
    pub(crate) fn of_size(self) -> Self {
        Self {
            level: self.level,
            count: self.count,
            length: self.length,
            ..Self::default()
        }
    }

    /// The test that fires, in words.
    pub(crate) fn words(&self) -> String {
        self.strongest().1
    }

    /// First cycle and length of the place where the residual is strongest, and the test that fires there, in words. A line that
    /// stands out of a quiet piece is not what is said of a residual with a burst of more power elsewhere.
    pub(crate) fn strongest(&self) -> ((usize, usize), String) {
        let whole = (0, self.length);
        let bursts = self.burst > 1.0;
        let (piece, window) = (self.narrow.at, self.burst_at);
        let is_elsewhere = window.0 + window.1 <= piece.0 || piece.0 + piece.1 <= window.0;
        let hides = bursts && is_elsewhere && self.burst_squares > self.narrow.squares;
        if self.narrow.over_usual > LINE && !hides {
            let line = format!("a spectral line at {:.1} Hz", self.narrow.hz);
            (self.narrow.at, line)
        } else if bursts {
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

/// Power of the strongest window over the median one, divided by the limit for noise; its first cycle and its length.
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

/// Power of the strongest of so many windows of white noise, over the median window, that is exceeded with probability
/// [`BY_CHANCE`].
fn most_of_windows(length: usize, windows: usize) -> f64 {
    let Ok(law) = ChiSquared::new(length as f64) else {
        return f64::INFINITY;
    };
    let chance = BY_CHANCE / windows.max(1) as f64;
    law.inverse_cdf(1.0 - chance) / law.inverse_cdf(0.5)
}

/// Mean power of so many frequencies of white noise, over that of all, that is exceeded with probability [`BY_CHANCE`].
fn most_of_bins(bins: usize) -> f64 {
    let freedom = 2.0 * bins as f64;
    ChiSquared::new(freedom).map_or(f64::INFINITY, |law| {
        law.inverse_cdf(1.0 - BY_CHANCE) / freedom
    })
}

/// Median of powers; 0 if there are none.
fn usual(mut powers: Vec<f64>) -> f64 {
    median(&mut powers).unwrap_or(0.0)
}

/// Powers of the frequencies `bin_hz`, 2 `bin_hz`, .. up to a cutoff; at least two.
fn periodogram_below(cutoff_hz: f64, white: &[f64], bin_hz: f64) -> Vec<f64> {
    let mut power = periodogram(white);
    power.truncate(((cutoff_hz / bin_hz) as usize).max(2));
    power
}

/// The strongest peak in the spectrum of any piece, and the strongest one that is narrow.
fn strongest_lines(cutoff_hz: f64, white: &[f64], cycle_s: f64) -> [Line; 2] {
    /// Fewest frequencies below a cutoff with which noise does not exceed their median by [`LINE`].
    const FREQUENCIES: f64 = 32.0;
    /// Fewest periods in a piece for a line: with fewer, a slow change looks like one.
    const PERIODS: usize = 3;
    /// Frequencies on either side that a line has to exceed by as much as the whole spectrum.
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
                squares: 2.0 * p,
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

    /// The words for 20 s at 500 Hz of noise with waves at these frequencies, Hz, and amplitudes in σ.
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

    /// A band is no line, and does not hide a line that is lower than the band.
    #[test]
    fn a_line_stands_out_of_what_is_beside_it() {
        let band: Vec<(f64, f64)> = (0..24).map(|k| (20.0 + k as f64, 3.0)).collect();
        assert_eq!(words(&[(100.0, 2.0)]), "a spectral line at 100.0 Hz");
        assert!(words(&band).starts_with("a band near"), "{}", words(&band));
        let both = [&band[..], &[(100.0, 2.0)]].concat();
        assert_eq!(words(&both), "a spectral line at 100.0 Hz");
    }

    /// A weak wave throughout the log, and a fault of half a second that holds nearly all of the power.
    #[test]
    fn a_line_does_not_hide_a_burst_with_more_power() {
        let wave = |n: usize| 2.0 * (TAU * 0.2 * n as f64).sin();
        let mut series: Vec<f64> = white(5, 10_000)
            .into_iter()
            .enumerate()
            .map(|(n, noise)| noise + wave(n))
            .collect();
        assert_eq!(
            Structure::of(&series, 0.002, 1.0).words(),
            "a spectral line at 100.0 Hz"
        );
        series[2000..2250]
            .iter_mut()
            .for_each(|value| *value += 50.0);
        let ((from, length), words) = Structure::of(&series, 0.002, 1.0).strongest();
        assert_eq!(words, "bursts");
        assert!(
            (1990..2250).contains(&from) && length < 250,
            "{from}, {length}"
        );
    }

    fn white(seed: u64, count: usize) -> Vec<f64> {
        let mut noise = RandomStream::new(seed, 0);
        (0..count).map(|_| noise.normal()).collect()
    }

    /// A single frequency is below 6 Hz. By chance it has three times the median power in one of twenty logs.
    #[test]
    fn short_noise_is_rarely_slow() {
        let is_slow = |seed: &u64| Structure::of(&white(*seed, 160), 1e-3, 1.0).slow > 1.0;
        let slow = (0..1000).filter(is_slow).count();
        assert!(slow < 8, "{slow} of 1000");
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
