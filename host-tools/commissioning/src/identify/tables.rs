//! An identification as a table.

use super::Identification;
use super::outcome::{AxisActuator, Estimate};
use softdock_report::{Cell, Column, Table};

/// Digits of an interval's width.
const DIGITS: usize = 2;
impl Identification {
    /// All axes in a table.
    pub fn table(&self) -> Table {
        let mut table = Table::new(vec![
            Column::text("Axis"),
            Column::text("Structure"),
            Column::number("Mean delay", "ms"),
            Column::number("Delay", "ms"),
            Column::number("Lag", "ms"),
            Column::text("Servo"),
            Column::number("Pause", "ms"),
            Column::number("Left, rms", "µm or µrad"),
        ]);
        for axis in &self.axes {
            table.push(vec![
                Cell::text(axis.axis.to_string()),
                Cell::text(&axis.structure),
                in_ms(Some(&axis.mean_delay_s)),
                in_ms(Some(&axis.delay_s)),
                in_ms(Some(&axis.lag_s)),
                servo(axis),
                in_ms(axis.pause_s.as_ref()),
                Cell::number(axis.residual_rms * 1e6, 3),
            ]);
        }
        table
    }
}

fn in_ms(estimate: Option<&Estimate>) -> Cell {
    match estimate {
        Some(Estimate {
            value,
            low,
            high: Some(high),
        }) => Cell::text(format!(
            "{:.2} {}",
            value * 1e3,
            softdock_report::number::interval(low * 1e3, high * 1e3, DIGITS)
        )),
        Some(estimate) => Cell::text(estimate.in_ms()),
        None => Cell::text("not tried"),
    }
}

fn servo(axis: &AxisActuator) -> Cell {
    match (&axis.servo_hz, &axis.servo_damping) {
        (Some(hz), Some(damping)) => {
            Cell::text(format!("{:.2} Hz, damping {:.2}", hz.value, damping.value))
        }
        _ => Cell::text("none"),
    }
}
