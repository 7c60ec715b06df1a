//! Readings of a single row that depart from both neighbours: mostly damaged ones.

use super::Context;
use softdock_app::record::CycleRecord;
use softdock_physics::model::Axis;
use softdock_report::number;

/// A row stands alone if it departs from its neighbours so many times farther than any other row. An impact, even at the sampling
/// rate, has rows of its size beside it, or others like it.
const ALONE: f64 = 10.0;
/// Largest distance between the two neighbours, relative to the departure: the reading has to come back.
const COMES_BACK: f64 = 0.2;
/// Most spikes that are reported: more of them are how the log is.
const MOST: usize = 3;

/// A number of a channel.
type Reading = fn(&CycleRecord, usize) -> f64;

/// Appends a warning for each reading that stands alone.
pub(super) fn check(cycles: &[CycleRecord], context: &Context<'_>, warnings: &mut Vec<String>) {
    let channels: [(&str, Reading, usize); 3] = [
        ("position", |cycle, k| cycle.trace.pose[k], 3),
        (
            "executed velocity",
            |cycle, k| cycle.trace.executed_velocity[k],
            6,
        ),
        ("wrench", |cycle, k| cycle.inputs.sensor.wrench[k], 6),
    ];
    for (what, reading, count) in channels {
        for axis in &Axis::ALL[..count] {
            let values: Vec<f64> = cycles.iter().map(|c| reading(c, axis.index())).collect();
            for row in alone(&values) {
                warnings.push(format!(
                    "{}: {what} {axis} is {} in row {}, between {} and {}: a damaged reading? Empty its cell, and say `incomplete = \
                     \"leave_out\"` in [rows] of the mapping",
                    context.name,
                    rounded(values[row]),
                    row + 1,
                    rounded(values[row - 1]),
                    rounded(values[row + 1]),
                ));
            }
        }
    }
}

fn rounded(value: f64) -> String {
    number::significant(value, 4)
}

/// Places of up to [`MOST`] values that depart [`ALONE`] times as far from both neighbours as any other does.
fn alone(values: &[f64]) -> Vec<usize> {
    let departure = |n: usize| (values[n] - 0.5 * (values[n - 1] + values[n + 1])).abs();
    let comes_back = |n: &usize| (values[n + 1] - values[n - 1]).abs() < COMES_BACK * departure(*n);
    let inside = 1..values.len().saturating_sub(1);
    let mut rows: Vec<usize> = inside.clone().filter(comes_back).collect();
    rows.sort_by(|a, b| departure(*b).total_cmp(&departure(*a)));
    rows.truncate(MOST);
    let stand_alone = |rows: &[usize]| {
        let beside = |n: usize| rows.iter().any(|row| row.abs_diff(n) <= 1);
        let others = inside.clone().filter(|n| !beside(*n)).map(departure);
        let least = rows.last().map_or(0.0, |row| departure(*row));
        others.fold(0.0, f64::max) * ALONE < least
    };
    let count = (1..=rows.len())
        .rev()
        .find(|count| stand_alone(&rows[..*count]));
    rows.truncate(count.unwrap_or(0));
    rows.sort_unstable();
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    fn swing(n: usize) -> f64 {
        (0.2 * n as f64).sin()
    }

    #[test]
    fn a_reading_of_one_row_is_told_from_steps_impacts_and_noise() {
        let log = |of: fn(usize) -> f64| (0..200).map(of).collect::<Vec<_>>();
        assert_eq!(alone(&log(swing)), [0; 0]);
        assert_eq!(alone(&log(|n| if n == 70 { 9.0 } else { swing(n) })), [70]);
        let two = |n: usize| {
            if [20, 71].contains(&n) {
                -9.0
            } else {
                swing(n)
            }
        };
        assert_eq!(alone(&log(two)), [20, 71]);
        assert_eq!(
            alone(&log(|n| if n < 70 { 0.0 } else { 9.0 })),
            [0; 0],
            "a step"
        );
        let impact = |n: usize| if [70, 71].contains(&n) { 9.0 } else { swing(n) };
        assert_eq!(alone(&log(impact)), [0; 0]);
        assert_eq!(
            alone(&log(|n| if n % 40 == 5 { 9.0 } else { 0.0 })),
            [0; 0],
            "five"
        );
        assert_eq!(alone(&[f64::NAN; 200]), [0; 0]);
        assert_eq!(alone(&[1.0]), [0; 0]);
    }
}
