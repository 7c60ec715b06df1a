//! Raw sensor wrench from measured pose and velocity (channel B of docs/docking-rig-log-1.md):
//! contact + guide + docking mechanisms + weight of the tool + (if modelled) its inertia + zero, in S.
//!
//! The noise of pose and velocity passes through stiffness, damping and tool mass into the
//! prediction. What to expect of the residual is therefore more than the sensor's noise, and is
//! given for each cycle; judging by the sensor's alone would find a fault in a perfect model.

mod added;

use super::retimed::retimed;
use super::signals::Signals;
use super::{ChannelPrediction, Six, six};
use crate::model::load::{Docked, Guide, LoadModel, Wall, on_tip};
use crate::model::{Channel, Model};
use nalgebra::Vector3;
use softdock_control::frames::Wrench;
use softdock_control::wrench::Motion;

/// Predicts the channel; `intervals_s` are the true durations of the cycles, empty if nominal, and
/// `executed` is the prediction of the executed velocity.
pub fn predict(
    model: &Model,
    signals: &Signals<'_>,
    intervals_s: &[f64],
    executed: &ChannelPrediction,
) -> ChannelPrediction {
    let cycles = retimed(model, signals, intervals_s);
    let placed = cycles.as_ref().map(|cycles| signals.with(cycles));
    let signals = placed.as_ref().unwrap_or(signals);
    let mut load = NoisyLoad::new(model, signals);
    let mut at: Vec<Option<(Six, Six)>> = (0..signals.len())
        .map(|n| load.next(signals, n, intervals_s))
        .collect();
    added::add_effects(model, signals, intervals_s, executed, &mut at);
    let sampled = |n| signals.sampled_in(n).and_then(|m| at[m]);
    let sensor = six(model.noise.force_n, model.noise.torque_n_m);
    let mut prediction = ChannelPrediction {
        channel: Channel::Wrench,
        measured: signals
            .cycles
            .iter()
            .map(|c| c.inputs.sensor.wrench)
            .collect(),
        predicted: (0..signals.len())
            .map(|n| sampled(n).map(|(wrench, _)| wrench))
            .collect(),
        sigma: sensor,
        expected_sigma: (0..signals.len())
            .map(|n| sampled(n).map_or(sensor, |(_, sigma)| sigma))
            .collect(),
    };
    added::add_sampling(model, &mut prediction);
    prediction
}

/// Force that the mechanism and nothing else puts on the sensor, N in C, without the guide's.
///
/// None where the cycle holds no sample or no pose.
pub fn measured_contact_force(model: &Model, signals: &Signals<'_>) -> Vec<Option<Vector3<f64>>> {
    let load = LoadModel::new(model);
    (0..signals.len())
        .map(|n| {
            let sampled = signals.sampled_in(n)?;
            let (pose, motion) = (signals.pose(sampled)?, motion_of(signals, sampled, &[])?);
            let raw = Wrench::of(&signals.cycles[n].inputs.sensor.wrench);
            let contact = load.contact_force(&raw, &pose, &motion);
            let guide = load.guide.as_ref();
            let guided = guide.map_or(Vector3::zeros(), |g| g.force(&pose, &motion.velocity));
            Some(contact - guided)
        })
        .collect()
}

/// The motion at the instant of cycle n, as it was measured in cycles of these durations.
fn motion_of(signals: &Signals<'_>, n: usize, intervals_s: &[f64]) -> Option<Motion<f64>> {
    let interval_s = intervals_s.get(n).copied().unwrap_or(signals.cycle_s);
    let mut motion = signals.motion(n)?;
    motion.acceleration = motion.acceleration * (signals.cycle_s / interval_s);
    Some(motion)
}

/// The load, and the noise that it inherits from a measured motion.
struct NoisyLoad {
    load: LoadModel,
    docked: Docked,
    noise: MotionNoise,
    /// Variance in free flight: sensor, and acceleration through the tool's mass.
    free_variance: Six,
}

/// One standard deviation of what the prediction is made from.
struct MotionNoise {
    position_m: f64,
    velocity_m_s: f64,
}

impl NoisyLoad {
    fn new(model: &Model, signals: &Signals<'_>) -> Self {
        let load = LoadModel::new(model);
        let (velocity, acceleration) = signals.motion_sigma(model);
        let sensor = six(model.noise.force_n, model.noise.torque_n_m);
        let mut free_variance = sensor.map(|s| s * s);
        let inertial = load.inertial_variance(&acceleration);
        free_variance
            .iter_mut()
            .zip(inertial)
            .for_each(|(v, i)| *v += i);
        Self {
            load,
            docked: Docked::new(&model.contact.docking, signals.cycle_s),
            noise: MotionNoise {
                position_m: model.noise.position_m,
                velocity_m_s: velocity[0],
            },
            free_variance,
        }
    }

    /// Wrench in S and the noise to expect, at the instant of cycle n, the one after the last call's.
    fn next(&mut self, signals: &Signals<'_>, n: usize, intervals_s: &[f64]) -> Option<(Six, Six)> {
        let (pose, motion) = (signals.pose(n)?, motion_of(signals, n, intervals_s)?);
        let s_from_m = self.load.m_from_s.inverse();
        let mut variance = self.free_variance;
        for wall in &self.load.walls {
            if wall.force(&pose, &motion.velocity).is_none() {
                continue;
            }
            let along = wall.normal * wall_sigma(wall, &self.noise);
            let part = on_tip(&pose, &wall.tip, &along).transferred(&s_from_m);
            add_squares(&mut variance, &part.get());
        }
        if let Some(guide) = &self.load.guide {
            for across in guide_sigma(guide, &self.noise) {
                let part = on_tip(&pose, &guide.tip, &across).transferred(&s_from_m);
                add_squares(&mut variance, &part.get());
            }
        }
        let mut wrench: Wrench<f64> = self.load.wrench(&pose, &motion);
        if !self.docked.is_empty() {
            self.docked.advance(&pose);
            let docked = self.docked.wrench(&pose, &motion.velocity);
            wrench = wrench + docked.transferred(&s_from_m);
            let noise = [self.noise.position_m, self.noise.velocity_m_s];
            for part in self.docked.noise(&pose, &motion.velocity, noise) {
                add_squares(&mut variance, &part.transferred(&s_from_m).get());
            }
        }
        Some((wrench.get(), variance.map(f64::sqrt)))
    }
}

/// Noise of a wall's force along its normal, N.
fn wall_sigma(wall: &Wall, noise: &MotionNoise) -> f64 {
    (wall.stiffness * noise.position_m).hypot(wall.damping * noise.velocity_m_s)
}

/// Noise of a guide's force along two directions across its axis, N in C.
fn guide_sigma(guide: &Guide, noise: &MotionNoise) -> [Vector3<f64>; 2] {
    let sigma = (guide.stiffness * noise.position_m).hypot(guide.damping * noise.velocity_m_s);
    let away = Vector3::ith(guide.axis.iamin(), 1.0);
    let across = guide.axis.cross(&away).normalize();
    [across * sigma, guide.axis.cross(&across) * sigma]
}

fn add_squares(variance: &mut Six, sigma: &Six) {
    variance
        .iter_mut()
        .zip(sigma)
        .for_each(|(v, s)| *v += s * s);
}
