//! Where the error shows, and how quiet the log is.

use super::{Source, focus, words};
use softdock_analysis::diagnose::{Region, Verdict};
use softdock_physics::model::prediction::Prediction;
use softdock_report::{Cell, Column, Mark, Page, Table};

/// Number of windows that are listed; the number of the others is printed.
const LISTED: usize = 30;
/// Noise this many times that of the data sheet is marked: no fit mends it.
const NOISY: f64 = 1.5;

impl Source<'_> {
    /// The windows in which the error shows.
    pub(super) fn regions(&self, page: &mut Page) {
        let regions = &self.diagnosis.regions;
        if regions.is_empty() {
            return;
        }
        page.section(match self.diagnosis.verdict {
            Verdict::Unexplained | Verdict::LogsDisagree => "Where the unexplained error shows",
            _ => "Where the error showed",
        });
        page.table(&self.region_table());
        if regions.len() > LISTED {
            page.paragraph(&format!(
                "{} more windows are not listed.",
                regions.len() - LISTED
            ));
        }
    }

    fn region_table(&self) -> Table {
        let mut columns = vec![
            Column::text("Channel"),
            Column::text("Axis"),
            Column::number("From", "s"),
            Column::number("To", "s"),
            Column::number(
                if self.after.is_some() {
                    "Before"
                } else {
                    "RMS"
                },
                "σᵣ",
            ),
        ];
        if self.after.is_some() {
            columns.push(Column::number("After", "σᵣ"));
        }
        columns.push(Column::text("When"));
        let mut table = Table::new(columns);
        for region in self.diagnosis.regions.iter().take(LISTED) {
            let mut row = vec![
                Cell::text(words::channel(region.channel)),
                Cell::text(region.axis.to_string()),
                Cell::text(format!("{:.3}", region.from_s)),
                Cell::text(format!("{:.3}", region.to_s)),
                rms(self.before, region),
            ];
            row.extend(self.after.map(|after| rms(after, region)));
            row.push(Cell::text(&region.regime));
            table.push(row);
        }
        table
    }

    /// The noise that the log shows.
    pub(super) fn noise(&self, page: &mut Page) {
        if self.diagnosis.noise.is_empty() {
            return;
        }
        page.section("Noise floor");
        page.paragraph(
            "Standard deviation of the noise that the log itself shows, against `noise` of the model file.",
        );
        let mut table = Table::new(vec![
            Column::text("Channel"),
            Column::text("Axis"),
            Column::number("Measured", ""),
            Column::number("Data sheet", ""),
            Column::text("Unit"),
            Column::number("Ratio", ""),
        ]);
        for floor in &self.diagnosis.noise {
            let ratio = floor.measured / floor.data_sheet;
            let cell = Cell::number(ratio, 3);
            table.push(vec![
                Cell::text(words::channel(floor.channel)),
                Cell::text(floor.axis.to_string()),
                Cell::number(floor.measured, 3),
                Cell::number(floor.data_sheet, 3),
                Cell::text(floor.channel.unit(floor.axis)),
                if ratio > NOISY {
                    cell.marked(Mark::Bad)
                } else {
                    cell
                },
            ]);
        }
        page.table(&table);
    }
}

fn rms(prediction: &Prediction, region: &Region) -> Cell {
    let cycles = focus::cycles(prediction, region.from_s, region.to_s);
    let rms = focus::rms(prediction, region.channel, region.axis, cycles);
    rms.map_or(Cell::text(""), |rms| Cell::number(rms, 3))
}
