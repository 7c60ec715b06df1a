//! The comparison as a page: the sentence, the plots that matter, the tables.

mod evidence;

use softdock_analysis::compare::{Comparison, Phase, Window, windows};
use softdock_physics::model::{Axis, Channel};
use softdock_report::{Band, Bar, BarChart, Format, Hue, Page, Plot, Series};
use std::ops::Range;

/// Number of axes that are drawn: those of the worst failures, or if nothing fails those of the largest errors.
const DRAWN: usize = 3;
/// Time around the worst window in its close-up, s.
const CLOSE_UP_MARGIN_S: f64 = 0.15;
/// Longest close-up, s.
const CLOSE_UP_S: f64 = 2.0;
/// If there are more windows than this, they are not shaded: they could not be told apart.
const MOST_BANDS: usize = 80;

/// The report.
///
/// # Errors
///
/// If a plot cannot be drawn.
pub fn page(comparison: &Comparison) -> anyhow::Result<Page> {
    Source { comparison }.page()
}

/// What is drawn.
struct Source<'a> {
    comparison: &'a Comparison,
}

impl Source<'_> {
    fn page(&self) -> anyhow::Result<Page> {
        let mut page = Page::new("Model against recording");
        page.headline(&self.comparison.sentence);
        let forward = self.comparison.free_simulation.map(|free| free.words());
        for note in forward.iter().chain(&self.comparison.notes) {
            page.paragraph(note);
        }
        page.section("Where the error stands");
        if !self.comparison.at_noise {
            page.bars(&self.shares())?;
        }
        page.table(&self.comparison.phase_table());
        for (channel, axis, worst) in self.drawn() {
            page.section(&format!("{} {axis}", channel.name().replace('_', " ")));
            page.columns(&self.evidence(channel, axis))?;
            if let Some(worst) = worst {
                let cycles = self.close_up(&worst);
                page.plot(&self.overlay(channel, axis, &cycles, "where the error is largest"))?;
                page.plot(&self.residual(channel, axis, &cycles, "where it is largest"))?;
            }
            let all = 0..self.comparison.cycles;
            page.plot(&self.overlay(channel, axis, &all, "whole recording"))?;
            page.plot(&self.residual(channel, axis, &all, "whole recording"))?;
        }
        page.section("Error of each channel and axis");
        page.table(&self.comparison.channel_table());
        page.section("What explains each error");
        page.table(&self.comparison.regime_table());
        page.section("Is the rest noise?");
        page.table(&self.comparison.test_table());
        page.details("Model", &self.comparison.detail.model_toml);
        page.details(
            "Settings of the board",
            &self.comparison.detail.settings_toml,
        );
        if let Some(scenario) = &self.comparison.detail.scenario_toml {
            page.details("Scenario of the simulated rig", scenario);
        }
        page.identity(&self.comparison.detail.identity);
        Ok(page)
    }

    /// Channels and axes to draw, with the window to look at.
    fn drawn(&self) -> Vec<(Channel, Axis, Option<Window>)> {
        let failing = self.comparison.failures.iter().take(DRAWN);
        let mut drawn: Vec<_> = failing
            .map(|f| (f.channel, f.axis, Some(f.worst)))
            .collect();
        if drawn.is_empty() {
            let mut errors: Vec<_> = self.comparison.channels.iter().collect();
            errors.sort_by(|a, b| b.rms_expected_sigma.total_cmp(&a.rms_expected_sigma));
            drawn.extend(errors.iter().take(DRAWN).map(|e| (e.name, e.axis, None)));
        }
        drawn
    }

    fn close_up(&self, worst: &Window) -> Range<usize> {
        let from_s = worst.from_s - CLOSE_UP_MARGIN_S;
        let to_s = (worst.to_s + CLOSE_UP_MARGIN_S).min(from_s + CLOSE_UP_S);
        let time = &self.comparison.detail.prediction.time_s;
        time.partition_point(|t| *t < from_s)..time.partition_point(|t| *t <= to_s)
    }

    fn shares(&self) -> BarChart {
        let mut chart = BarChart::new(
            "Phases of the test",
            "share of the squared error beyond the noise",
            Format::Percent(1),
        );
        chart.bars = self
            .comparison
            .phases
            .iter()
            .filter(|phase| phase.cycles > 0)
            .map(|phase| {
                let bar = Bar::new(phase.name.words(), phase.share_beyond_noise);
                bar.colored(hue(phase.name))
            })
            .collect();
        chart
    }

    fn overlay(&self, channel: Channel, axis: Axis, cycles: &Range<usize>, title: &str) -> Plot {
        let values = self.comparison.detail.prediction.channel(channel);
        let i = axis.index();
        let measured = |n: usize| values.measured.get(n).map_or(f64::NAN, |v| v[i]);
        let predicted = |n: usize| {
            values
                .predicted
                .get(n)
                .copied()
                .flatten()
                .map_or(f64::NAN, |v| v[i])
        };
        let mut plot = self.plot(
            channel,
            axis,
            cycles,
            &format!("Measured and predicted, {title}"),
        );
        plot.series = vec![
            Series::line("measured", self.points(cycles, measured)),
            Series::dashed("predicted", self.points(cycles, predicted)),
        ];
        plot
    }

    fn residual(&self, channel: Channel, axis: Axis, cycles: &Range<usize>, title: &str) -> Plot {
        let values = self.comparison.detail.prediction.channel(channel);
        let mut plot = self.plot(
            channel,
            axis,
            cycles,
            &format!("Measured minus predicted, {title}"),
        );
        let error = |n| values.residual(n, axis).unwrap_or(f64::NAN);
        let noise = |sign: f64| move |n| 2.0 * sign * values.expected_sigma(n, axis);
        plot.series = vec![
            Series::line("error", self.points(cycles, error)),
            Series::dashed(
                "±2 σ of the expected noise",
                self.points(cycles, noise(1.0)),
            ),
        ];
        let mut lower = Series::dashed("", self.points(cycles, noise(-1.0)));
        lower.color = Some(softdock_report::Hue::of_series(1));
        plot.series.push(lower);
        plot
    }

    fn plot(&self, channel: Channel, axis: Axis, cycles: &Range<usize>, title: &str) -> Plot {
        let quantity = channel.name().replace('_', " ");
        let unit = channel.unit(axis);
        let mut plot = Plot::new(title, "time [s]", format!("{quantity} {axis} [{unit}]"));
        plot.shaded = self.bands(cycles);
        plot
    }

    fn points(&self, cycles: &Range<usize>, value: impl Fn(usize) -> f64) -> Vec<(f64, f64)> {
        let time = &self.comparison.detail.prediction.time_s;
        let known = cycles.clone().filter_map(|n| Some((n, *time.get(n)?)));
        known.map(|(n, t)| (t, value(n))).collect()
    }

    /// Shaded windows: the phases other than free flight within these cycles.
    fn bands(&self, cycles: &Range<usize>) -> Vec<Band> {
        let (time_s, cycle_s) = (
            &self.comparison.detail.prediction.time_s,
            self.comparison.detail.prediction.cycle_s,
        );
        let mut bands = Vec::new();
        for phase in Phase::ALL.into_iter().filter(|p| *p != Phase::FreeFlight) {
            for part in windows(
                &self.comparison.detail.prediction,
                &self.comparison.detail.phases,
                |p| p == phase,
            ) {
                let (from, to) = (part.start.max(cycles.start), part.end.min(cycles.end));
                if from < to {
                    bands.push(Band {
                        from: time_s[from],
                        to: time_s[to - 1] + cycle_s,
                        label: phase.words(),
                        hue: Some(hue(phase)),
                    });
                }
            }
        }
        if bands.len() > MOST_BANDS {
            bands.clear();
        }
        bands
    }
}

/// The colour of a phase, the same on every page and in the workbench (its `app.css`).
fn hue(phase: Phase) -> Hue {
    match phase {
        Phase::FreeFlight => Hue::Grey,
        Phase::FirstContact => Hue::Amber,
        Phase::TurningPoint => Hue::Blue,
        Phase::ZeroCrossing => Hue::Purple,
        Phase::Rebound => Hue::Green,
        Phase::FurtherContact => Hue::Vermilion,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_phase_has_the_colour_that_it_has_in_the_workbench() {
        let style = include_str!("../../../../workbench/src/assets/app.css");
        for phase in Phase::ALL {
            let name = serde_json::to_string(&phase).unwrap();
            let colour = format!("{:?}", hue(phase)).to_lowercase();
            let said = format!("--phase-{}: var(--{colour})", name.trim_matches('"'));
            assert!(style.contains(&said), "{said}");
        }
    }
}
