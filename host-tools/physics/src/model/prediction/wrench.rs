//! Raw sensor wrench from measured pose and velocity (channel B of docs/docking-rig-log-1.md):
//! contact + guide + docking mechanisms + weight of the tool + (if modelled) its inertia + zero, in S.
//!
//! The noise of pose and velocity enters the prediction through stiffness, damping and tool mass. The residual is therefore
//! expected to have more than the sensor's noise; its standard deviation is given for each cycle. Judged by the sensor's noise
//! alone, a perfect model would look wrong.

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

/// The prediction before effects act on the reading. It is the same for all models that differ only in these, and in the zero of
/// the sensor.
pub struct Nominal {
    /// Zero of the sensor.
    bias: Six,
    /// Reading at the instant of each cycle.
    at: Vec<Option<Six>>,
    /// Its noise.
    sigma: Vec<Six>,
    /// Quantities on which effects depend, if the model has any effects on the reading.
    scene: Option<Scene>,
}

impl Nominal {
    /// From a model and its signals; arguments as of [`predict`].
    pub fn new(
        model: &Model,
        signals: &Signals<'_>,
        intervals_s: &[f64],
        executed: &ChannelPrediction,
    ) -> Self {
        let cycles = retimed(model, signals, intervals_s);
        let placed = cycles.as_ref().map(|cycles| signals.with_cycles(cycles));
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

    /// Load of the sensor by each effect of such a model; loads in `before` are reused.
    pub fn load_of_each(&self, model: &Model, before: &LoadOfEach) -> LoadOfEach {
        let scene = self.scene.as_ref();
        let of = |scene: &Scene| LoadOfEach::of(&scene.with_model(model), &model.effects, before);
        scene.map(of).unwrap_or_default()
    }

    /// Reading of each cycle with the effects of a model that differs only in these and in the zero of the sensor; loads in
    /// `before` are reused.
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

/// Force of the contact alone on the sensor, N in C: without tool, zero and guide.
///
/// `None` where the cycle holds no sample or no pose.
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

/// The motion at the instant of cycle n, as measured in cycles of these durations.
fn motion_of(signals: &Signals<'_>, n: usize, intervals_s: &[f64]) -> Option<Motion<f64>> {
    let interval_s = intervals_s.get(n).copied().unwrap_or(signals.cycle_s);
    let mut motion = signals.motion(n)?;
    motion.acceleration = motion.acceleration * (signals.cycle_s / interval_s);
    Some(motion)
}

/// The load, and its noise from that of the measured motion.
struct NoisyLoad {
    load: LoadModel,
    docked: Docked,
    noise: MotionNoise,
    /// Variance in free flight: sensor, and acceleration through the tool's mass.
    free_variance: Six,
}

/// Noise of the quantities that the prediction uses, one standard deviation.
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

    /// Wrench in S and its expected noise at the instant of cycle n; to be called for successive cycles.
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
