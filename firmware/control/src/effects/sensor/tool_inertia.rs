//! Inertia of the tool that the sensor has to accelerate.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::frames::{Wrench, matrix, vector};
use crate::range::{SettingsError, all_within, in_range};
use crate::scalar::Scalar;
use nalgebra::{Matrix3, Vector3};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "tool_inertia",
    title: "Inertia of the tool",
    summary: "the sensor feels the inertia of the tool behind it, which the model leaves out",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "F = -mass_kg a_com; T = -(I alpha + w x I w) - com x mass_kg a_com; \
               a_com = a + alpha x com + w x (w x com)",
    source: "Newton-Euler; seed paper section 3.2 (printed there, then neglected)",
    signature: "wrench proportional to minus the measured acceleration, strongest at jogs and at contact",
    typical: "the mass of the tool: 1 to 20 kg",
    parameters: &[Parameter::new("mass_kg", "kg", 0.0, 100.0)],
    confused_with: &[
        "tool_mass_error",
        "contact_damping",
        "sc_mass_error",
        "ft_latency",
    ],
    tell_apart: "jog without contact, with a fixed orientation: the force follows acceleration and never velocity; \
                 a negative mass is noise of the differentiated velocity, not an effect",
};

/// Motion of the load, axes of S.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadMotion<S: Scalar> {
    /// Acceleration of the sensor's origin, m/s².
    pub acceleration: Vector3<S>,
    /// Angular velocity, rad/s.
    pub angular_velocity: Vector3<S>,
    /// Angular acceleration, rad/s².
    pub angular_acceleration: Vector3<S>,
}

impl<S: Scalar> LoadMotion<S> {
    /// Acceleration (m/s²) of a point at `r` (m) from the sensor's origin.
    pub fn acceleration_at(&self, r: &Vector3<S>) -> Vector3<S> {
        let w = &self.angular_velocity;
        self.acceleration + self.angular_acceleration.cross(r) + w.cross(&w.cross(r))
    }
}

/// A rigid tool.
#[derive(Clone, Copy, Debug)]
pub struct ToolInertia<S: Scalar> {
    mass_kg: S,
    com: Vector3<S>,
    inertia: Matrix3<S>,
}

impl<S: Scalar> ToolInertia<S> {
    /// `mass_kg` 0 to 1000; `com_m` from the sensor's origin; `inertia_kg_m2` about the centre of
    /// mass, axes of S, diagonal 0 to 1000.
    pub fn new(
        mass_kg: f64,
        com_m: &[f64; 3],
        inertia_kg_m2: &[[f64; 3]; 3],
    ) -> Result<Self, SettingsError> {
        in_range("mass_kg", mass_kg, 0.0, 1000.0)?;
        all_within("com_m", com_m, 10.0)?;
        let inertia = matrix::<f64>(inertia_kg_m2);
        for moment in inertia.diagonal().iter() {
            in_range("inertia_kg_m2", *moment, 0.0, 1000.0)?;
        }
        all_within("inertia_kg_m2", inertia.as_slice(), 1000.0)?;
        Ok(Self {
            mass_kg: S::of(mass_kg),
            com: vector(com_m),
            inertia: inertia.map(S::of),
        })
    }

    /// Wrench at S while the load moves so.
    pub fn wrench(&self, motion: &LoadMotion<S>) -> Wrench<S> {
        let force = -motion.acceleration_at(&self.com) * self.mass_kg;
        let w = &motion.angular_velocity;
        let spin = self.inertia * motion.angular_acceleration + w.cross(&(self.inertia * w));
        Wrench {
            force,
            torque: self.com.cross(&force) - spin,
        }
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
        let inertia = [
            [0.0, 0.0, 0.0],
            [0.0, about_com, 0.0],
            [0.0, 0.0, about_com],
        ];
        let rod = ToolInertia::<f64>::new(mass, &[length / 2.0, 0.0, 0.0], &inertia).unwrap();
        let motion = LoadMotion {
            acceleration: Vector3::zeros(),
            angular_velocity: Vector3::new(0.0, 0.0, w),
            angular_acceleration: Vector3::new(0.0, 0.0, alpha),
        };
        let got = rod.wrench(&motion).get();
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

    #[test]
    fn negative_mass_is_refused() {
        let error = ToolInertia::<f64>::new(-0.1, &[0.0; 3], &[[0.0; 3]; 3]).unwrap_err();
        assert_eq!((error.field, error.received), ("mass_kg", -0.1));
    }
}
