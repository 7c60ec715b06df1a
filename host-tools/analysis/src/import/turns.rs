//! Whole turns of a machine's axis. A pose does not contain them: its orientation is the same after each turn, but the torque of
//! a spring or a cable is not.
//!
//! Within a log turns are counted from row to row ([`Angles`], [`turned`]); only the turns of its first pose have to be found.
//! The column of the angle tells them, if there is one that does not begin again after each turn. Otherwise the logs of one
//! import are taken to be of one machine: the mid-range angle of each is within half a turn of that of the first log
//! ([`Turning`]).

use anyhow::bail;
use nalgebra::{UnitQuaternion, Vector3};
use softdock_app::record::CycleRecord;
use softdock_physics::model::load::{Followed, angles, count_turns, pose_of, turned_since_first};
use softdock_report::number;
use softdock_statistics::sample_time;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::Range;

/// Deviation from an axis, in a unit quaternion or a rotation vector, that is round-off.
pub(super) const OFF: f64 = 1e-9;

/// Angles about one axis.
#[derive(Clone, Debug)]
pub(super) struct Angles {
    /// The axis, in M and in C.
    pub(super) axis: Vector3<f64>,
    /// With whole turns, rad.
    pub(super) rad: Vec<f64>,
    /// The column begins again after each turn, or there is none: then angles are comparable between logs only up to whole turns.
    pub(super) begin_again: bool,
}

impl Angles {
    /// Angles from columns of rotation vectors. None unless exactly one column is other than zero: rotation about one axis of C.
    /// A column that exceeds a turn is taken to count turns itself, however large its steps are.
    pub(super) fn of_columns(columns: &[Vec<f64>; 3]) -> Option<Self> {
        let turns = |axis: &usize| columns[*axis].iter().any(|v| *v != 0.0);
        let mut turning = (0..3).filter(turns);
        let (axis, None) = (turning.next()?, turning.next()) else {
            return None;
        };
        let shown = &columns[axis];
        let mut rad = shown.clone();
        let begin_again = begins_again(shown);
        if begin_again {
            count_turns(rad.iter_mut().map(|rad| (rad, 0.0)));
            let ahead = shown.iter().zip(&rad).map(|(shown, rad)| shown - rad);
            let ahead = ahead.into_iter().find(|ahead| ahead.is_finite())?;
            rad.iter_mut().for_each(|rad| *rad += ahead);
        }
        Some(Self {
            axis: Vector3::ith(axis, 1.0),
            rad,
            begin_again,
        })
    }

    /// Angles from quaternions w x y z; None unless all are rotations about one axis.
    pub(super) fn of_quaternions([w, x, y, z]: &[Vec<f64>; 4]) -> Option<Self> {
        let rows = x.iter().zip(y).zip(z);
        let vectors: Vec<Vector3<f64>> = rows.map(|((x, y), z)| Vector3::new(*x, *y, *z)).collect();
        let known = vectors.iter().filter(|v| v.norm().is_finite());
        let farthest = known.max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
        let axis = farthest.try_normalize(OFF)?;
        let axis = axis * axis[axis.iamax()].signum();
        if vectors
            .iter()
            .any(|v| (v - axis * v.dot(&axis)).norm() > OFF)
        {
            return None;
        }
        let angle = |(v, w): (&Vector3<f64>, &f64)| 2.0 * v.dot(&axis).atan2(*w);
        let mut rad: Vec<f64> = vectors.iter().zip(w).map(angle).collect();
        count_turns(rad.iter_mut().map(|rad| (rad, 0.0)));
        Some(Self {
            axis,
            rad,
            begin_again: true,
        })
    }
}

/// Whether an angle jumps back by whole turns somewhere. That is so if there are steps of more than half a turn and either the
/// angle stays within one turn, or each such step continues the one before up to whole turns. Other large steps are fast
/// rotation.
fn begins_again(shown: &[f64]) -> bool {
    /// One turn with some rounding, rad.
    const ONE_TURN: f64 = 1.01 * TAU;
    /// Largest change of the step from row to row for it to continue, rad. An encoder whose zero was set in between hardly meets
    /// it by chance.
    const GOES_ON: f64 = 0.125 * PI;
    let finite = || shown.iter().copied().filter(|angle| angle.is_finite());
    let range = finite().fold(f64::NEG_INFINITY, f64::max) - finite().fold(f64::INFINITY, f64::min);
    let (mut jumps, mut goes_on, mut before) = (false, true, f64::NAN);
    for (from, to) in finite().zip(finite().skip(1)) {
        let mut step = to - from;
        if step.abs() > PI {
            let nearest = step - TAU * (step / TAU).round();
            let is_jump = (nearest - before).abs() < GOES_ON;
            (jumps, goes_on) = (true, goes_on && is_jump);
            step = if is_jump { nearest } else { step };
        }
        before = step;
    }
    jumps && (goes_on || range < ONE_TURN)
}

/// Refuses rows between which the rotation is ambiguous: from a steady speed of more than a quarter of a turn per row, the next
/// step seems to change by more than half a turn. `numbers`: numbers of the rows in their file.
pub(super) fn ensure_told(
    rotations: &[UnitQuaternion<f64>],
    pieces: &[Range<usize>],
    numbers: &[usize],
    name: &str,
) -> anyhow::Result<()> {
    let step = |pair: &[UnitQuaternion<f64>]| (pair[0].inverse() * pair[1]).scaled_axis();
    let steps: Vec<Vector3<f64>> = rotations.windows(2).map(step).collect();
    let another = |s: &[Vector3<f64>]| {
        s[1].norm() > FRAC_PI_2 && (s[1] - s[0]).norm() < FRAC_PI_2 && (s[2] - s[1]).norm() > PI
    };
    let untold = |piece: &Range<usize>| {
        let seems = |row: &usize| steps.get(row - 3..*row).is_some_and(another);
        (piece.start + 3..piece.end).filter(seems)
    };
    let untold: Vec<usize> = pieces.iter().flat_map(untold).collect();
    if let [first, ..] = untold.as_slice() {
        let [before, after] = [2, 1].map(|n| number::significant(steps[first - n].norm(), 3));
        bail!(
            "{name}, row {}: it turns by {before} rad from a row to the next, and then by {after} rad the other way ({} such row(s)), as \
             what turns by more than half a turn from row to row seems to do, and nobody can tell how far; expected rows \
             closer together, or, in [orientation], a column that counts turns instead of beginning again after each",
            numbers[*first],
            untold.len()
        );
    }
    Ok(())
}

/// The poses of some cycles, each with the turn since the one before that the velocities of both say.
pub(super) fn poses_of(cycles: &[CycleRecord]) -> impl Iterator<Item = Followed> {
    let cycle_s = sample_time(cycles.iter().map(|c| c.trace.time_s)).unwrap_or(0.0);
    let turn = move |from: &CycleRecord, to: &CycleRecord| {
        let rate = |c: &CycleRecord| Vector3::from_column_slice(&c.trace.executed_velocity[3..]);
        (rate(from) + rate(to)) * (0.5 * cycle_s)
    };
    (0..cycles.len()).map(move |n| Followed {
        pose: pose_of(&cycles[n].trace.pose),
        by_velocity: n
            .checked_sub(1)
            .map_or_else(Vector3::zeros, |before| turn(&cycles[before], &cycles[n])),
    })
}

/// The axis of M about which the cycles turn most.
fn axis(cycles: &[CycleRecord]) -> usize {
    let turned = turned_since_first(poses_of(cycles));
    let most = turned.fold(Vector3::zeros(), |most: Vector3<f64>, turned| {
        most.sup(&turned.abs())
    });
    most.imax()
}

/// Angle of each cycle about axis `axis` of M, rad. The first has `whole_turns`.
fn about(axis: usize, cycles: &[CycleRecord], whole_turns: i32) -> Vec<f64> {
    angles(poses_of(cycles), &Vector3::ith(axis, 1.0), whole_turns)
}

/// The axis of M about which the cycles turn most, and the angle of each cycle about it, rad. The first has `whole_turns`.
pub(super) fn turned(cycles: &[CycleRecord], whole_turns: i32) -> (usize, Vec<f64>) {
    let axis = axis(cycles);
    (axis, about(axis, cycles, whole_turns))
}

/// Whole turns of a later cycle, with which a part of the log begins, by those of the first.
pub(super) fn later(cycles: &[CycleRecord], whole_turns: i32, cycle: usize) -> i32 {
    let (axis, all) = turned(cycles, whole_turns);
    let own = cycles
        .get(cycle)
        .map_or(0.0, |at| about(axis, std::slice::from_ref(at), 0)[0]);
    all.get(cycle)
        .map_or(0.0, |angle| ((angle - own) / TAU).round()) as i32
}

/// Turns of the logs of one machine. Holds of the first log: axis, middle of its angles, rad, and whether its column begins again
/// after each turn (or does not exist).
#[derive(Debug, Default)]
pub(super) struct Turning(Option<(usize, f64, bool)>);

impl Turning {
    /// Whole turns of the first of some cycles, from the column of the angle if there is one.
    pub(super) fn of_first(&mut self, cycles: &[CycleRecord], column: Option<&Angles>) -> i32 {
        let axis = self.0.map_or_else(|| axis(cycles), |(axis, ..)| axis);
        let angles = about(axis, cycles, 0);
        let low = angles.iter().copied().fold(f64::INFINITY, f64::min);
        let high = angles.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let column = column.filter(|column| column.axis[axis] == 1.0);
        let said = column.map_or(0.0, |column| ((column.rad[0] - angles[0]) / TAU).round());
        let begin_again = column.is_none_or(|column| column.begin_again);
        let middle = 0.5 * (low + high) + TAU * said;
        let (_, of_first, first_begins) = *self.0.get_or_insert((axis, middle, begin_again));
        let ahead = match begin_again || first_begins {
            true => ((middle - of_first) / TAU).round(),
            false => 0.0,
        };
        (said - ahead) as i32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Speeds below and above half a turn per row, in columns that begin again and columns that do not.
    #[test]
    fn a_column_begins_again_if_it_stays_within_a_turn_or_jumps_by_whole_ones() {
        let swing = |amplitude: f64| -> Vec<f64> {
            (0..400)
                .map(|n| amplitude * (0.05 * f64::from(n)).sin())
                .collect()
        };
        let shown_to = |turns: f64, angles: Vec<f64>| -> Vec<f64> {
            let shown = |a: f64| a.rem_euclid(turns * TAU);
            angles.into_iter().map(shown).collect()
        };
        let begins = |angles: Vec<f64>| begins_again(&angles);
        // The largest step from row to row is 0.05 rad times the amplitude.
        assert!(!begins(swing(3.0)) && !begins(swing(30.0)) && !begins(swing(100.0)));
        assert!(begins(shown_to(1.0, swing(30.0))) && begins(shown_to(3.0, swing(30.0))));
        assert!(begins(shown_to(1.0, swing(100.0))));
        // An encoder that is set to zero on its way has not turned.
        let set = swing(30.0).into_iter().enumerate();
        assert!(!begins(
            set.map(|(n, a)| if n < 20 { a } else { a - 22.0 })
                .collect()
        ));
        let [of_x, still] = [swing(30.0), vec![0.0; 400]];
        let shown = shown_to(1.0, of_x.clone());
        let ahead = Angles::of_columns(&[shown, still.clone(), still]).unwrap();
        assert!(
            ahead.begin_again
                && ahead
                    .rad
                    .iter()
                    .zip(of_x)
                    .all(|(a, b)| (a - b).abs() < 1e-9)
        );
    }
}
