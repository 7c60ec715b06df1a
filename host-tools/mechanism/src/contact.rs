//! A point that touches a surface: elastic, damped, with dry friction that sticks.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use softdock_control::range::{SettingsError, in_range};

/// Place and depth of a touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Touch {
    /// Point in P, m.
    pub(crate) point: Vector3<f64>,
    /// Unit normal out of the surface, in P.
    pub(crate) normal: Vector3<f64>,
    /// Depth, m; no touch unless it is positive.
    pub(crate) depth_m: f64,
}

/// Force of a touch, its stored energy and its dissipated power.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Push {
    /// Force in axes of P, N.
    pub(crate) force: Vector3<f64>,
    pub(crate) stored_j: f64,
    pub(crate) loss_w: f64,
}

/// An elastic surface. Along the normal `N = max(0, k d + c dd/dt)`; across it a spring as stiff that
/// yields at `μ N` (Cundall and Strack 1979), so that a point at rest stays where it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Surface {
    /// k, N/m.
    pub stiffness_n_per_m: f64,
    /// c, N·s/m.
    #[serde(default)]
    pub damping_n_s_per_m: f64,
    /// μ.
    #[serde(default)]
    pub friction_coefficient: f64,
}

impl Surface {
    pub(crate) fn validate(&self) -> Result<(), SettingsError> {
        in_range(
            "surface.stiffness_n_per_m",
            self.stiffness_n_per_m,
            1.0,
            1e9,
        )?;
        in_range(
            "surface.damping_n_s_per_m",
            self.damping_n_s_per_m,
            0.0,
            1e7,
        )?;
        in_range(
            "surface.friction_coefficient",
            self.friction_coefficient,
            0.0,
            10.0,
        )
    }

    /// Normal force, N.
    fn normal_n(&self, touch: &Touch, velocity: &Vector3<f64>) -> f64 {
        if touch.depth_m <= 0.0 {
            return 0.0;
        }
        let rate = -touch.normal.dot(velocity);
        (self.stiffness_n_per_m * touch.depth_m + self.damping_n_s_per_m * rate).max(0.0)
    }

    /// Limits the deflection of the friction spring to what friction bears at this normal force; m.
    fn held(&self, touch: &Touch, normal_n: f64, deflection: &Vector3<f64>) -> Vector3<f64> {
        let across = deflection - touch.normal * touch.normal.dot(deflection);
        let longest = self.friction_coefficient * normal_n / self.stiffness_n_per_m;
        let length = across.norm();
        if length <= longest {
            across
        } else {
            across * (longest / length)
        }
    }

    /// Whether friction holds a point at rest with this deflection of the friction spring.
    pub(crate) fn sticks(&self, touch: &Touch, deflection: &Vector3<f64>) -> bool {
        let normal_n = self.normal_n(touch, &Vector3::zeros());
        let across = deflection - touch.normal * touch.normal.dot(deflection);
        self.stiffness_n_per_m * across.norm() < self.friction_coefficient * normal_n
    }

    /// Force on a point with this velocity (axes of P, m/s) and this deflection of the friction spring (m).
    pub(crate) fn push(
        &self,
        touch: &Touch,
        velocity: &Vector3<f64>,
        deflection: &Vector3<f64>,
    ) -> Push {
        if touch.depth_m <= 0.0 {
            return Push::default();
        }
        let normal_n = self.normal_n(touch, velocity);
        let held = self.held(touch, normal_n, deflection);
        let elastic = self.stiffness_n_per_m * touch.depth_m;
        let rate = -touch.normal.dot(velocity);
        Push {
            force: touch.normal * normal_n - held * self.stiffness_n_per_m,
            stored_j: 0.5
                * (elastic * touch.depth_m + self.stiffness_n_per_m * held.norm_squared()),
            loss_w: (normal_n - elastic) * rate,
        }
    }

    /// Returns the deflection of the friction spring after a step, and the energy that sliding dissipated, J: the work of the
    /// mean force less the increase of the stored energy.
    pub(crate) fn slide(
        &self,
        touch: &Touch,
        velocity: &Vector3<f64>,
        deflection: &Vector3<f64>,
        step_s: f64,
    ) -> (Vector3<f64>, f64) {
        let across = velocity - touch.normal * touch.normal.dot(velocity);
        let stretched = deflection + across * step_s;
        let normal_n = self.normal_n(touch, velocity);
        let held = self.held(touch, normal_n, &stretched);
        let slip = stretched - held;
        (
            held,
            0.5 * self.stiffness_n_per_m * (deflection + held).dot(&slip),
        )
    }
}
