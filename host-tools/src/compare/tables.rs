//! The comparison as tables, for the terminal and for the report.

use super::Comparison;
use crate::report::{Cell, Column, Mark, Table};

/// Errors below this part of the noise are shown as zero.
const ROUND_OFF_SIGMA: f64 = 1e-6;

impl Comparison {
    /// Errors per channel and axis, and per phase of the test.
    pub fn tables(&self) -> Vec<Table> {
        vec![self.channel_table(), self.phase_table()]
    }

    pub(super) fn channel_table(&self) -> Table {
        let mut table = Table::new(vec![
            Column::text("Channel"),
            Column::text("Axis"),
            Column::number("RMS error", ""),
            Column::text("Unit"),
            Column::number("data sheet", "σ"),
            Column::number("expected", "σ"),
            Column::number("Beyond noise", ""),
        ]);
        for error in &self.channels {
            let failure = self
                .failures
                .iter()
                .find(|f| f.channel == error.name && f.axis == error.axis);
            let mark = if failure.is_some() {
                Mark::Bad
            } else {
                Mark::Good
            };
            // What is computed twice from the same numbers differs by round-off: not worth digits.
            let sigma =
                |value: f64| Cell::number(if value < ROUND_OFF_SIGMA { 0.0 } else { value }, 3);
            let rms = if error.rms_sigma < ROUND_OFF_SIGMA {
                0.0
            } else {
                error.rms
            };
            table.push(vec![
                Cell::text(error.name.to_string()),
                Cell::text(error.axis.to_string()),
                Cell::number(rms, 3),
                Cell::text(error.unit),
                sigma(error.rms_sigma),
                sigma(error.rms_expected_sigma).marked(mark),
                Cell::percent(failure.map_or(0.0, |f| f.share)),
            ]);
        }
        table
    }

    pub(super) fn phase_table(&self) -> Table {
        let mut table = Table::new(vec![
            Column::text("Phase"),
            Column::number("Cycles", ""),
            Column::number("Windows", ""),
            Column::text("First from … to [s]"),
            Column::number("RMS error", "σ"),
            Column::number("Share of error", ""),
            Column::number("Share beyond noise", ""),
        ]);
        for phase in &self.phases {
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
}
