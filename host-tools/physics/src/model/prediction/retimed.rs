//! A recording with its poses shifted to their true times.
//!
//! Where the recorded velocity is the difference of two poses over the nominal cycle, an error of the clock is in both: a late
//! pose is late in the velocity as well, and a cycle that lasts longer shows too large a velocity. The load of the sensor follows
//! from the true motion.

use super::signals::{Signals, Step, VelocityMeaning};
use crate::effects::{Clock, Law, Values, by_id};
use crate::model::{EffectModel, Model};
use nalgebra::UnitQuaternion;
use softdock_app::record::CycleRecord;
use softdock_control::frames::{self, Pose, pose_components};

impl Model {
    /// Offset of its clocks, s: poses are stamped so much later than wrenches of the same instant.
    pub fn clock_offset_s(&self) -> f64 {
        self.of_clock(|law, p| match law {
            Law::ClockOffset(law) => law(p),
            _ => 0.0,
        })
    }

    /// Relative error of the duration of its cycles.
    pub fn clock_rate_error(&self) -> f64 {
        self.of_clock(|law, p| match law {
            Law::Clock(Clock::Rate(law)) => law(p),
            _ => 0.0,
        })
    }

    fn of_clock(&self, value: impl Fn(Law, Values<'_>) -> f64) -> f64 {
        let known = |effect: &EffectModel| {
            let known = by_id(&effect.id)?;
            Some(value(known.law, &known.values(&effect.parameters)))
        };
        let mut values = self.effects.iter().filter_map(known);
        values.find(|value| *value != 0.0).unwrap_or(0.0)
    }
}

/// Delay of the recorded poses of a rig, s; 0 for any other machine, where the same offset is modelled as an early reading.
fn pose_delay_s(model: &Model, signals: &Signals<'_>) -> f64 {
    match signals.is_of_a_rig() {
        true => model.clock_offset_s(),
        false => 0.0,
    }
}

/// Delay of the recorded velocities of a rig, which they share with the poses whose differences they are, s; 0 where they were
/// measured independently.
pub fn velocity_delay_s(model: &Model, signals: &Signals<'_>) -> f64 {
    match signals.velocity {
        VelocityMeaning::CycleMean => pose_delay_s(model, signals),
        VelocityMeaning::Sampled => 0.0,
    }
}

/// The cycles with true velocities, and poses at the times of the wrenches; `None` where the clock is right. `intervals_s`: true
/// durations of the cycles, which an independently measured velocity does not depend on.
pub fn retimed(
    model: &Model,
    signals: &Signals<'_>,
    intervals_s: &[f64],
) -> Option<Vec<CycleRecord>> {
    let late_s = pose_delay_s(model, signals);
    let differences = signals.velocity == VelocityMeaning::CycleMean;
    let intervals_s = if differences { intervals_s } else { &[] };
    if late_s == 0.0 && intervals_s.is_empty() {
        return None;
    }
    let mut cycles = signals.cycles.to_vec();
    if late_s != 0.0 {
        shift(&mut cycles, signals, late_s);
    }
    for (cycle, interval_s) in cycles.iter_mut().zip(intervals_s) {
        let share = signals.cycle_s / interval_s;
        cycle.trace.executed_velocity = cycle.trace.executed_velocity.map(|v| v * share);
    }
    Some(cycles)
}

/// Moves poses, and velocities that are their differences, to an earlier time.
fn shift(cycles: &mut [CycleRecord], signals: &Signals<'_>, late_s: f64) {
    let cycles_late = late_s / signals.cycle_s;
    let follows =
        |n: usize| signals.velocity == VelocityMeaning::CycleMean && signals.steps[n] == Step::Next;
    let mut last: Option<Pose<f64>> = None;
    for (n, cycle) in cycles.iter_mut().enumerate() {
        let pose = pose_at(signals, n, cycles_late);
        if let Some(pose) = pose {
            cycle.trace.pose = pose_components(&pose);
            if let Some(last) = last.filter(|_| follows(n)) {
                let displacement = pose.translation.vector - last.translation.vector;
                let turn = (last.rotation.inverse() * pose.rotation).scaled_axis();
                let per_cycle = 1.0 / signals.cycle_s;
                let (displacement, turn) = (displacement * per_cycle, turn * per_cycle);
                cycle.trace.executed_velocity = [
                    displacement.x,
                    displacement.y,
                    displacement.z,
                    turn.x,
                    turn.y,
                    turn.z,
                ];
            }
        }
        last = pose;
    }
}

/// The pose some cycles after cycle n, by cubic interpolation of the four around it; at the ends of the recording the nearest
/// one.
fn pose_at(signals: &Signals<'_>, n: usize, later: f64) -> Option<Pose<f64>> {
    let place = n as f64 + later;
    let whole = place.floor();
    let t = place - whole;
    let at = |step: f64| {
        let k = (whole + step).clamp(0.0, (signals.len() - 1) as f64) as usize;
        signals.pose(k)
    };
    let [before, here, next, after] = [at(-1.0)?, at(0.0)?, at(1.0)?, at(2.0)?];
    // The polynomials of Lagrange through −1, 0, 1, 2.
    let weights = [
        -t * (t - 1.0) * (t - 2.0) / 6.0,
        (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
        -(t + 1.0) * t * (t - 2.0) / 2.0,
        (t + 1.0) * t * (t - 1.0) / 6.0,
    ];
    let poses = [before, here, next, after];
    let mut position = nalgebra::Vector3::zeros();
    let mut turn = nalgebra::Vector3::zeros();
    for (pose, weight) in poses.iter().zip(weights) {
        position += pose.translation.vector * weight;
        turn += (here.rotation.inverse() * pose.rotation).scaled_axis() * weight;
    }
    let rotation = here.rotation * UnitQuaternion::from_scaled_axis(turn);
    Some(frames::pose(
        &[position.x, position.y, position.z],
        &[rotation.w, rotation.i, rotation.j, rotation.k],
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::prediction::predict_signals;
    use crate::model::{Axis, Channel};
    use softdock_io::recording::Recording;
    use std::collections::BTreeMap;

    const TS: f64 = 0.004;

    fn path(t: f64) -> f64 {
        0.02 * t - 0.3 * t * t + 0.5 * t * t * t
    }

    fn speed(t: f64) -> f64 {
        0.02 - 0.6 * t + 1.5 * t * t
    }

    /// Late poses with velocities that are their differences, or measured independently.
    fn late(late_s: f64, apart: bool) -> Recording {
        let mut recording = Recording::default();
        for n in 0..100 {
            let at = |n: f64| path(n * TS - late_s);
            let mut cycle = CycleRecord::default();
            cycle.trace.time_s = f64::from(n) * TS;
            cycle.trace.pose = [at(f64::from(n)), 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
            cycle.trace.executed_velocity[0] = match apart {
                true => speed(f64::from(n) * TS),
                false => (at(f64::from(n)) - at(f64::from(n) - 1.0)) / TS,
            };
            cycle.trace.sent_velocity[0] = 1e-3;
            recording.cycles.push(cycle);
        }
        recording
    }

    fn with(id: &str, name: &str, value: f64) -> Model {
        let mut model = Model::default();
        model.effects.push(EffectModel {
            id: id.to_owned(),
            parameters: BTreeMap::from([(name.to_owned(), value)]),
            ..EffectModel::default()
        });
        model
    }

    #[test]
    fn late_poses_are_put_where_they_belong() {
        for late_s in [0.0063, -0.0087] {
            let recording = late(late_s, false);
            let signals = Signals::new(&recording).unwrap();
            let model = with("clock_offset", "offset_s", late_s);
            let placed = retimed(&model, &signals, &[]).unwrap();
            for n in 5..90 {
                let t = f64::from(n) * TS;
                let trace = &placed[n as usize].trace;
                assert!((trace.pose[0] - path(t)).abs() < 1e-9, "{late_s} {n}");
                let velocity = (path(t) - path(t - TS)) / TS;
                assert!((trace.executed_velocity[0] - velocity).abs() < 1e-6);
            }
        }
    }

    /// Only the poses are late, and the pose channel shows by how much.
    #[test]
    fn late_poses_beside_a_velocity_of_its_own_are_put_where_they_belong() {
        for late_s in [0.0063, -0.0087] {
            let recording = late(late_s, true);
            let signals = Signals::new(&recording).unwrap();
            let model = with("clock_offset", "offset_s", late_s);
            let placed = retimed(&model, &signals, &[]).unwrap();
            let prediction = predict_signals(&model, &signals);
            let poses = prediction.channel(Channel::Pose);
            for n in 5..90 {
                let t = f64::from(n) * TS;
                let trace = &placed[n as usize].trace;
                assert!((trace.pose[0] - path(t)).abs() < 1e-9, "{late_s} {n}");
                assert_eq!(trace.executed_velocity[0], speed(t));
                let error = poses.residual(n as usize, Axis::X).unwrap();
                // Half of late_s² times the change of the acceleration is left.
                assert!(error.abs() < 5e-7, "{late_s} {n}: {error}");
            }
        }
    }

    #[test]
    fn a_longer_cycle_has_a_smaller_velocity() {
        let recording = late(0.0, false);
        let signals = Signals::new(&recording).unwrap();
        let model = with("clock_rate", "rate_error", 0.05);
        let intervals = crate::model::prediction::intervals(&model, &signals);
        let placed = retimed(&model, &signals, &intervals).unwrap();
        let recorded = recording.cycles[50].trace.executed_velocity[0];
        let found = placed[50].trace.executed_velocity[0];
        assert!((found - recorded / 1.05).abs() < 1e-12);
        assert!(retimed(&Model::default(), &signals, &[]).is_none());
    }
}
