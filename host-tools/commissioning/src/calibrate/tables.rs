//! A calibration in sentences and tables.

use super::Calibration;
use softdock_report::{Cell, Column, Table, number};

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

    /// All numbers of the answer.
    pub fn rows(&self) -> Vec<Row> {
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
}

/// A number of the answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What it is.
    pub label: String,
    /// Estimate.
    pub value: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Its unit.
    pub unit: &'static str,
}
