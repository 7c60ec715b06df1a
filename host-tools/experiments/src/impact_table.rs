//! Cells of an impact, for all tables.

use super::impacts::Impact;
use softdock_report::{Cell, Column, Mark};

/// Limits of a good impact, as in `bench delay`: deviation of the restitution from the analytic one, and share of the
/// rebound's momentum that the law may add.
const GOOD: f64 = 0.02;
/// Meaning of the marks.
pub const LEGEND: &str = "✓ restitution within 0.02 of the analytic one, ✗ not, or more than 2 % of the rebound was added by the law";

/// Columns for [`cells`].
pub fn columns() -> Vec<Column> {
    vec![
        Column::number("speed in", "mm/s"),
        Column::number("speed out", "mm/s"),
        Column::number("restitution", ""),
        Column::number("analytic", ""),
        Column::number("energy error", ""),
        Column::number("peak force error", ""),
        Column::number("contact time error", ""),
        Column::number("impulse not measured", ""),
    ]
}

/// The cells if there was no impact.
pub fn no_impact() -> Vec<Cell> {
    columns().iter().map(|_| Cell::text("-")).collect()
}

/// The cells of one impact.
pub fn cells(impact: &Impact) -> Vec<Cell> {
    let good = (impact.restitution - impact.expected_restitution).abs() <= GOOD;
    let added = if impact.impulse_unaccounted.abs() <= GOOD {
        Mark::Neutral
    } else {
        Mark::Bad
    };
    vec![
        Cell::number(impact.speed_in_mm_s, 3),
        Cell::number(impact.speed_out_mm_s, 3),
        Cell::number(impact.restitution, 3).marked(if good { Mark::Good } else { Mark::Bad }),
        Cell::number(impact.expected_restitution, 3),
        Cell::percent(impact.energy_error),
        Cell::percent(impact.peak_force_error),
        Cell::percent(impact.contact_time_error),
        Cell::percent(impact.impulse_unaccounted).marked(added),
    ]
}
