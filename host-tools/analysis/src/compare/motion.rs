//! The motion without the noise of its measurement, as far as the actuator's model knows it.
//!
//! Errors are held against what the rig did: its velocity, position and load. Taken as they were
//! measured, these carry noise that is also in the error, and an error would seem to depend on
//! an axis that only trembles. The velocity that the nominal actuator makes of what was sent has
//! no noise. Its integral, led to the measured pose by a moving average of their difference, and
//! the nominal load in this motion have next to none.

use super::Source;
use nalgebra::{UnitQuaternion, Vector3};
use softdock_control::frames::{Pose, Twist};
use softdock_control::wrench::Motion as Moving;
use softdock_physics::model::load::{Docked, LoadModel, turned_since_first};
use softdock_physics::model::prediction::Six;
use softdock_physics::model::{Axis, Channel};

/// Half width of the moving average that leads the integral to the measured pose, cycles.
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
    /// m in C, and what it has turned since the first pose, with all turns, rad.
    pub(super) position: Vec<Six>,
    /// Wrench that the model expects on the sensor, in S, N and N·m.
    pub(super) load: Vec<Six>,
    /// Axes whose displacement is more than noise.
    pub(super) moves: [bool; 6],
}

impl Motion {
    /// From what was sent and where it led.
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
        let mut turned = turned_since_first(poses.iter().flatten().copied());
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

/// The integral of the velocity, led to the measured poses.
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
            let near = &off[n.saturating_sub(LEAD)..(n + LEAD + 1).min(off.len())];
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

fn loads(
    source: &Source<'_>,
    poses: &[Option<Pose<f64>>],
    velocity: &[Six],
    acceleration: &[Six],
) -> Vec<Six> {
    let load = LoadModel::new(source.model);
    let mut docked = Docked::new(&source.model.contact.docking, source.signals.cycle_s);
    (0..poses.len())
        .map(|n| {
            docked.resume(source.signals.steps[n]);
            let at = source.signals.sampled_in(n)?;
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
