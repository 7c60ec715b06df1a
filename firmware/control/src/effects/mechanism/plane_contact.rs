//! Contact of a tip with an elastic, damped plane: `pen = −n·(tip − point) − gap`,
//! `N = max(0, k pen + damping)` while pen > 0, `F = N n + friction`.
//!
//! Not an effect by itself but the nominal contact law of the rig: a
//! linear spring and damper (Kelvin-Voigt), clipped because a wall cannot pull.

use super::contact_coulomb::CoulombFriction;
use super::contact_damping::ContactDamping;
use crate::frames::vector;
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;
use nalgebra::Vector3;

/// Parameters of a plane, in C axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneParameters {
    /// A point of the plane, m.
    pub point_m: [f64; 3],
    /// Outward normal, towards the free side; any length.
    pub normal: [f64; 3],
    /// Stiffness, N/m.
    pub stiffness_n_per_m: f64,
    /// Damping, N·s/m.
    pub damping_n_s_per_m: f64,
    /// Penetration over which damping sets in, m; 0: at once, with a jump of force at touch.
    pub damping_onset_m: f64,
    /// Play before the spring is met, m.
    pub gap_m: f64,
    /// Coulomb coefficient; 0: no friction.
    pub friction_coefficient: f64,
    /// Sliding speed at which friction is fully developed, m/s.
    pub smoothing_speed_m_s: f64,
}

/// What the plane does to the tip at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactForce<S: Scalar> {
    /// Penetration into the spring, m; negative is the distance to it.
    pub penetration_m: S,
    /// Force on the tip, N, axes of C.
    pub force: Vector3<S>,
}

/// A plane that pushes a tip back.
#[derive(Clone, Copy, Debug)]
pub struct PlaneContact<S: Scalar> {
    normal: Vector3<S>,
    /// The spring begins where n·tip equals this, m.
    offset_m: S,
    stiffness: S,
    damping: ContactDamping<S>,
    friction: Option<CoulombFriction<S>>,
}

impl<S: Scalar> PlaneContact<S> {
    /// Checks the parameters; the normal is normalised here.
    pub fn new(p: &PlaneParameters) -> Result<Self, SettingsError> {
        let normal = vector::<f64>(&p.normal);
        in_range("normal length", normal.norm(), 1e-6, 1e6)?;
        let normal = normal / normal.norm();
        in_range("gap_m", p.gap_m, 0.0, 10.0)?;
        in_range("stiffness_n_per_m", p.stiffness_n_per_m, 0.0, 1e8)?;
        let offset = vector::<f64>(&p.point_m).dot(&normal);
        in_range("point_m", offset, -1e3, 1e3)?;
        let friction = if p.friction_coefficient == 0.0 {
            None
        } else {
            Some(CoulombFriction::new(
                p.friction_coefficient,
                p.smoothing_speed_m_s,
            )?)
        };
        Ok(Self {
            normal: normal.map(S::of),
            offset_m: S::of(offset - p.gap_m),
            stiffness: S::of(p.stiffness_n_per_m),
            damping: ContactDamping::new(p.damping_n_s_per_m, p.damping_onset_m)?,
            friction,
        })
    }

    /// Force on a tip at this position (m) with this velocity (m/s), axes of C.
    pub fn evaluate(&self, tip: &Vector3<S>, velocity: &Vector3<S>) -> ContactForce<S> {
        let penetration_m = self.offset_m - self.normal.dot(tip);
        if penetration_m <= S::zero() {
            return ContactForce {
                penetration_m,
                force: Vector3::zeros(),
            };
        }
        let receding = self.normal.dot(velocity);
        let push = self.stiffness * penetration_m + self.damping.force(penetration_m, -receding);
        let normal_force = push.max(S::zero());
        let mut force = self.normal * normal_force;
        if let Some(friction) = &self.friction {
            force += friction.force(normal_force, &(velocity - self.normal * receding));
        }
        ContactForce {
            penetration_m,
            force,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Fixed;

    /// A wall at x = 0.02 m whose free side is −x.
    const WALL: PlaneParameters = PlaneParameters {
        point_m: [0.02, 0.0, 0.0],
        normal: [-2.0, 0.0, 0.0],
        stiffness_n_per_m: 1e4,
        damping_n_s_per_m: 100.0,
        damping_onset_m: 0.0,
        gap_m: 0.001,
        friction_coefficient: 0.5,
        smoothing_speed_m_s: 0.001,
    };

    fn known_forces<S: Scalar>() {
        let wall = PlaneContact::<S>::new(&WALL).unwrap();
        let at = |x: f64, v: [f64; 3]| wall.evaluate(&vector(&[x, 0.3, 0.0]), &vector(&v));
        let free = at(0.0205, [1.0, 0.0, 0.0]); // inside the gap
        assert!((free.penetration_m.get() + 0.0005).abs() < 1e-8 && free.force == Vector3::zeros());
        let pressed = at(0.023, [0.05, 0.0, 0.0]).force; // 1e4 · 2 mm + 100 · 50 mm/s
        assert!((pressed.x.get() + 25.0).abs() < 1e-3, "{pressed}");
        let sliding = at(0.023, [0.0, 0.0, 0.5]).force;
        assert!((sliding.x.get() + 20.0).abs() < 1e-3 && (sliding.z.get() + 10.0).abs() < 1e-3);
        let pulled = at(0.023, [-0.5, 0.0, 0.5]).force; // damping would pull with 30 N
        assert_eq!(pulled, Vector3::zeros());
    }

    #[test]
    fn known_answers() {
        known_forces::<f64>();
        known_forces::<Fixed>();
    }

    #[test]
    fn damping_can_set_in_without_a_jump() {
        let soft = PlaneParameters {
            damping_onset_m: 0.002,
            ..WALL
        };
        let wall = PlaneContact::<f64>::new(&soft).unwrap();
        let f = wall
            .evaluate(&vector(&[0.0215, 0.0, 0.0]), &vector(&[0.05, 0.0, 0.0]))
            .force;
        assert!((f.x + 5.0 + 1.25).abs() < 1e-9); // a quarter of the damping at 0.5 mm of 2 mm
    }

    #[test]
    fn a_normal_without_direction_is_refused() {
        let error = PlaneContact::<f64>::new(&PlaneParameters {
            normal: [0.0; 3],
            ..WALL
        })
        .unwrap_err();
        assert_eq!((error.field, error.received), ("normal length", 0.0));
    }
}
