//! Loads on the docking plane, in the components that interface standards limit.

use nalgebra::ComplexField;
use serde::{Deserialize, Serialize};
use softdock_control::frames::Wrench;

/// Largest loads between the two sides, at J in axes of P; or their limits, None where there is no limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Loads {
    /// Force along x that pushes the sides apart, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compression_n: Option<f64>,
    /// Force along x that pulls the sides together, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tension_n: Option<f64>,
    /// Force across x, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shear_n: Option<f64>,
    /// Torque about x, N·m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torsion_nm: Option<f64>,
    /// Torque across x, N·m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bending_nm: Option<f64>,
}

impl Loads {
    /// The loads of one wrench on J, in axes of P.
    pub fn of(wrench: &Wrench<f64>) -> Self {
        let (force, torque) = (wrench.force, wrench.torque);
        Self {
            compression_n: Some((-force.x).max(0.0)),
            tension_n: Some(force.x.max(0.0)),
            shear_n: Some(ComplexField::hypot(force.y, force.z)),
            torsion_nm: Some(torque.x.abs()),
            bending_nm: Some(ComplexField::hypot(torque.y, torque.z)),
        }
    }

    /// The larger value of each load.
    pub fn largest(&self, other: &Self) -> Self {
        let larger = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (one, none) => one.or(none),
        };
        Self {
            compression_n: larger(self.compression_n, other.compression_n),
            tension_n: larger(self.tension_n, other.tension_n),
            shear_n: larger(self.shear_n, other.shear_n),
            torsion_nm: larger(self.torsion_nm, other.torsion_nm),
            bending_nm: larger(self.bending_nm, other.bending_nm),
        }
    }

    /// Each load with its name, in the order of reports.
    pub fn named(&self) -> [(&'static str, Option<f64>); 5] {
        [
            ("compression_n", self.compression_n),
            ("tension_n", self.tension_n),
            ("shear_n", self.shear_n),
            ("torsion_nm", self.torsion_nm),
            ("bending_nm", self.bending_nm),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loads_are_named_by_their_direction() {
        let pushed = Loads::of(&Wrench::of(&[-5.0, 3.0, 4.0, -2.0, 6.0, 8.0]));
        let pulled = Loads::of(&Wrench::of(&[7.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
        let values = pushed
            .largest(&pulled)
            .named()
            .map(|(_, value)| value.unwrap());
        assert_eq!(values, [5.0, 7.0, 5.0, 2.0, 10.0]);
    }
}
