//! The tool that hangs on the sensor: weight `F = m g` and inertia `F = −m a_com`, axes of S (seed
//! paper section 3.2; A13: with the centre of gravity as reference the torque of the weight vanishes).
//!
//! Not an effect by itself: an error of the tool is the difference of the wrenches of two tools.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use softdock_control::frames::{Pose, Twist, Wrench};

/// A rigid tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tool {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass from the sensor's origin, axes of S, m.
    pub com: Vector3<f64>,
    /// Inertia about the centre of mass, axes of S, kg·m².
    pub inertia: Matrix3<f64>,
}

impl Tool {
    /// Wrench at S of its weight, for gravity (m/s²) in axes of S.
    pub fn weight(&self, gravity_in_s: &Vector3<f64>) -> Wrench<f64> {
        let force = gravity_in_s * self.mass_kg;
        Wrench {
            force,
            torque: self.com.cross(&force),
        }
    }

    /// Wrench at S of its inertia for this motion.
    pub fn inertial_wrench(&self, motion: &LoadMotion) -> Wrench<f64> {
        let force = -motion.acceleration_at(&self.com) * self.mass_kg;
        let w = &motion.angular_velocity;
        let spin = self.inertia * motion.angular_acceleration + w.cross(&(self.inertia * w));
        Wrench {
            force,
            torque: self.com.cross(&force) - spin,
        }
    }

    /// Weight, and inertia where the reading contains it.
    pub fn wrench(&self, state: &ToolState) -> Wrench<f64> {
        let weight = self.weight(&(state.s_from_c * state.gravity));
        match state.inertial {
            true => weight + self.inertial_wrench(&state.motion),
            false => weight,
        }
    }
}

/// Motion of the load, axes of S.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadMotion {
    /// Acceleration of the sensor's origin, m/s².
    pub acceleration: Vector3<f64>,
    /// Angular velocity, rad/s.
    pub angular_velocity: Vector3<f64>,
    /// Angular acceleration, rad/s².
    pub angular_acceleration: Vector3<f64>,
}

impl LoadMotion {
    /// Motion of a load on a sensor at `m_from_s` in M, from the twist of M and its time derivative: linear in C, angular in M.
    pub fn of_sensor(
        m_from_s: &Pose<f64>,
        c_from_m: &UnitQuaternion<f64>,
        velocity: &Twist<f64>,
        acceleration: &Twist<f64>,
    ) -> Self {
        let at_m = Self {
            acceleration: c_from_m.inverse() * acceleration.linear,
            angular_velocity: velocity.angular,
            angular_acceleration: acceleration.angular,
        };
        let into_s = |v: Vector3<f64>| m_from_s.rotation.inverse() * v;
        Self {
            acceleration: into_s(at_m.acceleration_at(&m_from_s.translation.vector)),
            angular_velocity: into_s(at_m.angular_velocity),
            angular_acceleration: into_s(at_m.angular_acceleration),
        }
    }

    /// At rest, or moving uniformly.
    pub fn uniform() -> Self {
        Self {
            acceleration: Vector3::zeros(),
            angular_velocity: Vector3::zeros(),
            angular_acceleration: Vector3::zeros(),
        }
    }

    /// Acceleration (m/s²) of a point at `r` (m) from the sensor's origin.
    pub fn acceleration_at(&self, r: &Vector3<f64>) -> Vector3<f64> {
        let w = &self.angular_velocity;
        self.acceleration + self.angular_acceleration.cross(r) + w.cross(&w.cross(r))
    }
}

/// The nominal tool at one instant.
#[derive(Clone, Copy, Debug)]
pub struct ToolState {
    /// Nominal mass, kg.
    pub mass_kg: f64,
    /// Known mass of the load on the sensor, kg; 1 if none is known, so that effects are per kilogram.
    pub hanging_kg: f64,
    /// Nominal centre of mass, axes of S, m.
    pub com: Vector3<f64>,
    /// Nominal inertia, axes of S, kg·m².
    pub inertia: Matrix3<f64>,
    /// Nominal gravity in C, m/s².
    pub gravity: Vector3<f64>,
    /// Orientation of C in S.
    pub s_from_c: Matrix3<f64>,
    /// How it moves.
    pub motion: LoadMotion,
    /// The model contains the tool's inertia.
    pub inertial: bool,
}

impl ToolState {
    /// A tool at rest on an upright sensor, without inertia in the model.
    pub fn hanging(mass_kg: f64, com_m: [f64; 3]) -> Self {
        Self {
            mass_kg,
            hanging_kg: mass_kg,
            com: com_m.into(),
            inertia: Matrix3::zeros(),
            gravity: Vector3::new(0.0, 0.0, -9.81),
            s_from_c: Matrix3::identity(),
            motion: LoadMotion::uniform(),
            inertial: false,
        }
    }

    /// Weight of the nominal tool for gravity (m/s²) in axes of S.
    pub fn weight_in(&self, gravity_in_s: &Vector3<f64>) -> Wrench<f64> {
        let tool = Tool {
            mass_kg: self.mass_kg,
            com: self.com,
            inertia: self.inertia,
        };
        tool.weight(gravity_in_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rod of length L and mass m, its end at the sensor, spun up about that end: by the parallel
    /// axis theorem the torque is −(m L²/3) α, and the force is −m α L/2 across, +m w² L/2 along.
    #[test]
    fn rod_about_its_end() {
        let (mass, length, alpha, w) = (3.0, 0.8, 2.0, 1.5);
        let about_com = mass * length * length / 12.0;
        let rod = Tool {
            mass_kg: mass,
            com: Vector3::new(length / 2.0, 0.0, 0.0),
            inertia: Matrix3::from_diagonal(&Vector3::new(0.0, about_com, about_com)),
        };
        let motion = LoadMotion {
            acceleration: Vector3::zeros(),
            angular_velocity: Vector3::new(0.0, 0.0, w),
            angular_acceleration: Vector3::new(0.0, 0.0, alpha),
        };
        let got = rod.inertial_wrench(&motion).get();
        let expected = [
            mass * w * w * length / 2.0,
            -mass * alpha * length / 2.0,
            0.0,
            0.0,
            0.0,
            -mass * length * length / 3.0 * alpha,
        ];
        for (got, expected) in got.iter().zip(expected) {
            assert!((got - expected).abs() < 1e-12, "{got} {expected}");
        }
    }
}
