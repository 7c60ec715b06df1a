//! Whole turns of an axis of a machine, which a pose does not hold: its orientation is the same after each, the torque of a
//! spring or a cable is not.
//!
//! Within a log turns are counted from pose to pose ([`turned`]); what is to be found are those of its first pose. The column of the
//! angle says them, if there is one and it does not start again after each turn ([`FirstAngle`]). If not, the logs of one
//! import are of one machine: the middle of each is taken to be within half a turn of that of the first ([`Turning`]).

use super::summary::pose;
use nalgebra::Vector3;
use softdock_app::record::CycleRecord;
use softdock_control::frames::Pose;
use softdock_physics::model::load::angles;
use std::f64::consts::{PI, TAU};

/// The axis of C about which everything turns, if it is one, and the angle of each cycle, rad: the first with so many whole turns.
pub(super) fn turned(cycles: &[CycleRecord], whole_turns: i32) -> Option<(usize, Vec<f64>)> {
    let poses: Vec<Pose<f64>> = cycles.iter().map(pose).collect();
    let turns = |axis: &usize| poses.iter().any(|p| p.rotation.scaled_axis()[*axis] != 0.0);
    let mut turning = (0..3).filter(turns);
    let (axis, None) = (turning.next()?, turning.next()) else {
        return None;
    };
    Some((axis, angles(&poses, &Vector3::ith(axis, 1.0), whole_turns)))
}

/// Whole turns of a later cycle, with which a part of the log begins, by those of the first.
pub(super) fn later(cycles: &[CycleRecord], whole_turns: i32, cycle: usize) -> i32 {
    let part = cycles.get(cycle..).unwrap_or_default();
    match (turned(cycles, whole_turns), turned(part, 0)) {
        (Some((_, all)), Some((_, own))) => ((all[cycle] - own[0]) / TAU).round() as i32,
        _ => 0,
    }
}

/// An angle whose column counts turns, or starts again after each.
#[derive(Clone, Copy, Debug)]
pub(super) struct FirstAngle {
    /// In the first row, rad.
    pub(super) rad: f64,
    /// It jumps back by a turn somewhere: then it is the same in all logs but for whole turns.
    jumps: bool,
}

impl FirstAngle {
    /// Of rotation vectors that turn about one axis of C.
    pub(super) fn of(vectors: &[Vec<f64>; 3]) -> Option<Self> {
        let mut turning = vectors.iter().filter(|part| part.iter().any(|v| *v != 0.0));
        let (angles, None) = (turning.next()?, turning.next()) else {
            return None;
        };
        Some(Self {
            rad: angles.iter().copied().find(|angle| angle.is_finite())?,
            jumps: angles.windows(2).any(|pair| (pair[1] - pair[0]).abs() > PI),
        })
    }

    /// Whole turns by which it is ahead of an angle, rad.
    pub(super) fn ahead_of(&self, angle: f64) -> f64 {
        ((self.rad - angle) / TAU).round()
    }
}

/// The turns of the logs of one machine: of the first the middle of its angles, rad, and whether their column starts again after each
/// turn, or does not exist.
#[derive(Debug, Default)]
pub(super) struct Turning(Option<(f64, bool)>);

impl Turning {
    /// Whole turns of the first of some cycles, by what a column says of it.
    pub(super) fn of_first(&mut self, cycles: &[CycleRecord], column: Option<FirstAngle>) -> i32 {
        let Some((_, angles)) = turned(cycles, 0) else {
            return 0;
        };
        let low = angles.iter().copied().fold(f64::INFINITY, f64::min);
        let high = angles.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let said = column.map_or(0.0, |first| first.ahead_of(angles[0]));
        let jumps = column.is_none_or(|first| first.jumps);
        let middle = 0.5 * (low + high) + TAU * said;
        let (of_first, first_jumps) = *self.0.get_or_insert((middle, jumps));
        let ahead = match jumps || first_jumps {
            true => ((middle - of_first) / TAU).round(),
            false => 0.0,
        };
        (said - ahead) as i32
    }
}
