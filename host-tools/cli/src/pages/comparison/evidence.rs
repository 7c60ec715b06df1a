//! Plots that show that an error is systematic: along the regime that explains it, its autocorrelation, and its spectrum.

use super::Source;
use softdock_analysis::compare::Series as ErrorSeries;
use softdock_analysis::compare::Spectrum;
use softdock_analysis::compare::{Dependence, Regime};
use softdock_physics::model::{Axis, Channel};
use softdock_report::{Hue, Plot, Series};
use softdock_statistics::{autocorrelation, whiteness};

/// Longest lag that is drawn, s.
const LAG_S: f64 = 0.4;
/// Half width of a 99 % band in standard deviations.
const TWO_SIDED_99: f64 = 2.576;
/// Points of a drawn spectrum: neighbouring frequencies are averaged.
const POINTS: usize = 150;
/// Lowest level of a drawn spectrum, dB.
const LEAST_DB: f64 = -20.0;

impl Source<'_> {
    /// The plots for one axis.
    pub(super) fn evidence(&self, channel: Channel, axis: Axis) -> Vec<Plot> {
        let mut plots = Vec::new();
        let failure = self.comparison.failures.iter();
        let mut failure = failure.filter(|f| f.channel == channel && f.axis == axis);
        let regime = failure.next().and_then(|f| f.regime.as_ref());
        plots.extend(regime.and_then(along_regime));
        let series = self.comparison.detail.series.iter();
        let mut series = series.filter(|s| s.channel == channel && s.axis == axis);
        if let Some(series) = series.next().filter(|s| s.is_there()) {
            plots.extend(self.correlation(series));
            plots.push(self.spectrum(series));
        }
        plots
    }

    /// Autocorrelation of the error with the 99 % band of white noise.
    fn correlation(&self, series: &ErrorSeries) -> Option<Plot> {
        let cycle_s = self.comparison.detail.prediction.cycle_s;
        let band = whiteness(&series.relative, series.noise.len())?.band * TWO_SIDED_99;
        let lags = (LAG_S / cycle_s) as usize;
        let found = autocorrelation(&series.relative, lags);
        let points = found.iter().enumerate().skip(1);
        let mut plot = Plot::new("Autocorrelation of the error", "lag [s]", "autocorrelation");
        let ends = [cycle_s, lags as f64 * cycle_s];
        plot.series = vec![
            Series::line(
                "error",
                points.map(|(k, r)| (k as f64 * cycle_s, *r)).collect(),
            ),
            limit("99 % of noise", ends.map(|x| (x, band)).to_vec()),
            limit("", ends.map(|x| (x, -band)).to_vec()),
        ];
        plot.y_from_zero = true;
        Some(plot)
    }

    /// Spectrum of the error in relation to that of the noise.
    fn spectrum(&self, series: &ErrorSeries) -> Plot {
        let spectrum = Spectrum::of(series, self.comparison.detail.prediction.cycle_s);
        let width = (spectrum.power.len() / POINTS).max(1);
        let db = |power: &[f64]| {
            let mean = power.iter().sum::<f64>() / power.len().max(1) as f64;
            (10.0 * mean.log10()).max(LEAST_DB)
        };
        let curve = |power: &[f64]| -> Vec<(f64, f64)> {
            let parts = power.chunks(width).enumerate();
            parts
                .map(|(i, part)| {
                    let line = (i * width) as f64 + 0.5 * (part.len() + 1) as f64;
                    (line * spectrum.step_hz, db(part))
                })
                .collect()
        };
        let mut plot = Plot::new(
            "Spectrum of the error over the noise",
            "frequency [Hz]",
            "power over noise [dB]",
        );
        plot.series = vec![
            Series::line("error", curve(&spectrum.power)),
            limit("expected noise", curve(&spectrum.noise)),
        ];
        plot
    }
}

fn limit(name: &str, points: Vec<(f64, f64)>) -> Series {
    Series::dashed(name, points).colored(Hue::of_series(1))
}

/// The error over the quantity that explains it. None if that is a frequency band, which the spectrum shows.
fn along_regime(regime: &Regime) -> Option<Plot> {
    if regime.dependence == Dependence::Band {
        return None;
    }
    let (channel, axis) = (regime.channel, regime.axis);
    let quantity = channel.name().replace('_', " ");
    let unit = channel.unit(axis);
    let bins = || regime.bins.iter().filter(|b| b.cycles > 0);
    let curve = |sign: f64| -> Vec<(f64, f64)> {
        bins()
            .map(|b| (b.centre, b.mean + sign * b.spread))
            .collect()
    };
    let mut plot = Plot::new(
        format!("Mean error of {quantity} {axis} along what explains it"),
        regime.label(),
        format!("error [{unit}]"),
    );
    plot.series = vec![
        Series::line("mean", curve(0.0)),
        limit("± one standard deviation", curve(1.0)),
        limit("", curve(-1.0)),
    ];
    plot.y_from_zero = true;
    Some(plot)
}
