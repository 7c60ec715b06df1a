//! Readings of a single row that depart from both neighbours: mostly damaged ones.

use super::Context;
use softdock_app::record::CycleRecord;
use softdock_physics::model::Axis;
use softdock_report::number;
use std::f64::consts::TAU;

/// A row stands alone if it departs from its neighbours so many times farther than any other row. An impact, even at the sampling
/// rate, has rows of its size beside it, or others like it.
const ALONE: f64 = 10.0;
/// Largest distance between the two neighbours, relative to the departure: the reading has to come back.
const COMES_BACK: f64 = 0.2;
/// Most spikes of a wrench that are reported: more of them are taps on the sensor.
const MOST: usize = 3;
/// Most spikes of a motion, as a share of the rows: no mass jumps away and back within a row, but a noisy encoder may seem to.
const MOST_OF_MOTION: f64 = 0.01;
/// Most rows that are listed.
const LISTED: usize = 12;

/// Appends a warning for each reading that stands alone.
pub(super) fn check(cycles: &[CycleRecord], context: &Context<'_>, warnings: &mut Vec<String>) {
    let of_motion = MOST.max((MOST_OF_MOTION * cycles.len() as f64) as usize);
    for axis in Axis::ALL {
        let values = |of: fn(&CycleRecord) -> [f64; 6]| -> Vec<f64> {
            cycles.iter().map(|c| of(c)[axis.index()]).collect()
        };
        let channels = [
            ("position", places(cycles, axis), of_motion),
            (
                "executed velocity",
                values(|c| c.trace.executed_velocity),
                of_motion,
            ),
            ("wrench", values(|c| c.inputs.sensor.wrench), MOST),
        ];
        for (what, values, most) in channels {
            let rows = alone(&values, most);
            let warning = said(&values, &rows);
            warnings.extend(warning.map(|said| format!("{}: {what} {axis} {said}", context.name)));
        }
    }
}

/// Position along an axis, or angle about it, by the shorter way from row to row.
fn places(cycles: &[CycleRecord], axis: Axis) -> Vec<f64> {
    let i = axis.index();
    let mut last = 0.0;
    let place = |cycle: &CycleRecord| {
        let pose = &cycle.trace.pose;
        if !axis.is_rotation() {
            return pose[i];
        }
        // The pose ends with a quaternion, w first.
        let angle = 2.0 * pose[i + 1].atan2(pose[3]);
        let near = angle - TAU * ((angle - last) / TAU).round();
        last = if near.is_finite() { near } else { last };
        near
    };
    cycles.iter().map(place).collect()
}

/// What is said of rows that stand alone.
fn said(values: &[f64], rows: &[usize]) -> Option<String> {
    let first = *rows.first()?;
    let rounded = |row: usize| number::significant(values[row], 4);
    let alone = format!(
        "is {} in row {}, between {} and {}",
        rounded(first),
        first + 1,
        rounded(first - 1),
        rounded(first + 1)
    );
    let remedy = "`incomplete = \"leave_out\"` in [rows] of the mapping";
    Some(match rows.len() {
        1 => format!("{alone}: a damaged reading? Empty its cell, and say {remedy}"),
        count => {
            let listed: Vec<String> = rows
                .iter()
                .take(LISTED)
                .map(|row| (row + 1).to_string())
                .collect();
            let more = if count > LISTED { ", .." } else { "" };
            format!(
                "{alone}, and likewise in {count} rows in all ({}{more}): damaged readings? Empty their cells, and say {remedy}",
                listed.join(", ")
            )
        }
    })
}

/// Places of up to `most` values that depart [`ALONE`] times as far from both neighbours as any other does.
fn alone(values: &[f64], most: usize) -> Vec<usize> {
    let departure = |n: usize| (values[n] - 0.5 * (values[n - 1] + values[n + 1])).abs();
    let comes_back = |n: &usize| (values[n + 1] - values[n - 1]).abs() < COMES_BACK * departure(*n);
    let inside = 1..values.len().saturating_sub(1);
    let known = inside.map(|n| (n, departure(n)));
    let mut all: Vec<(usize, f64)> = known.filter(|(_, d)| d.is_finite()).collect();
    all.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    let mut rows: Vec<usize> = all.iter().map(|(n, _)| *n).filter(comes_back).collect();
    rows.truncate(most);
    let stand_alone = |rows: &[usize]| {
        let beside = |n: usize| rows.iter().any(|row| row.abs_diff(n) <= 1);
        let other = all.iter().find(|(n, _)| !beside(*n));
        let least = rows.last().map_or(0.0, |row| departure(*row));
        other.map_or(0.0, |(_, departure)| *departure) * ALONE < least
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

    fn alone(values: &[f64]) -> Vec<usize> {
        super::alone(values, MOST)
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

    /// An encoder that is read wrongly now and then, of which one cell is empty besides.
    #[test]
    fn a_motion_may_have_more_of_them() {
        let mut values: Vec<f64> = (0..2000).map(|n| 0.1 * swing(n / 4)).collect();
        let rows: Vec<usize> = (0..15).map(|k| 50 + 113 * k).collect();
        rows.iter().for_each(|row| values[*row] += 0.6);
        values[40] = f64::NAN;
        assert_eq!(super::alone(&values, 20), rows);
        assert_eq!(alone(&values), [0; 0]);
        let said = said(&values, &rows).unwrap();
        assert!(said.contains("in row 51, between"), "{said}");
        assert!(said.contains("in 15 rows in all (51, 164,"), "{said}");
    }

    /// Two turns in steps of a third of a turn, and a reading that is off.
    #[test]
    fn the_angle_of_an_axis_counts_turns() {
        let cycle = |turned: f64| {
            let (sin, cos) = (0.5 * turned).sin_cos();
            let mut cycle = CycleRecord::default();
            cycle.trace.pose = [0.0, 0.0, 0.0, cos, 0.0, sin, 0.0];
            cycle
        };
        let turned = [0.0, 1.0, 2.4, 3.0, 4.0, 5.0, 6.0].map(|n| n * TAU / 3.0);
        let angles = places(&turned.map(cycle), Axis::Ry);
        for (angle, turned) in angles.iter().zip(turned) {
            assert!((angle - turned).abs() < 1e-12, "{angles:?}");
        }
    }
}
