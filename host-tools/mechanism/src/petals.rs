//! Three guide petals at 120° that lead a ring home.

use crate::contact::Touch;
use nalgebra::{ComplexField, RealField, Vector3};
use serde::{Deserialize, Serialize};
use softdock_control::frames::Pose;
use softdock_control::range::{SettingsError, in_range};

/// Petals on J that point along x and lean inwards, and the face behind them. Each meets the inner
/// edge of a ring where its own middle line does; the face meets the ring at the same three places.
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
    /// γ, rad. The ring slides home along them for any friction below cot γ.
    pub angle_rad: f64,
    /// Along x, m.
    pub length_m: f64,
    /// Between petals and edge of a ring that is home, m.
    pub clearance_m: f64,
    /// Of the ring's edge, m.
    pub edge_radius_m: f64,
}

/// Places where petals and face can touch: three and three.
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

    /// Where the ring's edge is before each petal, in P and in J, m.
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

    /// What touches the ring, as forces on J: the petals, then the face.
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

    /// Widest gap between the ring and the face, m, if the ring lies around the petals.
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
