//! The report of a calibration.

use anyhow::Result;
use softdock_commissioning::calibrate::{Calibration, Residual, WORST_CONDITION};
use softdock_io::identity;
use softdock_report::{Hue, Interval, Mark, Page, Plot, Series, Style, number};

const AXES: [&str; 3] = ["x", "y", "z"];

/// The report.
///
/// # Errors
///
/// If a plot cannot be drawn.
pub fn page(found: &Calibration, origin: &str) -> Result<Page> {
    let mut page = Page::new("Calibration of the sensor");
    let (mark, badge) = match found.left_out.len() {
        0 => (Mark::Good, "calibrated".to_owned()),
        n => (Mark::Neutral, format!("calibrated, {n} left out")),
    };
    page.verdict(mark, &badge, &found.sentence());
    page.paragraph(&format!(
        "From {origin}: {} used; the condition number of the poses is {}, at most {WORST_CONDITION:.0} is accepted.",
        found.used,
        number::significant(found.condition, 2)
    ));
    page.list(&found.remarks());
    page.section("What was found");
    page.table(&found.table());
    page.paragraph("How well the readings determine each number: 95 % intervals around it.");
    for of_unit in found.rows().chunk_by(|a, b| a.unit == b.unit) {
        let intervals = of_unit.iter().map(|row| Interval {
            label: row.label.clone(),
            value: row.value,
            low: row.low,
            high: row.high,
        });
        let title = common_words(&of_unit[0].label);
        page.intervals_in(title, of_unit[0].unit, &intervals.collect::<Vec<_>>())?;
    }
    page.section("What is left");
    page.table(&found.residual_table());
    page.columns(&plots(found, 0, "force", "N"))?;
    page.columns(&plots(found, 3, "torque", "N·m"))?;
    page.section("Settings");
    page.code(&found.fragment(origin).text());
    page.identity(&identity::text());
    Ok(page)
}

/// Common label of the rows of one unit: the label of the first row without its axis.
fn common_words(label: &str) -> &str {
    label.rsplit_once(' ').map_or(
        label,
        |(words, axis)| if axis.len() <= 2 { words } else { label },
    )
}

/// Residuals of the three axes of force or torque, one plot each.
fn plots(found: &Calibration, first: usize, kind: &str, unit: &str) -> Vec<Plot> {
    let is_pose = found.residuals.iter().all(|r| r.pose.is_some());
    let at = |r: &Residual| match r.pose {
        Some(pose) if is_pose => pose as f64,
        _ => r.time_s,
    };
    let x_label = if is_pose { "pose" } else { "time [s]" };
    AXES.iter()
        .enumerate()
        .map(|(axis, name)| {
            let points = |used: bool| {
                let own = found.residuals.iter().filter(move |r| r.used == used);
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
