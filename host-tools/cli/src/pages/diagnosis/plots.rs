//! Plots of the axis with the largest error: measured against predicted, and what is left.

use super::focus::{self, Focus};
use super::{Source, words};
use softdock_physics::model::prediction::Prediction;
use softdock_report::{Band, Hue, Page, Plot, Series, number};
use std::ops::Range;

/// Colour of what was measured.
const MEASURED: Hue = Hue::Blue;
/// Colour of the model as it was given.
const BEFORE: Hue = Hue::Vermilion;
/// Colour of the model with the named effects.
const AFTER: Hue = Hue::Green;
/// The remaining error gets a plot of its own if it is smaller than the first error by this factor.
const MUCH_SMALLER: f64 = 3.0;
/// If there are more windows than this, they are not shaded: they could not be told apart.
const MOST_BANDS: usize = 80;
/// With more regimes than this, windows are not named: their tints would repeat.
const MOST_REGIMES: usize = 4;
/// Half height of the noise band in standard deviations: 95 % of normal noise.
const BAND_SIGMA: f64 = 2.0;

impl Source<'_> {
    /// The section about one axis.
    pub(super) fn plots(&self, page: &mut Page, focus: &Focus) -> anyhow::Result<()> {
        page.section(&format!(
            "Where the error is {}: {}",
            if focus.is_rest { "left" } else { "largest" },
            words::signal(focus.channel, focus.axis)
        ));
        page.paragraph(&self.caption(focus));
        let all = 0..self.before.time_s.len();
        if let Some(cycles) = &focus.close_up {
            page.plot(&self.overlay(focus, cycles, "around the largest error"))?;
            page.plot(&self.residuals(focus, cycles, "around the largest error"))?;
        }
        page.plot(&self.overlay(focus, &all, "whole recording"))?;
        page.plot(&self.residuals(focus, &all, "whole recording"))?;
        if let Some(after) = self.after
            && peak(self.before, focus) > MUCH_SMALLER * peak(after, focus)
        {
            let mut plot = self.in_sigma(focus, &all, "What remains, whole recording");
            plot.series = vec![
                self.residual(after, focus, &all, "with the effects")
                    .colored(AFTER),
            ];
            page.plot(&plot)?;
        }
        Ok(())
    }

    fn caption(&self, focus: &Focus) -> String {
        let all = 0..self.before.time_s.len();
        let of = |prediction| {
            let rms = focus::rms(prediction, focus.channel, focus.axis, all.clone());
            number::significant(rms.unwrap_or(f64::NAN), 3)
        };
        let before = of(self.before);
        let mut text = match self.after {
            Some(after) => format!(
                "RMS error {before} σᵣ with the model as given, {} σᵣ with the named effects; σᵣ is the standard \
                 deviation to expect of measured minus predicted, 1 is a perfect model.",
                of(after)
            ),
            None => format!(
                "RMS error {before} σᵣ; σᵣ is the standard deviation to expect of measured minus predicted, 1 is a \
                 perfect model."
            ),
        };
        if !self.bands(focus, &all).is_empty() {
            text += " Shaded: where the error shows.";
        }
        text
    }

    fn overlay(&self, focus: &Focus, cycles: &Range<usize>, title: &str) -> Plot {
        let i = focus.axis.index();
        let label = format!(
            "{} [{}]",
            words::signal(focus.channel, focus.axis),
            focus.channel.unit(focus.axis)
        );
        let mut plot = Plot::new(
            format!("Measured and predicted, {title}"),
            "time [s]",
            label,
        );
        let measured = &self.before.channel(focus.channel).measured;
        let measured = |n: usize| measured.get(n).map_or(f64::NAN, |v| v[i]);
        plot.series =
            vec![Series::line("measured", self.points(cycles, measured)).colored(MEASURED)];
        for (prediction, name, hue) in self.predictions() {
            let predicted = &prediction.channel(focus.channel).predicted;
            let value = |n: usize| {
                let six = predicted.get(n).copied().flatten();
                six.map_or(f64::NAN, |v| v[i])
            };
            let series = Series::dashed(format!("predicted, {name}"), self.points(cycles, value));
            plot.series.push(series.colored(hue));
        }
        plot.shaded = self.bands(focus, cycles);
        plot
    }

    fn residuals(&self, focus: &Focus, cycles: &Range<usize>, title: &str) -> Plot {
        let title = format!("Measured minus predicted, {title}");
        let mut plot = self.in_sigma(focus, cycles, &title);
        for (prediction, name, hue) in self.predictions() {
            let series = self.residual(prediction, focus, cycles, name);
            plot.series.push(series.colored(hue));
        }
        plot
    }

    /// An empty plot of errors in units of the noise, with the noise's band.
    fn in_sigma(&self, focus: &Focus, cycles: &Range<usize>, title: &str) -> Plot {
        let mut plot = Plot::new(title, "time [s]", "error [σᵣ]");
        plot.height = 215;
        plot.shaded = self.bands(focus, cycles);
        plot.corridor = Some(Band {
            from: -BAND_SIGMA,
            to: BAND_SIGMA,
            label: "±2 σᵣ".to_owned(),
            hue: None,
        });
        plot
    }

    fn residual(
        &self,
        prediction: &Prediction,
        focus: &Focus,
        cycles: &Range<usize>,
        name: &str,
    ) -> Series {
        let error = |n| focus::relative(prediction, focus.channel, focus.axis, n);
        Series::line(name, self.points(cycles, |n| error(n).unwrap_or(f64::NAN)))
    }

    /// The predictions to draw, each with its label and colour.
    fn predictions(&self) -> Vec<(&Prediction, &'static str, Hue)> {
        match self.after {
            Some(after) => vec![
                (self.before, "model as given", BEFORE),
                (after, "with the effects", AFTER),
            ],
            None => vec![(self.before, "model as given", BEFORE)],
        }
    }

    fn points(&self, cycles: &Range<usize>, value: impl Fn(usize) -> f64) -> Vec<(f64, f64)> {
        let time = &self.before.time_s;
        let known = cycles.clone().filter_map(|n| Some((n, *time.get(n)?)));
        known.map(|(n, t)| (t, value(n))).collect()
    }

    /// Windows within these cycles in which this axis fails.
    fn bands(&self, focus: &Focus, cycles: &Range<usize>) -> Vec<Band> {
        let time = self.before.time_s.get(cycles.clone()).unwrap_or_default();
        let (Some(first), Some(last)) = (time.first(), time.last()) else {
            return Vec::new();
        };
        let here = self.diagnosis.regions.iter().filter(|region| {
            (region.channel, region.axis) == (focus.channel, focus.axis)
                && region.from_s <= *last
                && region.to_s >= *first
        });
        let mut bands: Vec<Band> = here
            .map(|region| Band {
                from: region.from_s,
                to: region.to_s,
                label: region.regime.clone(),
                hue: None,
            })
            .collect();
        let mut regimes: Vec<&str> = bands.iter().map(|band| band.label.as_str()).collect();
        regimes.sort_unstable();
        regimes.dedup();
        if regimes.len() > MOST_REGIMES {
            for band in &mut bands {
                "error".clone_into(&mut band.label);
            }
        }
        if bands.len() > MOST_BANDS {
            bands.clear();
        }
        bands
    }
}

/// Largest error relative to the noise.
fn peak(prediction: &Prediction, focus: &Focus) -> f64 {
    (0..prediction.time_s.len())
        .filter_map(|n| focus::relative(prediction, focus.channel, focus.axis, n))
        .fold(0.0, |peak, error| peak.max(error.abs()))
}
