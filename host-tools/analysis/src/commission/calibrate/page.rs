//! The report of a calibration, and its tables for the terminal.

use super::Calibration;
use super::outcome::Residual;
use crate::identity;
use anyhow::Result;
use softdock_report::{
    Cell, Column, Interval, IntervalChart, Mark, Page, Plot, Series, Style, Table,
};
use softdock_report::{Hue, number};

/// Significant digits of an interval's width.
const DIGITS: usize = 2;
/// Significant digits of a value.
const VALUE_DIGITS: usize = 5;
const AXES: [&str; 3] = ["x", "y", "z"];

impl Calibration {
    /// What was found, in a sentence.
    pub fn sentence(&self) -> String {
        let [low, high] = self.intervals.mass_kg;
        let [x, y, z] = self.com_m.map(|c| number::fixed(c * 1e3, 1));
        format!(
            "The tool weighs {} kg {} with its centre of mass at ({x}, {y}, {z}) mm from the sensor; \
             {} N and {} N·m rms are left of a reading{}.",
            number::significant(self.mass_kg, 4),
            number::interval(low, high, DIGITS),
            number::significant(self.residual_rms_n, 3),
            number::significant(self.residual_rms_n_m, 3),
            match self.unseen {
                0 => String::new(),
                count => format!(" in {count} poses that the fit has not seen"),
            }
        )
    }

    /// All values with their intervals.
    pub fn table(&self) -> Table {
        let mut table = Table::new(vec![
            Column::text("Quantity"),
            Column::number("Value", ""),
            Column::number("95 % interval", ""),
            Column::text("Unit"),
        ]);
        for row in self.rows() {
            table.push(vec![
                Cell::text(&row.label),
                Cell::number(row.value, VALUE_DIGITS),
                Cell::interval(row.low, row.high, DIGITS),
                Cell::text(row.unit),
            ]);
        }
        table
    }

    /// What is left by axis.
    pub fn residual_table(&self) -> Table {
        let mut table = Table::new(vec![
            Column::text("Axis"),
            Column::number("Force left, rms", "N"),
            Column::number("Torque left, rms", "N·m"),
        ]);
        for (axis, name) in AXES.iter().enumerate() {
            table.push(vec![
                Cell::text(name),
                Cell::number(self.residual_rms_per_axis[axis], 3),
                Cell::number(self.residual_rms_per_axis[axis + 3], 3),
            ]);
        }
        table
    }

    /// Notes and what was left out, in sentences.
    pub fn remarks(&self) -> Vec<String> {
        let left_out = self.left_out.iter().map(|l| l.sentence());
        let age = self.pose_age_s.map(|age_s| {
            format!(
                "The measured pose is {} ms older than the wrench.",
                number::fixed(age_s * 1e3, 1)
            )
        });
        self.notes
            .iter()
            .cloned()
            .chain(left_out)
            .chain(age)
            .collect()
    }

    /// The report.
    ///
    /// # Errors
    ///
    /// If a plot cannot be drawn.
    pub fn page(&self, origin: &str) -> Result<Page> {
        let mut page = Page::new("Calibration of the sensor");
        let (mark, badge) = match self.left_out.len() {
            0 => (Mark::Good, "calibrated".to_owned()),
            n => (Mark::Neutral, format!("calibrated, {n} left out")),
        };
        page.verdict(mark, &badge, &self.sentence());
        page.paragraph(&format!(
            "From {origin}: {} used, condition {}.",
            self.used,
            number::significant(self.condition, 2)
        ));
        page.list(&self.remarks());
        page.section("What was found");
        page.table(&self.table());
        let intervals = self.rows().into_iter().map(|row| Interval {
            label: row.label,
            value: row.value,
            low: row.low,
            high: row.high,
        });
        page.intervals(&IntervalChart::new(
            "How well the readings determine each number (95 % intervals)",
            intervals.collect(),
        ))?;
        page.section("What is left");
        page.table(&self.residual_table());
        page.columns(&self.plots(0, "force", "N"))?;
        page.columns(&self.plots(3, "torque", "N·m"))?;
        page.section("Settings");
        page.code(&self.fragment(origin).text());
        page.identity(&identity::text());
        Ok(page)
    }

    fn rows(&self) -> Vec<Row> {
        let of = &self.intervals;
        let row = |label: String, value: f64, [low, high]: [f64; 2], unit: &'static str| Row {
            label,
            value,
            low,
            high,
            unit,
        };
        let mut rows = vec![row("mass".to_owned(), self.mass_kg, of.mass_kg, "kg")];
        for (k, axis) in AXES.iter().enumerate() {
            let label = format!("centre of mass {axis}");
            rows.push(row(label, self.com_m[k], of.com_m[k], "m"));
        }
        for (k, (part, unit)) in [("force", "N"), ("torque", "N·m")].into_iter().enumerate() {
            for (i, axis) in AXES.iter().enumerate() {
                let at = 3 * k + i;
                let label = format!("zero of {part} {axis}");
                rows.push(row(label, self.bias[at], of.bias[at], unit));
            }
        }
        if let (Some(inertia), Some(intervals)) = (&self.inertia_kg_m2, &of.inertia_kg_m2) {
            for (i, first) in AXES.iter().enumerate() {
                for (k, second) in AXES.iter().enumerate().skip(i) {
                    let label = format!("inertia {first}{second}");
                    rows.push(row(label, inertia[i][k], intervals[i][k], "kg·m²"));
                }
            }
        }
        rows
    }

    /// What is left of the three axes of one kind.
    fn plots(&self, first: usize, kind: &str, unit: &str) -> Vec<Plot> {
        let is_pose = self.residuals.iter().all(|r| r.pose.is_some());
        let at = |r: &Residual| match r.pose {
            Some(pose) if is_pose => pose as f64,
            _ => r.time_s,
        };
        let x_label = if is_pose { "pose" } else { "time [s]" };
        AXES.iter()
            .enumerate()
            .map(|(axis, name)| {
                let points = |used: bool| {
                    let own = self.residuals.iter().filter(move |r| r.used == used);
                    own.map(|r| (at(r), r.wrench[first + axis])).collect()
                };
                let mut plot = Plot::new(
                    format!("{kind} {name}"),
                    x_label,
                    format!("{kind} left [{unit}]"),
                );
                plot.series
                    .push(Series::new("used", Style::Points, points(true)));
                let left_out = Series::new("left out", Style::Points, points(false));
                if !left_out.points.is_empty() {
                    plot.series.push(left_out.colored(Hue::of_series(1)));
                }
                plot
            })
            .collect()
    }
}

/// A number of the answer.
struct Row {
    label: String,
    value: f64,
    low: f64,
    high: f64,
    unit: &'static str,
}
