//! A late robot between elastic walls: the test of known results about the delay.

use crate::closed_loop::ClosedLoop;
use nalgebra::Vector3;
use softdock_control::delay::{LawName, ModelVelocity};
use softdock_control::scalar::Scalar;
use softdock_control::settings::Settings;
use softdock_delay_plants::{Actuator, Contact, PlantSettings, Wall};

/// Interpolation cycle of the robot, s.
pub const CYCLE_S: f64 = 0.004;
/// Mass of the simulated spacecraft, kg.
pub const MASS_KG: f64 = 500.0;

/// A case: contact, actuator, approach and settings of the cycle.
#[derive(Clone, Debug)]
pub struct Case {
    /// Settings of the cycle.
    pub settings: Settings,
    /// The robot.
    pub actuator: Actuator,
    /// Stiffness of the walls, N/m.
    pub stiffness_n_per_m: f64,
    /// Unit normal, from the left wall to the right one, in axes of C.
    pub normal: Vector3<f64>,
    /// Distance of the right wall from the start along the normal, m.
    pub right_m: f64,
    /// Distance of the left wall opposite to the normal, m; infinite for none.
    pub left_m: f64,
}

impl Case {
    /// A spacecraft of 500 kg that moves at `speed_m_s` towards a wall with which it has the natural frequency
    /// `frequency_rad_s`; the actuator is ideal and no law is active.
    pub fn new(frequency_rad_s: f64, speed_m_s: f64) -> Self {
        let mut settings = Settings::default();
        settings.delay.law = LawName::None;
        settings.robot.correction_decimals = 6;
        settings.body_k.mass_kg = MASS_KG;
        settings.body_k.velocity_m_s = [speed_m_s, 0.0, 0.0];
        settings.body_q.fixed = true;
        settings.limits.box_m = [1.0; 3];
        settings.start.ramp_cycles = 5;
        settings.delay.model_velocity = ModelVelocity::Mean;
        Self {
            settings,
            actuator: Actuator::ideal(),
            stiffness_n_per_m: MASS_KG * frequency_rad_s * frequency_rad_s,
            normal: Vector3::x(),
            // A quarter second of free flight after the start; the contact begins in the middle of a cycle, half-way between
            // two samples of the force.
            right_m: 0.252 * speed_m_s,
            left_m: f64::INFINITY,
        }
    }

    /// Scenario S: pure delay 32 ms, pause 16 ms, 21 rad/s (contact of 150 ms).
    pub fn scenario_s(speed_m_s: f64, law: LawName) -> Self {
        let mut case = Self::new(21.0, speed_m_s);
        case.actuator.delay_s = 0.032;
        case.actuator.pause_s = 0.016;
        case.settings.delay.law = law;
        case
    }

    /// The same with a wall whose normal is turned about z; the spacecraft moves along the normal.
    pub fn turned(mut self, angle_rad: f64) -> Self {
        let normal = Vector3::new(angle_rad.cos(), angle_rad.sin(), 0.0);
        let speed = self.settings.body_k.velocity_m_s[0];
        self.settings.body_k.velocity_m_s = (normal * speed).into();
        self.normal = normal;
        self
    }

    /// Approach speed, m/s.
    pub fn speed_m_s(&self) -> f64 {
        Vector3::from(self.settings.body_k.velocity_m_s).norm()
    }

    /// The loop, running.
    pub fn start<S: Scalar>(&self) -> ClosedLoop<S> {
        let sides = [(self.right_m, self.normal), (self.left_m, -self.normal)];
        let near = sides.into_iter().filter(|(away_m, _)| away_m.is_finite());
        let walls = near.map(|(away_m, towards)| {
            let (point, normal) = ((towards * away_m).into(), (-towards).into());
            Wall::elastic(point, normal, self.stiffness_n_per_m).into()
        });
        let plant = PlantSettings {
            actuator: self.actuator,
            contact: Contact {
                probes: vec![[0.0; 3]],
                surfaces: walls.collect(),
            },
            ..PlantSettings::default()
        };
        ClosedLoop::started(&self.settings, &plant)
    }

    /// Runs until the next contact is over; returns the velocity of the model along the normal, m/s, or none if that takes
    /// longer than `limit_s`.
    pub fn bounce<S: Scalar>(&self, closed: &mut ClosedLoop<S>, limit_s: f64) -> Option<f64> {
        let mut touched = false;
        for _ in 0..(limit_s / CYCLE_S) as usize {
            let record = closed.step();
            if record.trace.fault.is_some() {
                return None;
            }
            let loaded = record.inputs.sensor.wrench != [0.0; 6];
            if touched && !loaded {
                let [x, y, z, ..] = record.trace.body_k.velocity;
                return Some(Vector3::new(x, y, z).dot(&self.normal));
            }
            touched |= loaded;
        }
        None
    }

    /// Restitution of the first bounce.
    ///
    /// # Panics
    /// If the spacecraft does not return within 20 s.
    pub fn restitution<S: Scalar>(&self) -> f64 {
        let out = self.bounce(&mut self.start::<S>(), 20.0);
        -out.expect("the spacecraft comes back") / self.speed_m_s()
    }
}
