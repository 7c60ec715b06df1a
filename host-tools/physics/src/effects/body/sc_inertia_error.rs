//! Inertia with which the rig integrates the spacecraft.

use crate::effects::{Effect, Group, Law, Naming, Parameter};
use nalgebra::{Matrix3, Vector3};
use softdock_control::frames::matrix;
use softdock_control::range::{SettingsError, all_within, in_range};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "sc_inertia_error",
    title: "Inertia of the spacecraft",
    summary: "the rig integrates with another inertia of the spacecraft than the model says",
    group: Group::Body,
    naming: Naming::Cause,
    equation: "I = I_nominal + diag(ixx_kg_m2, iyy_kg_m2, izz_kg_m2); alpha = I^-1 (T - w x I w)",
    source: "Euler's equation",
    signature: "the rig's model turns by a wrong factor under torques, axis by axis, while the translation fits",
    typical: "nothing, or the difference of two versions of a settings file",
    parameters: &[
        Parameter::new("ixx_kg_m2", "kg·m^2", -1000.0, 1000.0),
        Parameter::new("iyy_kg_m2", "kg·m^2", -1000.0, 1000.0)
            .hidden(12.0, 25.0)
            .either_sign(),
        Parameter::new("izz_kg_m2", "kg·m^2", -1000.0, 1000.0)
            .hidden(12.0, 25.0)
            .either_sign()
            .pictured(-20.0),
    ],
    confused_with: &["sc_mass_error", "ft_scale", "tool_com_error"],
    tell_apart: "excite the three rotations one after the other: each axis has its own factor, and the torques in \
                 the log fit the contact",
    law: Law::Spacecraft,
    ..Effect::PLAIN
};

/// A spacecraft with a wrong inertia.
#[derive(Clone, Copy, Debug)]
pub struct InertiaError {
    inertia: Matrix3<f64>,
    inverse: Matrix3<f64>,
}

impl InertiaError {
    /// Nominal inertia about the centre of mass, body axes, and the errors of its diagonal,
    /// kg·m²; the sum has to be positive definite, with a diagonal up to 1e6.
    pub fn new(
        inertia_kg_m2: &[[f64; 3]; 3],
        error_kg_m2: &[f64; 3],
    ) -> Result<Self, SettingsError> {
        let [ixx, iyy, izz] = *error_kg_m2;
        all_within("ixx_kg_m2, iyy_kg_m2, izz_kg_m2", error_kg_m2, 1e6)?;
        let error = Matrix3::from_diagonal(&Vector3::new(ixx, iyy, izz));
        let inertia = matrix(inertia_kg_m2) + error;
        all_within("inertia_kg_m2", inertia.as_slice(), 1e6)?;
        // Sylvester's criterion: the leading minors of a positive definite matrix are positive.
        let minors = [
            inertia.m11,
            inertia.m11 * inertia.m22 - inertia.m12 * inertia.m21,
            inertia.determinant(),
        ];
        for minor in minors {
            in_range("leading minor of the inertia", minor, 1e-12, 1e18)?;
        }
        let inverse = inertia.try_inverse().unwrap_or_else(Matrix3::zeros);
        Ok(Self { inertia, inverse })
    }

    /// Angular acceleration (rad/s²) under a torque (N·m) at an angular velocity (rad/s), body
    /// axes.
    pub fn angular_acceleration(&self, torque: &Vector3<f64>, rate: &Vector3<f64>) -> Vector3<f64> {
        self.inverse * (torque - rate.cross(&(self.inertia * rate)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOMINAL: [[f64; 3]; 3] = [[2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 4.0]];

    /// Euler's equation about principal axes, by hand.
    #[test]
    fn eulers_equation_with_the_sum() {
        let spacecraft = InertiaError::new(&NOMINAL, &[2.0, 0.0, 1.0]).unwrap(); // 4, 3, 5
        let rate = Vector3::new(1.0, 2.0, 3.0);
        let got = spacecraft.angular_acceleration(&Vector3::new(8.0, 9.0, 10.0), &rate);
        let expected = [
            (8.0 - (5.0 - 3.0) * 6.0) / 4.0,
            (9.0 - (4.0 - 5.0) * 3.0) / 3.0,
            (10.0 - (3.0 - 4.0) * 2.0) / 5.0,
        ];
        assert!((got - Vector3::from(expected)).norm() < 1e-12, "{got}");
    }

    #[test]
    fn no_inertia_is_refused() {
        let error = InertiaError::new(&NOMINAL, &[-2.0, 0.0, 0.0]).unwrap_err();
        assert_eq!(error.received, 0.0);
    }
}
