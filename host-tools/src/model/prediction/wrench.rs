//! Raw sensor wrench from measured pose and velocity (README B of docking-rig-log/1):
//! contact + guide + weight of the tool + (if modelled) its inertia + zero, in S.
//!
//! The noise of pose and velocity passes through stiffness, damping and tool mass into the
//! prediction. What to expect of the residual is therefore more than the sensor's noise, and is
//! given for each cycle; judging by the sensor's alone would find a fault in a perfect model.

use super::signals::Signals;
use super::{ChannelPrediction, Six, six};
use crate::model::{Channel, GuideModel, Model, WallModel};
use nalgebra::{UnitQuaternion, Vector3};
use softdock_control::frames::{self, Pose, Twist, Wrench, vector};
use softdock_control::wrench::{Compensation, Motion};

/// Predicts the channel.
pub fn predict(model: &Model, signals: &Signals<'_>) -> ChannelPrediction {
    let load = LoadModel::new(model, signals);
    let at: Vec<Option<(Six, Six)>> = (0..signals.len()).map(|n| load.at(signals, n)).collect();
    let sampled = |n| signals.sampled_in(n).and_then(|m| at[m]);
    let sensor = six(model.noise.force_n, model.noise.torque_n_m);
    ChannelPrediction {
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
    }
}

/// Force that the mechanism and nothing else puts on the sensor, N in C, without the guide's.
///
/// None where the cycle holds no sample or no pose.
pub fn measured_contact_force(model: &Model, signals: &Signals<'_>) -> Vec<Option<Vector3<f64>>> {
    let load = LoadModel::new(model, signals);
    (0..signals.len())
        .map(|n| {
            let sampled = signals.sampled_in(n)?;
            let (pose, motion) = (signals.pose(sampled)?, load.motion(signals, sampled)?);
            let raw = Wrench::of(&signals.cycles[n].inputs.sensor.wrench);
            let contact = load
                .compensation
                .compensate(&raw, &pose.rotation, &motion)
                .at_m;
            let guide = load.guide.as_ref();
            let guided = guide.map_or(Vector3::zeros(), |g| g.force(&pose, &motion.velocity));
            Some(pose.rotation * contact.force - guided)
        })
        .collect()
}

/// Everything that loads the sensor, ready to run.
struct LoadModel {
    compensation: Compensation<f64>,
    m_from_s: Pose<f64>,
    bias: Wrench<f64>,
    walls: Vec<Wall>,
    guide: Option<Guide>,
    /// The predicted wrench contains the tool's inertial wrench.
    inertial: bool,
    noise: MotionNoise,
    /// Variance in free flight: sensor, and acceleration through the tool's mass.
    free_variance: Six,
}

/// One standard deviation of what the prediction is made from.
struct MotionNoise {
    position_m: f64,
    velocity_m_s: f64,
}

impl LoadModel {
    fn new(model: &Model, signals: &Signals<'_>) -> Self {
        let settings = model.sensor_settings();
        let compensation = Compensation::new(&settings);
        let (velocity, acceleration) = signals.motion_sigma(&model.noise);
        let inertial = model.tool.dynamic_compensation;
        let sensor = six(model.noise.force_n, model.noise.torque_n_m);
        let mut free_variance = sensor.map(|s| s * s);
        if inertial {
            add_inertial_variance(&compensation, &acceleration, &mut free_variance);
        }
        Self {
            compensation,
            m_from_s: frames::pose(&settings.position_m, &settings.orientation_wxyz),
            bias: Wrench::of(&settings.bias),
            walls: model.contact.walls.iter().map(Wall::new).collect(),
            guide: model.contact.guide.as_ref().map(Guide::new),
            inertial,
            noise: MotionNoise {
                position_m: model.noise.position_m,
                velocity_m_s: velocity[0],
            },
            free_variance,
        }
    }

    fn motion(&self, signals: &Signals<'_>, n: usize) -> Option<Motion<f64>> {
        Some(Motion {
            velocity: signals.velocity_at_pose(n)?,
            acceleration: signals.acceleration_at_pose(n),
        })
    }

    /// Wrench in S and the noise to expect, at the instant of cycle n.
    fn at(&self, signals: &Signals<'_>, n: usize) -> Option<(Six, Six)> {
        let (pose, motion) = (signals.pose(n)?, self.motion(signals, n)?);
        let s_from_m = self.m_from_s.inverse();
        let mut wrench = self.bias + self.compensation.gravity_wrench(&pose.rotation);
        let mut variance = self.free_variance;
        if self.inertial {
            wrench = wrench + self.compensation.inertial_wrench(&pose.rotation, &motion);
        }
        for wall in &self.walls {
            let Some(force) = wall.force(&pose, &motion.velocity) else {
                continue;
            };
            wrench = wrench + on_tip(&pose, &wall.tip, &force).transferred(&s_from_m);
            let rms = wall.force_sigma(&self.noise);
            let along = on_tip(&pose, &wall.tip, &(wall.normal * rms)).transferred(&s_from_m);
            add_squares(&mut variance, &along.get());
        }
        if let Some(guide) = &self.guide {
            let force = guide.force(&pose, &motion.velocity);
            wrench = wrench + on_tip(&pose, &guide.tip, &force).transferred(&s_from_m);
            for across in guide.force_sigma(&self.noise) {
                let part = on_tip(&pose, &guide.tip, &across).transferred(&s_from_m);
                add_squares(&mut variance, &part.get());
            }
        }
        Some((wrench.get(), variance.map(f64::sqrt)))
    }
}

/// The tool's inertial wrench is linear in the acceleration; the orientation does not matter,
/// because the noise of the three axes is the same.
fn add_inertial_variance(
    compensation: &Compensation<f64>,
    acceleration_sigma: &Six,
    variance: &mut Six,
) {
    for (i, sigma) in acceleration_sigma.iter().enumerate() {
        let mut acceleration = [0.0; 6];
        acceleration[i] = *sigma;
        let motion = Motion {
            velocity: Twist::zero(),
            acceleration: Twist::of(&acceleration),
        };
        let part = compensation.inertial_wrench(&UnitQuaternion::identity(), &motion);
        add_squares(variance, &part.get());
    }
}

fn add_squares(variance: &mut Six, sigma: &Six) {
    variance
        .iter_mut()
        .zip(sigma)
        .for_each(|(v, s)| *v += s * s);
}

/// A force in C on a point of M, as a wrench at M in axes of M.
fn on_tip(pose: &Pose<f64>, tip: &Vector3<f64>, force_c: &Vector3<f64>) -> Wrench<f64> {
    let force = pose.rotation.inverse() * force_c;
    Wrench {
        force,
        torque: tip.cross(&force),
    }
}

/// Position and velocity of a point of M, in C.
fn tip_motion(
    pose: &Pose<f64>,
    velocity: &Twist<f64>,
    tip: &Vector3<f64>,
) -> (Vector3<f64>, Vector3<f64>) {
    let rotation: &UnitQuaternion<f64> = &pose.rotation;
    (
        pose.translation.vector + rotation * tip,
        velocity.linear + rotation * velocity.angular.cross(tip),
    )
}

struct Wall {
    point: Vector3<f64>,
    normal: Vector3<f64>,
    tip: Vector3<f64>,
    stiffness: f64,
    damping: f64,
    damping_depth: f64,
}

impl Wall {
    fn new(model: &WallModel) -> Self {
        Self {
            point: vector(&model.point_m),
            normal: vector::<f64>(&model.normal).normalize(),
            tip: vector(&model.tip_m),
            stiffness: model.stiffness_n_per_m,
            damping: model.damping_n_s_per_m,
            damping_depth: model.damping_depth_m,
        }
    }

    /// Force on the tip in C, None out of contact.
    fn force(&self, pose: &Pose<f64>, velocity: &Twist<f64>) -> Option<Vector3<f64>> {
        let (tip, tip_velocity) = tip_motion(pose, velocity, &self.tip);
        let penetration = (self.point - tip).dot(&self.normal);
        if penetration <= 0.0 {
            return None;
        }
        let share = if self.damping_depth > 0.0 {
            (penetration / self.damping_depth).min(1.0)
        } else {
            1.0
        };
        let rate = -tip_velocity.dot(&self.normal);
        let force = self.stiffness * penetration + self.damping * share * rate;
        Some(self.normal * force.max(0.0))
    }

    /// Noise of the force along the normal, N.
    fn force_sigma(&self, noise: &MotionNoise) -> f64 {
        (self.stiffness * noise.position_m).hypot(self.damping * noise.velocity_m_s)
    }
}

struct Guide {
    axis: Vector3<f64>,
    point: Vector3<f64>,
    tip: Vector3<f64>,
    stiffness: f64,
    damping: f64,
}

impl Guide {
    fn new(model: &GuideModel) -> Self {
        Self {
            axis: vector::<f64>(&model.axis).normalize(),
            point: vector(&model.point_m),
            tip: vector(&model.tip_m),
            stiffness: model.stiffness_n_per_m,
            damping: model.damping_n_s_per_m,
        }
    }

    /// Force on the tip in C.
    fn force(&self, pose: &Pose<f64>, velocity: &Twist<f64>) -> Vector3<f64> {
        let (tip, tip_velocity) = tip_motion(pose, velocity, &self.tip);
        let pull = (tip - self.point) * self.stiffness + tip_velocity * self.damping;
        self.axis * pull.dot(&self.axis) - pull
    }

    /// Noise of the force along two directions across the axis, N in C.
    fn force_sigma(&self, noise: &MotionNoise) -> [Vector3<f64>; 2] {
        let sigma = (self.stiffness * noise.position_m).hypot(self.damping * noise.velocity_m_s);
        let away = Vector3::ith(self.axis.iamin(), 1.0);
        let across = self.axis.cross(&away).normalize();
        [across * sigma, self.axis.cross(&across) * sigma]
    }
}
