//! The motion without the noise of its measurement, as far as the actuator's model knows it.
//!
//! Errors are compared with the motion of the rig: velocity, position and load. Their measured values carry noise that is also in
//! the error, so that an error would seem to depend on an axis that merely has noise. The velocity that the nominal actuator
//! makes of the sent one has no noise. Its integral follows the measured pose by a moving average of the difference; this
//! position, and the nominal load of this motion, have almost none.

use super::Source;
use nalgebra::{UnitQuaternion, Vector3};
use softdock_control::frames::{Pose, Twist};
use softdock_control::wrench::Motion as Moving;
use softdock_physics::model::load::{Docked, Followed, LoadModel, turned_since_first};
use softdock_physics::model::prediction::Six;
use softdock_physics::model::prediction::signals::Step;
use softdock_physics::model::{Axis, Channel};
use std::ops::Range;

/// Half width of the moving average that ties the integral to the measured pose, cycles.
const LEAD: usize = 6;
/// An axis moves if its displacement exceeds this multiple of the noise of its measurement.
const MOVES: f64 = 20.0;

/// Motion and load in each cycle; NaN where unknown.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    /// m/s and rad/s, linear in C, angular in M.
    pub(super) velocity: Vec<Six>,
    /// Change of the velocity per second.
    pub(super) acceleration: Vec<Six>,
    /// Translation in C, m, and rotation since the first pose with whole turns, rad.
    pub(super) position: Vec<Six>,
    /// Wrench that the model expects on the sensor, in S, N and N·m.
    pub(super) load: Vec<Six>,
    /// Axes whose displacement is more than noise.
    pub(super) moves: [bool; 6],
}

impl Motion {
    /// Motion from the sent velocities and the measured poses.
    pub(super) fn new(source: &Source<'_>) -> Self {
        let velocity = velocities(source);
        let cycle_s = source.signals.cycle_s;
        let acceleration: Vec<Six> = (0..velocity.len())
            .map(|n| {
                let last = velocity[n.saturating_sub(1)];
                std::array::from_fn(|i| (velocity[n][i] - last[i]) / cycle_s)
            })
            .collect();
        let poses = poses(source, &velocity);
        let known = poses.iter().enumerate();
        let mut turned = turned_since_first(known.filter_map(|(n, pose)| {
            Some(Followed {
                pose: (*pose)?,
                by_velocity: source.signals.turned_by_velocity(n),
            })
        }));
        let mut place = |pose: &Pose<f64>| {
            let (linear, angular) = (pose.translation.vector, turned.next()?);
            Some(Twist { linear, angular }.get())
        };
        let position: Vec<Six> = poses
            .iter()
            .map(|pose| pose.as_ref().and_then(&mut place).unwrap_or([f64::NAN; 6]))
            .collect();
        Self {
            load: loads(source, &poses, &velocity, &acceleration),
            moves: moving(source, &position),
            velocity,
            acceleration,
            position,
        }
    }
}

/// Predicted velocities; measured ones where there is no prediction.
fn velocities(source: &Source<'_>) -> Vec<Six> {
    let channel = source.prediction.channel(Channel::ExecutedVelocity);
    let finite = |v: &Six| v.iter().all(|v| v.is_finite());
    (0..source.signals.len())
        .map(|n| {
            let measured = channel.measured.get(n).copied().filter(finite);
            let predicted = channel.predicted.get(n).copied().flatten().filter(finite);
            predicted.or(measured).unwrap_or([0.0; 6])
        })
        .collect()
}

/// Integral of the velocity, tied to the measured poses.
fn poses(source: &Source<'_>, velocity: &[Six]) -> Vec<Option<Pose<f64>>> {
    let cycle_s = source.signals.cycle_s;
    let mut integral = Vec::with_capacity(velocity.len());
    let mut pose = Pose::identity();
    for v in velocity {
        let v = Twist::of(v);
        pose.translation.vector += v.linear * cycle_s;
        pose.rotation *= UnitQuaternion::from_scaled_axis(v.angular * cycle_s);
        pose.rotation.renormalize_fast();
        integral.push(pose);
    }
    let off: Vec<Option<(Vector3<f64>, Vector3<f64>)>> = integral
        .iter()
        .enumerate()
        .map(|(n, integral)| {
            let measured = source.signals.pose(n)?;
            let turn = integral.rotation.inverse() * measured.rotation;
            let shift = measured.translation.vector - integral.translation.vector;
            Some((shift, turn.scaled_axis()))
        })
        .collect();
    integral
        .iter()
        .enumerate()
        .map(|(n, integral)| {
            let near = &off[near(&source.signals.steps, n)];
            let known = near.iter().flatten().count() as f64;
            let sum = near.iter().flatten().fold(
                (Vector3::zeros(), Vector3::zeros()),
                |(shift, turn), (s, t)| (shift + s, turn + t),
            );
            (known > 0.0).then(|| {
                let mut pose = *integral;
                pose.translation.vector += sum.0 / known;
                pose.rotation *= UnitQuaternion::from_scaled_axis(sum.1 / known);
                pose
            })
        })
        .collect()
}

/// Cycles of the moving average about cycle `n`. It ends at gaps and other runs, behind which the integral has another error.
fn near(steps: &[Step], n: usize) -> Range<usize> {
    let begins = |at: &usize| matches!(steps[*at], Step::Hole | Step::NewRun);
    let (first, end) = (n.saturating_sub(LEAD), (n + LEAD + 1).min(steps.len()));
    let from = (first..=n).rev().find(begins).unwrap_or(first);
    from..(n + 1..end).find(begins).unwrap_or(end)
}

fn loads(
    source: &Source<'_>,
    poses: &[Option<Pose<f64>>],
    velocity: &[Six],
    acceleration: &[Six],
) -> Vec<Six> {
    let load = LoadModel::new(source.model);
    let mut docked = Docked::new(&source.model.contact.docking, source.signals.cycle_s);
    // The mechanism is simulated up to the time of the sensor's sample, which may belong to the run before.
    let mut followed = 0;
    (0..poses.len())
        .map(|n| {
            let at = source.signals.sampled_in(n)?;
            let steps = source.signals.steps.get(followed..=at);
            steps
                .unwrap_or_default()
                .iter()
                .for_each(|step| docked.resume(*step));
            followed = followed.max(at + 1);
            let motion = Moving {
                velocity: Twist::of(&velocity[at]),
                acceleration: Twist::of(&acceleration[at]),
            };
            let pose = poses[at].as_ref()?;
            docked.advance(pose);
            let at_m = docked.wrench(pose, &motion.velocity);
            let reading = load.wrench(pose, &motion) + load.docked(&[at_m], 0);
            Some(reading.get())
        })
        .map(|wrench| wrench.unwrap_or([f64::NAN; 6]))
        .collect()
}

fn moving(source: &Source<'_>, position: &[Six]) -> [bool; 6] {
    let noise = &source.model.noise;
    Axis::ALL.map(|axis| {
        let i = axis.index();
        let known = || position.iter().map(|p| p[i]).filter(|p| p.is_finite());
        let low = known().fold(f64::INFINITY, f64::min);
        let high = known().fold(f64::NEG_INFINITY, f64::max);
        let sigma = if axis.is_rotation() {
            noise.angle_rad
        } else {
            noise.position_m
        };
        high - low > MOVES * sigma
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_app::record::CycleRecord;
    use softdock_control::io::Sequence;
    use softdock_io::recording::Recording;
    use softdock_physics::model::Model;
    use softdock_physics::model::prediction::predict_signals;
    use softdock_physics::model::prediction::signals::Signals;

    const MODEL: &str = include_str!("../../../scenarios/probe-drogue.model.toml");

    /// Runs along x, mm from the seat of the mechanism, with a sensor whose samples are a cycle old.
    fn motion(model: &Model, runs: &[Range<i32>]) -> Motion {
        let docking = &model.contact.docking[0];
        let seat = Vector3::from(docking.position_m) - Vector3::from(docking.tip_m);
        let mut cycles = Vec::new();
        for run in runs {
            for mm in run.clone() {
                let mut cycle = CycleRecord::default();
                let number = cycles.len() as u32;
                let trace = &mut cycle.trace;
                (trace.cycle, trace.time_s) = (number.into(), 0.004 * f64::from(number));
                let x = seat.x + 1e-3 * f64::from(mm);
                trace.pose = [x, seat.y, seat.z, 1.0, 0.0, 0.0, 0.0];
                trace.executed_velocity[0] = 0.25;
                trace.sensor_age = 1;
                let robot = &mut cycle.inputs.robot;
                robot.counter = u64::from(number) + 1;
                robot.pose = Some([0.0; 6]);
                robot.sequence = match mm == run.start {
                    true => Sequence::NewRun,
                    false => Sequence::Next,
                };
                cycles.push(cycle);
            }
        }
        let recording = Recording {
            cycles,
            ..Recording::default()
        };
        let signals = Signals::new(&recording).unwrap();
        let source = Source {
            model,
            signals: &signals,
            prediction: &predict_signals(model, &signals),
            phases: &[],
        };
        Motion::new(&source)
    }

    /// As above; these latches capture at any speed.
    #[test]
    fn a_run_behind_one_that_was_captured_moves_and_is_loaded_as_if_it_were_the_only_one() {
        let socket = "[contact.docking.kind.probe_cone.socket]";
        let model = MODEL.replace(socket, &format!("{socket}\ncapture_speed_m_s = 0.0"));
        let model = Model::from_toml(&model, "model").unwrap();
        let (captured, approach) = (-200..10, -100..-50);
        let both = motion(&model, &[captured.clone(), approach.clone()]);
        let alone = motion(&model, std::slice::from_ref(&approach));
        let is_same = |(a, b): &(Six, Six)| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
        // The sample of the first cycle of a log is unknown.
        for n in 1..approach.len() {
            let other = captured.len() + n;
            let pairs = [
                (both.load[other], alone.load[n]),
                (both.position[other], alone.position[n]),
            ];
            assert!(pairs.iter().all(is_same), "{n}: {pairs:?}");
        }
    }
}
