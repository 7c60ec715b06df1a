//! From where on a series is noise, by its spectrum.

use super::spectrum::{hann, lines};
use rustfft::num_complex::Complex;
use std::f64::consts::LN_2;
use std::ops::Range;

/// Fewest lines of a group, of which Hann's window leaves eight or nine independent ones.
const LEAST: usize = 16;
/// Lines of a group, as a share of its frequency.
const WIDTH: f64 = 0.15;
/// Lines below this number contain leakage of the window.
const FIRST: usize = 4;
/// A group is a signal if it has so many times the power of noise. Of groups of noise, whose lines are exponentially distributed, two
/// in ten million have.
const STANDS_OUT: f64 = 4.0;
/// A group is a signal from this coherence on: less than half of its power is noise. Of the smallest groups of noise one in 260 has,
/// of the larger ones at high frequencies none.
const COHERENT: f64 = 0.5;
/// Share of a signal's power that is worth no higher cutoff, where only the spectrum tells: a swing has most of its power at one
/// frequency. Its harmonics stand out of noise for long, but a cutoff beyond them lets through so much noise, and so much of what an
/// encoder does at each reversal, that a friction is lost.
const DISPENSABLE: f64 = 0.01;
/// So far above a signal a low-pass leaves it as it is.
const OCTAVE: usize = 2;
/// Frequencies, relative to the sampling rate, by which white noise is judged.
const JUDGED: Range<f64> = 0.3..0.45;

/// The band in which a series is noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseBand {
    /// Its lower end, relative to the sampling rate.
    pub from: f64,
    /// Share of its power in that of the series, without the mean.
    pub share: f64,
}

/// The band of a series above the highest frequencies at which it is coherent with what drives it. `None` of too short a series, or
/// where it is coherent at no frequency or at the highest ones.
pub fn incoherent_band(series: &[f64], driver: &[f64]) -> Option<NoiseBand> {
    let [series, driver] = [series, driver].map(spectrum);
    if series.len() != driver.len() {
        return None;
    }
    NoiseBand::above(&series, 0.0, |group| {
        let pairs = series[group.clone()].iter().zip(&driver[group]);
        let (mut both, mut of_series, mut of_driver) = (Complex::<f64>::default(), 0.0, 0.0);
        for (a, b) in pairs {
            both += a * b.conj();
            of_series += a.norm_sqr();
            of_driver += b.norm_sqr();
        }
        both.norm_sqr() > COHERENT * of_series * of_driver
    })
}

/// The band of a series above the highest frequencies at which it stands out of noise, the density of which is known up to a factor:
/// a function of the frequency relative to the sampling rate. If all but a hundredth of the signal's power lies more than an octave
/// below these, the band begins there, an octave above this part of the signal. `None` of too short a series, or where it stands out at no frequency or
/// at the highest ones.
pub fn noise_band(series: &[f64], density: impl Fn(f64) -> f64) -> Option<NoiseBand> {
    let count = series.len() as f64;
    let series = spectrum(series);
    let frequency = |line: usize| (line + 1) as f64 / count;
    let noise: Vec<f64> = (0..series.len()).map(|n| density(frequency(n))).collect();
    let judged = (FIRST..series.len()).filter(|n| JUDGED.contains(&frequency(*n)));
    let ratios = judged.map(|n| series[n].norm_sqr() / noise[n]);
    // The median of an exponential distribution is ln 2 of its mean.
    let floor = super::median(&mut ratios.collect::<Vec<_>>())? / LN_2;
    NoiseBand::above(&series, DISPENSABLE, |group| {
        let expected = floor * noise[group.clone()].iter().sum::<f64>();
        power(&series[group]) > STANDS_OUT * expected
    })
}

impl NoiseBand {
    /// The band above the last group of lines that is a signal, or an octave above the last of those without which more than the
    /// `dispensable` share of the signal's power would be lost.
    fn above(
        series: &[Complex<f64>],
        dispensable: f64,
        is_signal: impl Fn(Range<usize>) -> bool,
    ) -> Option<Self> {
        let groups = groups(series.len()).into_iter().rev();
        let signals: Vec<Range<usize>> = groups.filter(|group| is_signal(group.clone())).collect();
        let last = signals.first()?.end;
        let slow = power(&series[..FIRST.min(series.len())]);
        let powers: Vec<f64> = signals
            .iter()
            .map(|group| power(&series[group.clone()]))
            .collect();
        let most = dispensable * (slow + powers.iter().sum::<f64>());
        let mut above = 0.0;
        let needed = signals.iter().zip(powers).find(|(_, power)| {
            above += power;
            above > most
        });
        let from = needed.map_or(last, |(group, _)| last.min(OCTAVE * group.end));
        let all = power(series);
        let band = &series[from..];
        (all > 0.0 && band.len() >= LEAST).then(|| Self {
            from: from as f64 / (2 * series.len()) as f64,
            share: power(band) / all,
        })
    }
}

/// Lines of a series without its mean.
fn spectrum(series: &[f64]) -> Vec<Complex<f64>> {
    let mean = series.iter().sum::<f64>() / series.len() as f64;
    let centred: Vec<f64> = series.iter().map(|v| v - mean).collect();
    lines(&hann(&centred))
}

/// Neighbouring lines, more of them at higher frequencies; the last group has what is left.
fn groups(count: usize) -> Vec<Range<usize>> {
    let width = |from: usize| LEAST.max((WIDTH * from as f64) as usize);
    let mut groups = Vec::new();
    let mut from = FIRST;
    while from + width(from) <= count {
        let to = from + width(from);
        let is_last = to + width(to) > count;
        groups.push(from..if is_last { count } else { to });
        from = to;
    }
    groups
}

fn power(lines: &[Complex<f64>]) -> f64 {
    lines.iter().map(Complex::norm_sqr).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RandomStream;
    use std::f64::consts::{PI, TAU};

    const COUNT: usize = 4000;

    /// Accelerations of a random motion that ends at 2 % of the sampling rate, and of noise on its positions as second differences.
    fn accelerations(noise: f64) -> [Vec<f64>; 2] {
        let mut random = RandomStream::new(7, 0);
        let waves: Vec<[f64; 3]> = (1..80)
            .map(|k| {
                [
                    k as f64 / COUNT as f64,
                    random.normal(),
                    TAU * random.uniform(),
                ]
            })
            .collect();
        let wave = |n: usize, [f, size, phase]: &[f64; 3]| {
            size / (TAU * f).powi(2) * (TAU * f * n as f64 + phase).sin()
        };
        let motion: Vec<f64> = (0..COUNT + 2)
            .map(|n| waves.iter().map(|one| wave(n, one)).sum())
            .collect();
        let noisy: Vec<f64> = motion.iter().map(|x| x + noise * random.normal()).collect();
        [motion, noisy].map(|x| x.windows(3).map(|x| x[0] - 2.0 * x[1] + x[2]).collect())
    }

    fn of_second_differences(frequency: f64) -> f64 {
        (2.0 * (PI * frequency).sin()).powi(4)
    }

    #[test]
    fn noise_begins_where_the_motion_ends() {
        for noise in [1.0, 10.0] {
            let [force, acceleration] = accelerations(noise);
            let square = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64;
            // Of positions with a deviation of 1 a second difference has the variance 1 + 4 + 1.
            let share = 6.0 * noise * noise / square(&acceleration);
            let driven = incoherent_band(&acceleration, &force);
            let free = noise_band(&acceleration, of_second_differences);
            for band in [driven, free].map(Option::unwrap) {
                assert!(band.from > 0.017 && band.from < 0.025, "{band:?}");
                assert!(
                    (band.share - share).abs() < 0.1 * share,
                    "{band:?}, {share}"
                );
            }
        }
    }

    /// A swing with a twentieth of its acceleration at three times its frequency.
    #[test]
    fn harmonics_of_a_swing_need_no_higher_cutoff() {
        let mut random = RandomStream::new(7, 2);
        let mut swing = |harmonic: f64| {
            let at = |n: usize, times: f64| (TAU * 0.01 * times * n as f64).sin();
            let x = (0..COUNT)
                .map(|n| at(n, 1.0) + harmonic / 9.0 * at(n, 3.0) + 1e-3 * random.normal());
            let x: Vec<f64> = x.collect();
            let a: Vec<f64> = x.windows(3).map(|x| x[0] - 2.0 * x[1] + x[2]).collect();
            noise_band(&a, of_second_differences).unwrap().from
        };
        let (small, large) = (swing(0.05), swing(0.3));
        assert!((0.02..0.029).contains(&small), "{small}");
        assert!((0.03..0.04).contains(&large), "{large}");
    }

    #[test]
    fn a_series_that_is_all_noise_or_has_none_has_no_such_band() {
        let mut random = RandomStream::new(7, 1);
        let mut white = |_| random.normal();
        let [a, b] = [(); 2].map(|()| (0..COUNT).map(&mut white).collect::<Vec<f64>>());
        assert_eq!(noise_band(&a, |_| 1.0), None);
        assert_eq!(incoherent_band(&a, &b), None);
        assert_eq!(incoherent_band(&a, &a), None);
        for nothing in [&[0.0; COUNT][..], &[f64::NAN; COUNT], &a[..20], &[]] {
            assert_eq!(noise_band(nothing, |_| 1.0), None);
            assert_eq!(incoherent_band(nothing, nothing), None);
            assert_eq!(incoherent_band(nothing, &a), None);
        }
    }
}
