//! Bands of frequencies in which an error swings.

use super::{Bin, Dependence, Interval, Quantity, Regime};
use crate::compare::Source;
use crate::compare::series::Series;
use softdock_physics::model::Channel;
use softdock_statistics::{f_p, periodogram, shape_of};

/// Upper edge of the lowest band, Hz; above it bands are half an octave wide.
const LOWEST_HZ: f64 = 0.5;
/// Swinging is said of errors above this frequency, Hz: below, everything on a rig is slow.
const SWINGS_HZ: f64 = 2.0;
/// Half width of the band about the strongest line, as a part of its frequency.
const BAND: f64 = 0.2;
/// An oscillation that the command has as well is the command's own. The band has to hold so many times more of the error than of
/// the command's power.
const COMMANDED: f64 = 4.0;

/// Power spectrum of a series in units of its noise, and that of the noise.
pub struct Spectrum {
    /// Distance of the lines, Hz.
    pub step_hz: f64,
    /// Power of each line; its mean is the variance of the series over that of the noise.
    pub power: Vec<f64>,
    /// Power of the expected noise at each line.
    pub noise: Vec<f64>,
}

impl Spectrum {
    /// Spectrum of a series of cycles.
    pub fn of(series: &Series, cycle_s: f64) -> Self {
        let power = periodogram(&series.relative);
        let count = series.relative.len().max(1) as f64;
        let noise = (1..=power.len())
            .map(|k| shape_of(&series.noise, k as f64 / count))
            .collect();
        Self {
            step_hz: 1.0 / (count * cycle_s),
            power,
            noise,
        }
    }

    fn hz(&self, line: usize) -> f64 {
        (line + 1) as f64 * self.step_hz
    }

    /// Lines from one frequency up to another.
    fn lines(&self, from_hz: f64, to_hz: f64) -> std::ops::Range<usize> {
        let line = |hz: f64| ((hz / self.step_hz).ceil() as usize).saturating_sub(1);
        let end = line(to_hz).min(self.power.len());
        line(from_hz).min(end)..end
    }

    /// Sum of what exceeds the noise.
    fn excess(&self, lines: std::ops::Range<usize>) -> f64 {
        lines.map(|k| self.power[k] - self.noise[k]).sum()
    }
}

/// The error by bands of frequencies, with the score of the band about its strongest line. None if there is no line above
/// [`SWINGS_HZ`].
pub(super) fn of(
    source: &Source<'_>,
    series: &Series,
    excess: f64,
    level: f64,
) -> Option<(f64, Regime)> {
    let cycle_s = source.signals.cycle_s;
    let spectrum = Spectrum::of(series, cycle_s);
    let lines = spectrum.power.len();
    // What exceeds the noise, with a constant offset, in the unit of a sum over all lines.
    let (_, count) = series.squares();
    let all = excess * lines as f64 / count.max(1) as f64;
    let swinging = spectrum.lines(SWINGS_HZ, f64::INFINITY);
    let strongest = swinging.max_by(|a, b| spectrum.power[*a].total_cmp(&spectrum.power[*b]))?;
    let middle = spectrum.hz(strongest);
    let band = (middle * (1.0 - BAND), middle * (1.0 + BAND));
    let inside = spectrum.lines(band.0, band.1);
    let share = (spectrum.excess(inside.clone()) / all).clamp(0.0, 1.0);
    let commanded = commanded_share(source, series, &inside);
    let score = if commanded * COMMANDED < share {
        share
    } else {
        0.0
    };
    let p = against_rest(&spectrum, &inside);
    let regime = Regime {
        channel: series.channel,
        axis: series.axis,
        variable: Quantity::Frequency,
        along: None,
        unit: "Hz",
        in_contact: false,
        absolute: false,
        dependence: Dependence::Band,
        share: score,
        offset_share: 0.0,
        offset: 0.0,
        at: Some(Interval {
            from: band.0,
            to: band.1,
            time_share: 1.0,
        }),
        p,
        significant: p < level && score > 0.0,
        bins: bands(&spectrum, all),
    };
    Some((score - 0.02, regime))
}

/// Share of the sent velocity's power in these lines.
fn commanded_share(source: &Source<'_>, series: &Series, lines: &std::ops::Range<usize>) -> f64 {
    let axes = source.prediction.judged(Channel::ExecutedVelocity).iter();
    let i = series.axis.index();
    let axis = axes.map(|a| a.index()).find(|a| *a == i).unwrap_or(0);
    let cycles = source.signals.cycles.iter();
    let sent: Vec<f64> = cycles.map(|c| c.trace.sent_velocity[axis]).collect();
    let power = periodogram(&sent);
    let all: f64 = power.iter().sum();
    let inside: f64 = power.get(lines.clone()).unwrap_or_default().iter().sum();
    if all > 0.0 { inside / all } else { 0.0 }
}

/// p-value of a band being so much stronger than the other lines above [`SWINGS_HZ`].
fn against_rest(spectrum: &Spectrum, band: &std::ops::Range<usize>) -> f64 {
    let swinging = spectrum.lines(SWINGS_HZ, f64::INFINITY);
    let mean = |lines: &dyn Fn(usize) -> bool| {
        let inside: Vec<usize> = swinging.clone().filter(|k| lines(*k)).collect();
        let sum: f64 = inside
            .iter()
            .map(|k| spectrum.power[*k] / spectrum.noise[*k].max(0.1))
            .sum();
        (sum / inside.len().max(1) as f64, 2.0 * inside.len() as f64)
    };
    let (inside, a) = mean(&|k| band.contains(&k));
    let (outside, b) = mean(&|k| !band.contains(&k));
    f_p(inside / outside, a, b)
}

fn bands(spectrum: &Spectrum, all: f64) -> Vec<Bin> {
    let nyquist = spectrum.hz(spectrum.power.len().saturating_sub(1));
    let mut edges = vec![0.0];
    let mut edge = LOWEST_HZ;
    while edge < nyquist {
        edges.push(edge);
        edge *= std::f64::consts::SQRT_2;
    }
    edges.push(nyquist * (1.0 + 1e-9));
    edges
        .windows(2)
        .map(|e| {
            let lines = spectrum.lines(e[0], e[1]);
            let power: f64 = spectrum.power[lines.clone()].iter().sum();
            let noise: f64 = spectrum.noise[lines.clone()].iter().sum();
            Bin {
                from: e[0],
                to: e[1],
                centre: 0.5 * (e[0] + e[1]),
                cycles: 0,
                mean: 0.0,
                spread: 0.0,
                rms_sigma: (power / noise.max(f64::MIN_POSITIVE)).max(0.0).sqrt(),
                share: (spectrum.excess(lines) / all).clamp(0.0, 1.0),
            }
        })
        .collect()
}
