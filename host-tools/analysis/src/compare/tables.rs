//! The comparison as tables, for the terminal and for the report.

use super::series::ROUND_OFF_SIGMA;
use super::{ChannelError, Comparison, Failure};
use softdock_physics::model::{Axis, Channel};
use softdock_report::{Cell, Column, Mark, Table, number};

/// Regimes of an axis that are listed.
const LISTED: usize = 4;

impl Comparison {
    /// Errors per channel and axis, and per phase of the test.
    pub fn tables(&self) -> Vec<Table> {
        vec![self.channel_table(), self.phase_table()]
    }

    /// The error of each channel and axis.
    pub fn channel_table(&self) -> Table {
        let mut table = Table::new(vec![
            Column::text("Channel"),
            Column::text("Axis"),
            Column::number("RMS error", ""),
            Column::text("Unit"),
            Column::number("RMS error", "σ"),
            Column::number("Beyond noise", ""),
        ]);
        // Errors of values that are computed twice from the same numbers are round-off, and not shown.
        let is_noisy = |error: &&ChannelError| error.rms_sigma >= ROUND_OFF_SIGMA;
        for error in self.channels.iter().filter(is_noisy) {
            let failure = self
                .failures
                .iter()
                .find(|f| f.channel == error.name && f.axis == error.axis);
            let mark = if failure.is_some() {
                Mark::Bad
            } else {
                Mark::Good
            };
            table.push(vec![
                Cell::text(error.name.to_string()),
                Cell::text(error.axis.to_string()),
                Cell::number(error.rms, 3),
                Cell::text(error.unit),
                Cell::number(error.rms_expected_sigma, 3).marked(mark),
                Cell::percent(failure.map_or(0.0, |f| f.share)),
            ]);
        }
        table.explained(
            "✓ at the noise, ✗ the model fails; what was not measured, or was computed from itself, is left out; σ is the noise to expect: 1 if the model is right",
        )
    }

    /// How the error is spread over the phases.
    pub fn phase_table(&self) -> Table {
        let mut table = Table::new(vec![
            Column::text("Phase"),
            Column::number("Cycles", ""),
            Column::number("Windows", ""),
            Column::text("First from … to [s]"),
            Column::number("RMS error", "σ"),
            Column::number("Share of error", ""),
            Column::number("Share beyond noise", ""),
        ]);
        for phase in self.phases.iter().filter(|phase| phase.cycles > 0) {
            let first = phase.windows.first().map_or(String::new(), |w| {
                format!("{:.3} … {:.3}", w.from_s, w.to_s)
            });
            table.push(vec![
                Cell::text(phase.name.words()),
                Cell::text(phase.cycles.to_string()),
                Cell::text(phase.windows.len().to_string()),
                Cell::text(first),
                Cell::number(phase.rms_sigma, 3),
                Cell::percent(phase.share),
                Cell::percent(phase.share_beyond_noise),
            ]);
        }
        table
    }

    /// The best regimes of each axis in which the model fails.
    pub fn regime_table(&self) -> Table {
        let mut table = Table::new(vec![
            Column::text("Error of"),
            Column::text("Regime"),
            Column::number("Share beyond noise", ""),
            Column::number("Probability by chance", ""),
            Column::text("How"),
        ]);
        for failure in &self.failures {
            let of = |r: &&super::Regime| is_of(failure, r.channel, r.axis);
            for regime in self.regimes.iter().filter(of).take(LISTED) {
                let share = Cell::percent(regime.share);
                let share = if regime.explains() {
                    share.marked(Mark::Good)
                } else {
                    share
                };
                table.push(vec![
                    Cell::text(format!("{} {}", regime.channel, regime.axis)),
                    Cell::text(regime.label()),
                    share,
                    Cell::text(probability(regime.p)),
                    Cell::text(regime.short()),
                ]);
            }
        }
        table
    }

    /// Noise, whiteness and independence of each axis.
    pub fn test_table(&self) -> Table {
        let mut table = Table::new(vec![
            Column::text("Error of"),
            Column::number("Measured noise", "σₙ"),
            Column::number("Whiteness (25)", ""),
            Column::text("White"),
            Column::text("Depends on"),
        ]);
        for test in &self.tests {
            let level = self.noise.iter();
            let mut level = level.filter(|n| n.channel == test.channel && n.axis == test.axis);
            let white = test.whiteness.white;
            let inputs: Vec<&str> = test
                .independence
                .iter()
                .filter(|input| !input.independent)
                .map(|input| input.input.words())
                .collect();
            table.push(vec![
                Cell::text(format!("{} {}", test.channel, test.axis)),
                Cell::number(level.next().map_or(f64::NAN, |n| n.ratio), 2),
                Cell::number(test.whiteness.statistic, 3),
                Cell::text(if white { "yes" } else { "no" }).marked(if white {
                    Mark::Good
                } else {
                    Mark::Bad
                }),
                Cell::text(inputs.join(", ")),
            ]);
        }
        table
    }
}

/// A probability; below what sums of squares in floating point can tell, only that it is there.
fn probability(p: f64) -> String {
    /// A thousand times the round-off of a number near 1.
    const SMALLEST: f64 = 1e-12;
    match p < SMALLEST {
        true => format!("< {SMALLEST:e}"),
        false => number::significant(p, 2),
    }
}

fn is_of(failure: &Failure, channel: Channel, axis: Axis) -> bool {
    failure.channel == channel && failure.axis == axis
}
