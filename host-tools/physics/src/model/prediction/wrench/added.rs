//! Effects of the model file on the wrench.

use super::super::executed::velocities;
use super::super::signals::{Signals, Step};
use super::super::{ChannelPrediction, Six};
use super::motion_of;
use crate::effects::{Law, Sampling, by_id};
use crate::model::load::Scene;
use crate::model::load::effects::LoadEffect;
use crate::model::load::loaded::{LoadOfEach, add_known, beyond_the_end};
use crate::model::{Axis, EffectModel, Model};
use softdock_actuator::Reading;
use softdock_control::frames::{Pose, Twist};
use softdock_control::wrench::Motion;

/// Adds the change by the model's effects to the reading of each cycle. Cycles whose motion lies beyond the end of a stretch get
/// `None`.
pub(super) fn add_effects(
    model: &Model,
    nominal: &Scene,
    loads: &LoadOfEach,
    steps: &[Step],
    at: &mut [Option<Six>],
) {
    let mut scene = nominal.with_model(model);
    let before = scene.reading.clone();
    add_known(&mut scene, &model.effects, loads);
    let beyond = beyond_the_end(&scene);
    for end in (1..=at.len()).filter(|n| steps.get(*n) != Some(&Step::Next)) {
        at[end.saturating_sub(beyond)..end].fill(None);
    }
    for axis in (0..6).filter(|axis| !scene.reading.0[*axis].is_empty()) {
        for (n, prediction) in at.iter_mut().enumerate() {
            if let Some(wrench) = prediction {
                wrench[axis] += scene.reading.at(axis, n) - before.at(axis, n);
            }
        }
    }
}

/// The measured motion, with the predicted velocity where that is right: that has no noise, which a friction would turn into
/// wrong signs. A cycle without a pose repeats the last one. `None` for a model without effects on the reading.
pub(super) fn scene(
    model: &Model,
    signals: &Signals<'_>,
    intervals_s: &[f64],
    executed: &ChannelPrediction,
) -> Option<Scene> {
    let acts = |effect: &EffectModel| LoadEffect::find(model, &effect.id).is_some();
    if !model.effects.iter().any(acts) {
        return None;
    }
    let still = Motion {
        velocity: Twist::zero(),
        acceleration: Twist::zero(),
    };
    let predicted = if is_right(executed) {
        velocities(model, signals, intervals_s, Reading::AtEnd)
    } else {
        vec![None; signals.len()]
    };
    let mut last = Pose::identity();
    let (pose, motion) = (0..signals.len())
        .map(|n| {
            last = signals.pose(n).unwrap_or(last);
            let mut motion = motion_of(signals, n, intervals_s).unwrap_or(still);
            if let Some(velocity) = predicted[n] {
                motion.velocity = Twist::of(&velocity);
                let interval_s = intervals_s.get(n).copied().unwrap_or(signals.cycle_s);
                if let Some(before) = n.checked_sub(1).and_then(|p| predicted[p]) {
                    let change = |i: usize| (velocity[i] - before[i]) / interval_s;
                    motion.acceleration = Twist::of(&std::array::from_fn(change));
                }
            }
            (last, motion)
        })
        .unzip();
    let time_s = signals.cycles.iter().map(|c| c.trace.time_s).collect();
    let steps = signals.steps.clone();
    let scene = Scene::of_steps(model, signals.cycle_s, time_s, pose, motion, steps);
    let of_a_rig = signals.is_of_a_rig();
    let turned = |n: usize| signals.turned_by_velocity(n);
    Some(scene.of_log(
        of_a_rig,
        signals.whole_turns,
        turned,
        signals.wrench_changes(),
        &signals.began,
    ))
}

/// Whether a prediction's residual is little more than noise.
fn is_right(executed: &ChannelPrediction) -> bool {
    /// Ratio to the noise of the data sheet up to which a prediction is right; the true noise may exceed the data sheet's.
    const RIGHT: f64 = 1.6;
    let (mut squares, mut count) = (0.0, 0.0);
    for (n, predicted) in executed.predicted.iter().enumerate() {
        for axis in Axis::ALL.into_iter().filter(|_| predicted.is_some()) {
            if let Some(residual) = executed.residual(n, axis) {
                squares += (residual / executed.sigma[axis.index()]).powi(2);
                count += 1.0;
            }
        }
    }
    count > 0.0 && squares < RIGHT * RIGHT * count
}

/// Applies what the sensor does to its samples: rounding, and repeating the last one.
pub(super) fn add_sampling(model: &Model, signals: &Signals<'_>, readings: &mut [Option<Six>]) {
    let measured = |n: usize| &signals.cycles[n].inputs.sensor.wrench;
    for effect in &model.effects {
        let Some(known) = by_id(&effect.id) else {
            continue;
        };
        let Law::Sample(Sampling { read, .. }) = known.law else {
            continue;
        };
        let values = known.values(&effect.parameters);
        for (n, reading) in readings.iter_mut().enumerate() {
            let before = n.checked_sub(1).map(measured);
            *reading = reading.and_then(|r| read(&values, r, measured(n), before));
        }
    }
}
