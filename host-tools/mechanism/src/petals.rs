//! Three guide petals at 120° that lead a ring home.

use crate::contact::Touch;
use nalgebra::{ComplexField, RealField, Vector3};
use serde::{Deserialize, Serialize};
use softdock_control::frames::Pose;
use softdock_control::range::{SettingsError, in_range};

/// Petals on J that point along x and lean inwards, and the face behind them. Each petal touches the inner edge of a ring on
/// the petal's middle line; the face touches the ring at the same three places.
///
/// ```text
///      |\  petal, γ between its back and x
///      | \
///      |  o edge of the ring
///   ---J-------> x
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Petals {
    /// γ, rad. The ring slides home along the petals if the friction coefficient is below cot γ.
    pub angle_rad: f64,
    /// Length along x, m.
    pub length_m: f64,
    /// Clearance between the petals and the edge of a ring that is home, m.
    pub clearance_m: f64,
    /// Radius of the ring's edge, m.
    pub edge_radius_m: f64,
}

/// Number of places where the ring can be touched: three by petals and three by the face.
pub(crate) const TOUCHES: usize = 6;

impl Petals {
    pub(crate) fn validate(&self) -> Result<(), SettingsError> {
        in_range("petals.angle_rad", self.angle_rad, 0.05, 1.5)?;
        in_range("petals.length_m", self.length_m, 1e-3, 10.0)?;
        in_range("petals.edge_radius_m", self.edge_radius_m, 0.01, 10.0)?;
        in_range(
            "petals.clearance_m",
            self.clearance_m,
            0.0,
            self.edge_radius_m,
        )
    }

    /// For each petal: position of the ring's edge in P and in J, m, and the outward direction.
    fn edges(&self, p_from_j: &Pose<f64>, ring: &Pose<f64>) -> [[Vector3<f64>; 3]; 3] {
        std::array::from_fn(|i| {
            let (sin, cos) = ComplexField::sin_cos(i as f64 * f64::two_pi() / 3.0);
            let outwards = Vector3::new(0.0, cos, sin);
            let axis = ring.rotation * Vector3::x();
            let in_p = p_from_j.rotation * outwards;
            let across = in_p - axis * axis.dot(&in_p);
            let edge = ring.translation.vector + across.normalize() * self.edge_radius_m;
            [
                edge,
                p_from_j.inverse_transform_point(&edge.into()).coords,
                outwards,
            ]
        })
    }

    /// Touches of the ring, as forces on J: those of the petals, then those of the face.
    pub(crate) fn touches(&self, p_from_j: &Pose<f64>, ring: &Pose<f64>) -> [Touch; TOUCHES] {
        let (sin, cos) = ComplexField::sin_cos(self.angle_rad);
        let root = self.edge_radius_m - self.clearance_m;
        let edges = self.edges(p_from_j, ring);
        std::array::from_fn(|i| {
            let [edge, in_j, outwards] = edges[i % 3];
            let (depth_m, out) = if i < 3 {
                let behind_back = (root - outwards.dot(&in_j)) * cos - in_j.x * sin;
                let before_tip = self.length_m - in_j.x;
                if behind_back < before_tip {
                    (behind_back, Vector3::x() * sin + outwards * cos)
                } else {
                    (before_tip, Vector3::x())
                }
            } else {
                (-in_j.x, Vector3::x())
            };
            Touch {
                point: edge,
                normal: p_from_j.rotation * -out,
                depth_m,
            }
        })
    }

    /// Widest gap between the ring and the face, m; None unless the ring lies around the petals.
    pub(crate) fn gap_m(&self, p_from_j: &Pose<f64>, ring: &Pose<f64>) -> Option<f64> {
        let edges = self.edges(p_from_j, ring);
        let inside =
            |[_, in_j, outwards]: &[Vector3<f64>; 3]| outwards.dot(in_j) > 0.5 * self.edge_radius_m;
        let gaps = edges.iter().map(|[_, in_j, _]| in_j.x);
        edges
            .iter()
            .all(inside)
            .then(|| gaps.fold(f64::NEG_INFINITY, f64::max))
    }
}

/// Known answers from statics: three planes at 120°, whose normals have sin γ along the axis and cos γ across it, give
/// Σ n nᵀ = 3 diag(sin²γ, ½ cos²γ, ½ cos²γ), and all their normals meet in one point of the axis.
#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Translation3, UnitQuaternion};

    const PETALS: Petals = Petals {
        angle_rad: 0.7,
        length_m: 0.2,
        clearance_m: 0.0,
        edge_radius_m: 0.6,
    };
    const STIFFNESS_N_PER_M: f64 = 5e5;
    /// Depth along the axis at which all three petals touch, m.
    const PRESSED_M: f64 = 1e-5;

    /// Common point of the normals, on x of P.
    fn centre() -> Vector3<f64> {
        Vector3::new(-0.6 * 0.7_f64.tan(), 0.0, 0.0)
    }

    /// Force of smooth petals on J against a ring at home, and its torque about the common point.
    fn push(p_from_j: Pose<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let touches = PETALS.touches(&p_from_j, &Pose::identity());
        let forces = touches[..3].iter().map(|touch| {
            assert!(touch.depth_m > 0.0, "{touch:?}");
            let force = touch.normal * (STIFFNESS_N_PER_M * touch.depth_m);
            (force, (touch.point - centre()).cross(&force))
        });
        forces.fold(
            (Vector3::zeros(), Vector3::zeros()),
            |(force, torque), (f, t)| (force + f, torque + t),
        )
    }

    #[test]
    fn they_are_as_stiff_in_every_direction_across() {
        let (sin, cos) = 0.7_f64.sin_cos();
        for direction in 0..12 {
            let across =
                UnitQuaternion::from_scaled_axis(Vector3::x() * 0.5 * f64::from(direction))
                    * Vector3::y()
                    * 5e-6;
            let (force, torque) = push(Pose::translation(PRESSED_M, across.y, across.z));
            let along = Vector3::x() * (sin * sin * PRESSED_M);
            let expected = (along + across * (0.5 * cos * cos)) * (-3.0 * STIFFNESS_N_PER_M);
            assert!(
                (force - expected).norm() < 1e-9 * expected.norm(),
                "{force}"
            );
            assert!(torque.norm() < 1e-9 * expected.norm(), "{torque}");
        }
    }

    /// J can be tilted about the common point of the normals without a force.
    #[test]
    fn a_tilt_about_the_common_point_is_free() {
        let (still, _) = push(Pose::translation(PRESSED_M, 0.0, 0.0));
        let to_centre = Translation3::from(centre());
        for axis in [Vector3::y(), Vector3::z()] {
            let turned = |about: Translation3<f64>| {
                let tilt = UnitQuaternion::from_scaled_axis(axis * 1e-6);
                push(Translation3::new(PRESSED_M, 0.0, 0.0) * about * tilt * about.inverse()).0
            };
            assert!((turned(to_centre) - still).norm() < 1e-4);
            assert!((turned(Translation3::identity()) - still).norm() > 0.1);
        }
    }
}
