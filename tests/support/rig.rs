//! The closed loop: whole cycle, late robot, elastic walls.

use crate::driver::Driver;
use crate::plant::{CYCLE_S, Plant, PlantSettings};
use nalgebra::Vector3;
use softdock_app::record::CycleRecord;
use softdock_control::delay::{LawName, ModelVelocity};
use softdock_control::scalar::Scalar;
use softdock_control::settings::Settings;

/// Mass of the simulated spacecraft, kg.
pub const MASS_KG: f64 = 500.0;

/// A case: contact, actuator, approach and settings of the cycle.
#[derive(Clone, Debug)]
pub struct Case {
    /// Settings of the cycle.
    pub settings: Settings,
    /// The plant.
    pub plant: PlantSettings,
}

impl Case {
    /// A spacecraft of 500 kg, flying at `speed_m_s` towards a wall that makes it a resonator of
    /// `frequency_rad_s`; the actuator is ideal and no law runs.
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
            plant: PlantSettings {
                delay_s: 0.0,
                pause_s: 0.0,
                stiffness_n_per_m: MASS_KG * frequency_rad_s * frequency_rad_s,
                normal: Vector3::x(),
                // A quarter second of free flight behind the start; the touch comes in the middle of a
                // cycle, half-way between two samples of the force.
                right_m: 0.252 * speed_m_s,
                left_m: f64::INFINITY,
                metres_per_count: 1e-9,
            },
        }
    }

    /// Scenario S: pure delay 32 ms, pause 16 ms, 21 rad/s (contact of 150 ms).
    pub fn scenario_s(speed_m_s: f64, law: LawName) -> Self {
        let mut case = Self::new(21.0, speed_m_s);
        case.plant.delay_s = 0.032;
        case.plant.pause_s = 0.016;
        case.settings.delay.law = law;
        case
    }

    /// The same with a wall whose normal is turned about z; the spacecraft flies along the normal.
    pub fn turned(mut self, angle_rad: f64) -> Self {
        let normal = Vector3::new(angle_rad.cos(), angle_rad.sin(), 0.0);
        let speed = self.settings.body_k.velocity_m_s[0];
        self.settings.body_k.velocity_m_s = (normal * speed).into();
        self.plant.normal = normal;
        self
    }

    /// Approach speed, m/s.
    pub fn speed_m_s(&self) -> f64 {
        Vector3::from(self.settings.body_k.velocity_m_s).norm()
    }
}

/// The closed loop.
#[derive(Clone, Debug)]
pub struct Rig<S: Scalar> {
    /// The cycle and its inputs.
    pub driver: Driver<S>,
    /// The robot between the walls.
    pub plant: Plant,
    normal: Vector3<f64>,
}

impl<S: Scalar> Rig<S> {
    /// Running.
    pub fn new(case: &Case) -> Self {
        let mut driver = Driver::new(&case.settings);
        let first = driver.start();
        let mut plant = Plant::new(case.plant);
        plant.advance(&first.output.correction);
        Self {
            driver,
            plant,
            normal: case.plant.normal,
        }
    }

    /// One cycle under the wall's force and a disturbance (N, axes of C) that only the sensor
    /// sees.
    pub fn step_disturbed(&mut self, disturbance: Vector3<f64>) -> CycleRecord {
        let force = self.plant.force() + disturbance;
        let at = self.plant.position();
        self.driver.inputs.sensor.wrench = [force.x, force.y, force.z, 0.0, 0.0, 0.0];
        self.driver.inputs.robot.pose = Some([at.x, at.y, at.z, 0.0, 0.0, 0.0]);
        let record = self.driver.step();
        self.plant.advance(&record.output.correction);
        record
    }

    /// One cycle.
    pub fn step(&mut self) -> CycleRecord {
        self.step_disturbed(Vector3::zeros())
    }

    /// Runs until the next contact is over; answers the velocity of the model along the normal,
    /// m/s, or none if that takes more than `limit_s`.
    pub fn bounce(&mut self, limit_s: f64) -> Option<f64> {
        let mut touched = false;
        for _ in 0..(limit_s / CYCLE_S) as usize {
            let record = self.step();
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
}

/// Restitution of the first bounce.
///
/// # Panics
/// If the spacecraft does not come back within 20 s.
pub fn restitution<S: Scalar>(case: &Case) -> f64 {
    let out = Rig::<S>::new(case).bounce(20.0);
    -out.expect("the spacecraft comes back") / case.speed_m_s()
}
