//! The report of an identification.

use anyhow::Result;
use softdock_actuator::{Reading, Timing, simulate};
use softdock_commissioning::identify::{AxisActuator, Identification};
use softdock_io::identity;
use softdock_report::{Mark, Page, Plot, Series, Style};

/// Length of the step response that is drawn, s.
const STEP_RESPONSE_S: f64 = 0.25;

/// The report.
///
/// # Errors
///
/// If a plot cannot be drawn.
pub fn page(found: &Identification, origin: &str) -> Result<Page> {
    let mut page = Page::new("How the robot follows");
    page.verdict(Mark::Good, "identified", &found.sentence());
    page.paragraph(&format!("From {origin}."));
    page.list(&found.notes);
    page.section("All axes");
    page.table(&found.table());
    for axis in &found.axes {
        page.section(&format!("Axis {}", axis.axis));
        page.plot(&measured_and_fitted(axis))?;
        page.columns(&[left(axis), step_response(axis, found.cycle_s)])?;
        if let Some(form) = &axis.pause_form {
            page.paragraph(&format!("Pause: {form}."));
        }
    }
    page.section("Settings");
    page.code(&found.fragment(origin).text());
    page.identity(&identity::text());
    Ok(page)
}

/// Response of the identified axis to a step of the velocity.
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

/// Measured position, and position of the fitted model.
fn measured_and_fitted(axis: &AxisActuator) -> Plot {
    let evidence = &axis.evidence;
    let pairs = evidence.measured.iter().zip(&evidence.residual);
    let fitted: Vec<f64> = pairs.map(|(measured, left)| measured - left).collect();
    let mut plot = Plot::new(
        "Measured and fitted position",
        "time [s]",
        format!("position [{}]", unit(axis)),
    );
    plot.series = vec![
        Series::line("measured", over_time(axis, &evidence.measured)),
        Series::dashed("fitted", over_time(axis, &fitted)),
    ];
    plot
}

fn left(axis: &AxisActuator) -> Plot {
    let mut plot = Plot::new(
        "Measured minus fitted position",
        "time [s]",
        format!("position error [{}]", unit(axis)),
    );
    let points = over_time(axis, &axis.evidence.residual);
    plot.series.push(Series::line("left", points));
    plot
}

fn unit(axis: &AxisActuator) -> &'static str {
    if axis.axis.index() < 3 { "m" } else { "rad" }
}

fn over_time(axis: &AxisActuator, values: &[f64]) -> Vec<(f64, f64)> {
    let times = axis.evidence.time_s.iter().copied();
    times.zip(values.iter().copied()).collect()
}
