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
use crate::model::load::loaded::LoadOfEach;
use crate::model::load::{Docked, Guide, LoadModel, Scene, Wall, on_tip};
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
    let nominal = Nominal::new(model, signals, intervals_s, executed);
    let sensor = six(model.noise.force_n, model.noise.torque_n_m);
    let sigma = |n: usize| {
        let sampled = signals.sampled_in(n);
        sampled.map_or(sensor, |sampled| nominal.sigma[sampled])
    };
    let cycles = signals.cycles.iter();
    ChannelPrediction {
        channel: Channel::Wrench,
        measured: cycles.map(|c| c.inputs.sensor.wrench).collect(),
        predicted: nominal.with_effects(model, signals, &LoadOfEach::default()),
        sigma: sensor,
        expected_sigma: (0..signals.len()).map(sigma).collect(),
    }
}

/// What is predicted before effects act on the reading: the same for all models that differ in these alone, but for the zero of
/// the sensor.
pub struct Nominal {
    /// Zero of the sensor.
    bias: Six,
    /// Reading at the instant of each cycle.
    at: Vec<Option<Six>>,
    /// Its noise.
    sigma: Vec<Six>,
    /// What effects depend on, if the model has any.
    scene: Option<Scene>,
}

impl Nominal {
    /// Of a model and its signals; arguments as of [`predict`].
    pub fn new(
        model: &Model,
        signals: &Signals<'_>,
        intervals_s: &[f64],
        executed: &ChannelPrediction,
    ) -> Self {
        let cycles = retimed(model, signals, intervals_s);
        let placed = cycles.as_ref().map(|cycles| signals.with(cycles));
        let signals = placed.as_ref().unwrap_or(signals);
        let mut load = NoisyLoad::new(model, signals);
        let sensor = six(model.noise.force_n, model.noise.torque_n_m);
        let next = |n| match load.next(signals, n, intervals_s) {
            Some((reading, sigma)) => (Some(reading), sigma),
            None => (None, sensor),
        };
        let (at, sigma) = (0..signals.len()).map(next).unzip();
        Self {
            bias: model.sensor.bias,
            at,
            sigma,
            scene: added::scene(model, signals, intervals_s, executed),
        }
    }

    /// What each effect of such a model loads the sensor with, given that of another.
    pub fn load_of_each(&self, model: &Model, before: &LoadOfEach) -> LoadOfEach {
        let scene = self.scene.as_ref();
        let of = |scene: &Scene| LoadOfEach::of(&scene.with_model(model), &model.effects, before);
        scene.map(of).unwrap_or_default()
    }

    /// Reading of each cycle with what the effects of a model contribute that is the same but for these and for the zero of the
    /// sensor; `before`: what the loads of some effects are known to be.
    pub fn with_effects(
        &self,
        model: &Model,
        signals: &Signals<'_>,
        before: &LoadOfEach,
    ) -> Vec<Option<Six>> {
        let mut at = self.at.clone();
        for wrench in at.iter_mut().flatten() {
            for ((value, bias), before) in wrench.iter_mut().zip(model.sensor.bias).zip(self.bias) {
                *value += bias - before;
            }
        }
        if let Some(scene) = &self.scene {
            added::add_effects(model, scene, before, &signals.steps, &mut at);
        }
        let sampled = |n| {
            let sampled = signals.sampled_in(n);
            at[sampled.filter(|sampled| signals.has_own_acceleration(*sampled))?]
        };
        let mut read: Vec<Option<Six>> = (0..signals.len()).map(sampled).collect();
        added::add_sampling(model, signals, &mut read);
        read
    }
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
        self.docked.resume(signals.steps[n]);
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
