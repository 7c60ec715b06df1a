//! Channels as the cycles of a recording; what follows from others is filled in.
//!
//! - A pose that is not mapped is the integral of the executed velocity (trapezoidal rule), so
//!   that the two agree.
//! - A derived velocity is the difference of two poses, as the board records it: the mean over
//!   the cycle that ended. Read back, they make central differences at a pose. A log of a
//!   motion that has poses and no velocity has it derived.
//! - Without wrench columns the wrench is NaN: there was no sensor. Velocities that are not mapped
//!   are zero.
//! - Across a gap there is neither an integral nor a difference.

use super::channels::Channels;
use super::file::{Frame, Mapping};
use super::times::{pieces, sample_time_s};
use crate::import::summary::EXECUTED;
use anyhow::ensure;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use softdock_app::record::CycleRecord;
use softdock_control::frames::{Pose, Twist, Wrench};
use softdock_control::modes::Mode;
use softdock_physics::model::load::pose_of;
use std::collections::BTreeSet;
use std::ops::Range;

/// The cycles. `m_from_s` is the orientation of the sensor in M.
///
/// # Errors
///
/// A velocity to be derived from a pose, or a wrench to be turned with it, that is not mapped.
pub(super) fn cycles(
    channels: &Channels,
    mapping: &Mapping,
    m_from_s: &UnitQuaternion<f64>,
    at_rest: bool,
) -> anyhow::Result<Vec<CycleRecord>> {
    let derive = mapping.executed_velocity.derive;
    ensure!(
        !derive || (channels.executed.is_none() && has_pose(channels)),
        "[executed_velocity] `derive = true` takes the velocity from [position] or [orientation]: \
         one of them has to be mapped, and no column of the velocity itself"
    );
    let base = mapping.wrench.frame == Frame::Base && channels.wrench.is_some();
    ensure!(
        !base || channels.orientation.is_some(),
        "[wrench] `frame = \"base\"`: the wrench is turned into the sensor's axes with the pose of \
         its row; map [orientation]"
    );
    let sample_time_s = sample_time_s(&channels.time_s)?;
    let mut cycles: Vec<CycleRecord> = (0..channels.len()).map(|n| cycle(channels, n)).collect();
    let pieces = if at_rest {
        std::iter::once(0..channels.len()).collect()
    } else {
        pieces(&channels.time_s)
    };
    integrate(&mut cycles, channels, sample_time_s, &pieces);
    if derive || derives(channels, at_rest) {
        for piece in pieces {
            differentiate(&mut cycles[piece], sample_time_s);
        }
    }
    if base {
        for cycle in &mut cycles {
            let c_from_s = pose_of(&cycle.trace.pose).rotation * m_from_s;
            let wrench = &mut cycle.inputs.sensor.wrench;
            let in_base = Wrench::of(wrench);
            *wrench = Wrench {
                force: c_from_s.inverse() * in_base.force,
                torque: c_from_s.inverse() * in_base.torque,
            }
            .get();
        }
    }
    Ok(cycles)
}

/// Whether the executed velocity is derived: the log has none, but poses of a motion.
fn derives(channels: &Channels, at_rest: bool) -> bool {
    !at_rest && channels.executed.is_none() && has_pose(channels)
}

/// Channels that are computed from others: name, and how.
pub(super) fn derived(
    channels: &Channels,
    at_rest: bool,
) -> impl Iterator<Item = (&'static str, &'static str)> {
    let velocity = derives(channels, at_rest);
    let pose = !has_pose(channels) && channels.executed.is_some();
    let velocity = velocity.then_some((EXECUTED, "central differences of the poses"));
    velocity
        .into_iter()
        .chain(pose.then_some(("pose", "integral of the velocity")))
}

fn has_pose(channels: &Channels) -> bool {
    channels.position.is_some() || channels.orientation.is_some()
}

fn cycle(channels: &Channels, n: usize) -> CycleRecord {
    let mut cycle = CycleRecord::default();
    cycle.inputs.sensor.wrench = row(&channels.wrench, n).unwrap_or([f64::NAN; 6]);
    let trace = &mut cycle.trace;
    trace.cycle = n as u64;
    trace.time_s = channels.time_s[n];
    trace.mode = if channels.running[n] {
        Mode::Running
    } else {
        Mode::Hold
    };
    trace.sent_velocity = row(&channels.sent, n).unwrap_or_default();
    trace.executed_velocity = row(&channels.executed, n).unwrap_or_default();
    trace.model_velocity = row(&channels.model_velocity, n).unwrap_or_default();
    let [x, y, z] = row(&channels.position, n).unwrap_or_default();
    let orientation = channels.orientation.as_ref();
    let [qw, qx, qy, qz] = orientation.map_or([1.0, 0.0, 0.0, 0.0], |o| o.quaternion(n));
    trace.pose = [x, y, z, qw, qx, qy, qz];
    cycle
}

fn row<const N: usize>(signals: &Option<[Vec<f64>; N]>, n: usize) -> Option<[f64; N]> {
    let signals = signals.as_ref()?;
    Some(std::array::from_fn(|i| signals[i][n]))
}

/// Fills in the parts of the pose that are not mapped.
fn integrate(
    cycles: &mut [CycleRecord],
    channels: &Channels,
    sample_time_s: f64,
    pieces: &[Range<usize>],
) {
    let mut position = Vector3::zeros();
    let mut rotation = UnitQuaternion::identity();
    let mut last: Option<Twist<f64>> = None;
    let starts: BTreeSet<usize> = pieces.iter().map(|piece| piece.start).collect();
    for (n, cycle) in cycles.iter_mut().enumerate() {
        if starts.contains(&n) {
            last = None;
        }
        let velocity = Twist::of(&cycle.trace.executed_velocity);
        if let Some(last) = last.replace(velocity) {
            let moved = (last + velocity) * (0.5 * sample_time_s);
            position += moved.linear;
            rotation *= UnitQuaternion::from_scaled_axis(moved.angular);
        }
        let pose = &mut cycle.trace.pose;
        if channels.position.is_none() {
            pose[..3].copy_from_slice(position.as_slice());
        }
        if channels.orientation.is_none() {
            let Quaternion { coords } = rotation.into_inner();
            pose[3..].copy_from_slice(&[coords.w, coords.x, coords.y, coords.z]);
        }
    }
}

/// Executed velocity as the difference of two poses; the first cycle of a piece repeats the second.
fn differentiate(cycles: &mut [CycleRecord], sample_time_s: f64) {
    let poses: Vec<Pose<f64>> = cycles.iter().map(|c| pose_of(&c.trace.pose)).collect();
    let rate = 1.0 / sample_time_s;
    let velocity = |from: &Pose<f64>, to: &Pose<f64>| Twist {
        linear: (to.translation.vector - from.translation.vector) * rate,
        angular: (from.rotation.inverse() * to.rotation).scaled_axis() * rate,
    };
    let velocities: Vec<_> = poses.windows(2).map(|p| velocity(&p[0], &p[1])).collect();
    let first = velocities.first().copied();
    for (cycle, velocity) in cycles.iter_mut().zip(first.into_iter().chain(velocities)) {
        cycle.trace.executed_velocity = velocity.get();
    }
}
