//! The report of an identification, and its table for the terminal.

use super::Identification;
use super::outcome::{AxisActuator, Estimate};
use crate::identity;
use crate::model::actuator::{Reading, Timing, simulate};
use anyhow::Result;
use softdock_report::{Cell, Column, Mark, Page, Plot, Series, Style, Table};

/// Digits of an interval's width.
const DIGITS: usize = 2;
/// Length of the step response that is drawn, s.
const STEP_RESPONSE_S: f64 = 0.25;

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

    /// The report.
    ///
    /// # Errors
    ///
    /// If a plot cannot be drawn.
    pub fn page(&self, origin: &str) -> Result<Page> {
        let mut page = Page::new("How the robot follows");
        page.verdict(Mark::Good, "identified", &self.sentence());
        page.paragraph(&format!("From {origin}."));
        page.list(&self.notes);
        page.section("All axes");
        page.table(&self.table());
        for axis in &self.axes {
            page.section(&format!("Axis {}", axis.axis));
            page.columns(&[step_response(axis, self.cycle_s), left(axis)])?;
            if let Some(form) = &axis.pause_form {
                page.paragraph(&format!("Pause: {form}."));
            }
        }
        page.section("Settings");
        page.code(&self.fragment(origin).text());
        page.identity(&identity::text());
        Ok(page)
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

/// What the axis makes of a step of the velocity.
fn step_response(axis: &AxisActuator, cycle_s: f64) -> Plot {
    let cycles = (STEP_RESPONSE_S / cycle_s).ceil() as usize;
    let sent = vec![axis.tried_velocity; cycles];
    let timing = Timing::uniform(cycle_s);
    let executed = simulate(&axis.evidence.chain, &sent, &timing, Reading::AtEnd);
    let points = |values: &[f64]| {
        let scale = 1.0 / axis.tried_velocity;
        let points = values.iter().enumerate();
        points
            .map(|(n, v)| (n as f64 * cycle_s, v * scale))
            .collect()
    };
    let mut plot = Plot::new(
        "Response to a step of the fastest velocity",
        "time [s]",
        "executed / sent",
    );
    plot.series = vec![
        Series::new("sent", Style::Step, points(&sent)),
        Series::line("executed", points(&executed)),
    ];
    plot
}

fn left(axis: &AxisActuator) -> Plot {
    let unit = if axis.axis.index() < 3 { "m" } else { "rad" };
    let mut plot = Plot::new(
        "Measured minus simulated place",
        "time [s]",
        format!("place left [{unit}]"),
    );
    let evidence = &axis.evidence;
    let points = evidence.time_s.iter().copied();
    plot.series.push(Series::line(
        "left",
        points.zip(evidence.residual.iter().copied()).collect(),
    ));
    plot
}
