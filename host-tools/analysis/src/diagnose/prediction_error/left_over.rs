//! What the named effects leave on each channel.

use crate::diagnose::actuator::ActuatorFinding;
use crate::diagnose::logs::Logs;
use crate::diagnose::named::NamedEffect;
use crate::diagnose::noise::structure::{Line, Structure};
use crate::diagnose::stages::Stages;
use crate::diagnose::wrench::left::{self, RemainingStructure};
use crate::levels::ChannelLevels;
use softdock_physics::model::load::effects::LoadEffect;
use softdock_physics::model::prediction::Prediction;
use softdock_physics::model::{Axis, Channel, Model};
use softdock_statistics::{Noise, noise_floor, rms};

/// Rms error of the model velocity, in units of its rounding, above which it is more than rounding.
const DIGITS: f64 = 1.35;

/// What is left on each channel beside the `named` effects. `refused` are ids of effects that were found and are not named,
/// because unseen data or their intervals refute them: what they explain counts as left.
pub(crate) fn left_over(
    model: &Model,
    stages: &Stages,
    after: &Logs<Prediction>,
    (named, refused): (&[&NamedEffect], &[&String]),
) -> Vec<RemainingStructure> {
    let mut all = Vec::new();
    // A value at the end of its searched range belongs to something else that looks like this effect, above all if it is a delay.
    let is_at_end = |one: &&&NamedEffect| {
        let wrench = stages.wrench.as_ref();
        wrench.is_some_and(|w| one.at_its_end(&w.prepared).is_some())
    };
    let at_end: Vec<&&NamedEffect> = named.iter().filter(is_at_end).collect();
    let is_late = |id: &str| LoadEffect::find(model, id).is_some_and(LoadEffect::is_late);
    let is_later = at_end.iter().any(|one| is_late(&one.effect.id));
    let of_a_machine = !stages.logs.have_spacecraft() && at_end.is_empty();
    if let Some(found) = &stages.actuator {
        let left = |explained: f64| left_of_actuator(found, stages, explained);
        let explains = !named.is_empty() || found.explained > 0.0;
        all.push(match of_a_machine && explains {
            true => left(found.explained).of_a_servo(),
            false => left(0.0),
        });
    }
    if let Some(found) = &stages.wrench {
        let accepted = found.found.accepted.clone().map(|mut accepted| {
            let is_named = |id: &str| refused.iter().all(|refused| *refused != id);
            accepted.effects.retain(|effect| is_named(effect.id));
            accepted
        });
        let accepted = accepted.as_ref();
        let mut left = left::of_wrench(&found.prepared, accepted, &[]);
        if stages.clock.jitter.is_some() {
            // Instants that were recovered with an error leave bursts where the load changes fast.
            let each = left.axes.iter_mut().flat_map(|(_, _, each)| each);
            each.for_each(|one| *one = one.clone().of_size());
        }
        let explains = accepted.is_some() || found.prepared.known > 0.0;
        if let Some(beside) = found.beside_remainder.as_ref().filter(|_| explains) {
            let smooth = &beside.remainder.of_logs;
            let both = left::of_wrench(&found.prepared, accepted, smooth);
            // What is left in a contact may follow a law of contacts that the catalogue lacks, as on a rig.
            let touches = beside.remainder.is_of_contact();
            left = match (of_a_machine && !touches, is_later) {
                (_, true) => left,
                (true, _) => left.of_a_machine(),
                (false, _) => left.beside(&beside.remainder, &both),
            };
        }
        all.push(left);
    }
    all.push(left_of(Channel::ModelVelocity, stages, after));
    if stages.clock.jitter.is_none() {
        all.push(left_of(Channel::Pose, stages, after));
    }
    all
}

/// What is left of the executed velocity. `explained` is the fall of χ² by effects that the model has already.
pub(super) fn left_of_actuator(
    found: &ActuatorFinding,
    stages: &Stages,
    explained: f64,
) -> RemainingStructure {
    let moving = |axis: &Axis| found.white.iter().all(|w| !w[axis.index()].is_empty());
    let axes = Axis::ALL
        .into_iter()
        .filter(moving)
        .map(|axis| {
            let i = axis.index();
            let logs = stages.logs.all.iter().zip(&found.white).zip(&found.level);
            let scatters = stages.clock.jitter.is_some();
            let of = logs.map(|((log, white), level)| {
                Structure::of_velocity(&white[i], log, level[i], scatters)
            });
            (Channel::ExecutedVelocity, axis, of.collect())
        })
        .collect();
    let (reached, nominal) = (found.search.reached(), found.search.nominal.chi2);
    RemainingStructure::of_velocities(axes, reached, explained + nominal, found.count)
}

/// What is left on a channel that no stage whitens.
fn left_of(channel: Channel, stages: &Stages, after: &Logs<Prediction>) -> RemainingStructure {
    let judged = after.all[0].judged(channel).iter().copied();
    let axes = judged
        .filter(|a| !(channel == Channel::Pose && a.is_rotation()))
        .map(|axis| {
            let each = after.all.iter();
            let each = each.map(|prediction| structure_of(prediction, channel, axis));
            (channel, axis, each.collect())
        })
        .collect();
    let square = |p: &[Prediction]| {
        let z = ChannelLevels::of(p);
        if channel == Channel::Pose {
            z.pose.powi(2)
        } else {
            z.model_velocity.powi(2)
        }
    };
    let (before, now) = (square(&stages.before.all), square(&after.all));
    let floor = if channel == Channel::Pose { 1.0 } else { 0.0 };
    let excess = (now - floor).max(0.0);
    let was = excess + (before - now).max(0.0);
    RemainingStructure::new(axes, excess / was.max(1e-12))
}

/// Structure of one axis of such a channel in one log.
fn structure_of(prediction: &Prediction, channel: Channel, axis: Axis) -> Structure {
    let predicted = prediction.channel(channel);
    let values: Vec<f64> = (0..prediction.time_s.len())
        .map(|n| predicted.residual(n, axis).unwrap_or(0.0))
        .collect();
    let sheet = predicted.sigma[axis.index()];
    let level = rms(&values) / sheet;
    if channel == Channel::ModelVelocity {
        // Rounded digits have no noise spectrum: only the level counts.
        return Structure {
            level: if level > DIGITS { level } else { 0.0 },
            ..Structure::default()
        };
    }
    // The increments of a noisy pose are differences: their spectrum is no test of anything.
    let floor = noise_floor(&values, Noise::Differenced, None)
        .unwrap_or(sheet)
        .max(0.3 * sheet);
    let white: Vec<f64> = values.iter().map(|v| v / floor).collect();
    Structure {
        slow: 0.0,
        line: Line::default(),
        narrow: Line::default(),
        ..Structure::of(&white, prediction.cycle_s, level)
    }
}
