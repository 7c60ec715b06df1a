//! The force/torque sensor: from contact, weight and inertia to gauge counts.

use super::checks::{check, check_all, named, prefixed};
use super::noise::Noise;
use super::settings::{RigSettings, SensorSettings};
use anyhow::Result;
use nalgebra::Vector3;
use softdock_control::effects::sensor::bias_drift::BiasDrift;
use softdock_control::effects::sensor::gauge_quantisation::GaugeQuantisation;
use softdock_control::effects::sensor::low_pass::LowPass;
use softdock_control::effects::sensor::tool_gravity::ToolGravity;
use softdock_control::effects::sensor::tool_inertia::{LoadMotion, ToolInertia};
use softdock_control::frames::{Pose, Twist, Wrench, orientation_from_abc, vector};

/// One reading of all gauges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SensorSampleSim {
    /// Gauges 0 to 5, saturated to 16 bit.
    pub counts: [i16; 6],
    /// Status word of the sensor; 0 unless a fault was set.
    pub status: u16,
}

/// What the load does at one instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Load {
    pub(super) c_from_m: Pose<f64>,
    /// Contact at M, in M axes.
    pub(super) contact: Wrench<f64>,
    pub(super) twist: Twist<f64>,
    /// Linear in C, angular in M; per second.
    pub(super) acceleration: Twist<f64>,
}

/// Sensor and tool.
#[derive(Clone, Debug)]
pub(super) struct Sensor {
    s_from_m: Pose<f64>,
    /// Origin of S in M, m.
    position: Vector3<f64>,
    gravity: Vector3<f64>,
    weight: ToolGravity<f64>,
    inertia: Option<ToolInertia<f64>>,
    offset: BiasDrift<f64>,
    low_pass: Option<LowPass<f64>>,
    gauges: GaugeQuantisation<f64>,
    noise_sigma: [f64; 6],
    noise: Noise,
    /// Status word that readings carry.
    pub(super) status: u16,
}

impl Sensor {
    pub(super) fn new(settings: &RigSettings, noise: Noise) -> Result<Self> {
        let s = &settings.sensor;
        check_all("rig.gravity_m_s2", &settings.gravity_m_s2, -100.0, 100.0)?;
        check_sensor(s)?;
        let rotation = orientation_from_abc(&s.orientation_abc_rad);
        let m_from_s = Pose::from_parts(vector::<f64>(&s.position_m).into(), rotation);
        let six = |force: &[f64; 3], torque: &[f64; 3]| Wrench {
            force: vector(force),
            torque: vector(torque),
        };
        let (force, torque) = (s.noise_force_n, s.noise_torque_nm);
        let weight = ToolGravity::new(s.tool_mass_kg, &s.tool_com_m);
        let inertia = ToolInertia::new(s.tool_mass_kg, &s.tool_com_m, &s.tool_inertia_kg_m2);
        let inertia = prefixed("rig.sensor.tool_", inertia)?;
        let low_pass = |cutoff| {
            named(
                "rig.sensor.low_pass_hz",
                LowPass::new(cutoff, settings.substep_s()),
            )
        };
        let gauges = GaugeQuantisation::new(
            &s.calibration,
            s.counts_per_newton,
            s.counts_per_newton_metre,
        );
        Ok(Self {
            s_from_m: m_from_s.inverse(),
            position: vector(&s.position_m),
            gravity: vector(&settings.gravity_m_s2),
            weight: prefixed("rig.sensor.tool_", weight)?,
            inertia: s.inertial_load.then_some(inertia),
            offset: BiasDrift::new(
                six(&s.bias_n, &s.bias_nm),
                six(&s.drift_n_per_s, &s.drift_nm_per_s),
            ),
            low_pass: s.low_pass_hz.map(low_pass).transpose()?,
            gauges: prefixed("rig.sensor.", gauges)?,
            noise_sigma: [force, force, force, torque, torque, torque],
            noise,
            status: 0,
        })
    }

    /// Whether the sensor has to see every integration step.
    pub(super) fn has_memory(&self) -> bool {
        self.low_pass.is_some()
    }

    /// Whether the sensor feels acceleration.
    pub(super) fn feels_inertia(&self) -> bool {
        self.inertia.is_some()
    }

    /// Starts as if the load had been at rest like this for a long time.
    pub(super) fn settle(&mut self, load: &Load) {
        let wrench = self.load_wrench(load);
        if let Some(filter) = &mut self.low_pass {
            filter.settle(&wrench);
        }
    }

    /// One integration step of what remembers.
    pub(super) fn advance(&mut self, load: &Load) {
        let wrench = self.load_wrench(load);
        if let Some(filter) = &mut self.low_pass {
            filter.advance(&wrench);
        }
    }

    /// A reading at `time_s`.
    pub(super) fn read(&mut self, load: &Load, time_s: f64) -> SensorSampleSim {
        let felt = match &self.low_pass {
            Some(filter) => filter.value(),
            None => self.load_wrench(load),
        };
        let mut wrench = (felt + self.offset.at(time_s)).get();
        for (value, sigma) in wrench.iter_mut().zip(self.noise_sigma) {
            *value = self.noise.around(*value, sigma);
        }
        SensorSampleSim {
            counts: self.gauges.counts(&Wrench::of(&wrench)),
            status: self.status,
        }
    }

    /// Contact, weight and inertia at S: the load's reaction.
    fn load_wrench(&self, load: &Load) -> Wrench<f64> {
        let s_from_c = self.s_from_m.rotation * load.c_from_m.rotation.inverse();
        let still = load.contact.transferred(&self.s_from_m)
            + self.weight.wrench(&(s_from_c * self.gravity));
        let Some(tool) = &self.inertia else {
            return still;
        };
        let at_m = LoadMotion {
            acceleration: load.c_from_m.rotation.inverse() * load.acceleration.linear,
            angular_velocity: load.twist.angular,
            angular_acceleration: load.acceleration.angular,
        };
        let into_s = |v: Vector3<f64>| self.s_from_m.rotation * v;
        still
            + tool.wrench(&LoadMotion {
                acceleration: into_s(at_m.acceleration_at(&self.position)),
                angular_velocity: into_s(at_m.angular_velocity),
                angular_acceleration: into_s(at_m.angular_acceleration),
            })
    }
}

fn check_sensor(s: &SensorSettings) -> Result<()> {
    check_all("rig.sensor.position_m", &s.position_m, -10.0, 10.0)?;
    check_all(
        "rig.sensor.orientation_abc_rad",
        &s.orientation_abc_rad,
        -10.0,
        10.0,
    )?;
    check_all("rig.sensor.bias_n", &s.bias_n, -1e5, 1e5)?;
    check_all("rig.sensor.bias_nm", &s.bias_nm, -1e5, 1e5)?;
    check_all("rig.sensor.drift_n_per_s", &s.drift_n_per_s, -1e3, 1e3)?;
    check_all("rig.sensor.drift_nm_per_s", &s.drift_nm_per_s, -1e3, 1e3)?;
    check("rig.sensor.noise_force_n", s.noise_force_n, 0.0, 1e3)?;
    check("rig.sensor.noise_torque_nm", s.noise_torque_nm, 0.0, 1e3)
}
