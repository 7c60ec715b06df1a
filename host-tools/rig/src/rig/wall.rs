//! One wall of the mechanism: the nominal plane, and what hidden effects make of it.

use super::checks::{check_all, prefixed};
use super::hidden::{self, Hidden};
use super::settings::WallSettings;
use anyhow::Result;
use nalgebra::Vector3;
use softdock_control::effects::mechanism::contact_coulomb::CoulombFriction;
use softdock_control::effects::mechanism::contact_cubic::CubicSpring;
use softdock_control::effects::mechanism::contact_damping::ContactDamping;
use softdock_control::effects::mechanism::contact_deadzone::DeadZone;
use softdock_control::effects::mechanism::contact_stiffness::StiffnessError;
use softdock_control::effects::mechanism::hunt_crossley::HuntCrossley;
use softdock_control::effects::mechanism::plane_contact::{
    ContactForce, PlaneContact, PlaneParameters,
};
use softdock_control::effects::mechanism::wall_position::WallPosition;
use softdock_control::frames::vector;

/// An elastic plane and the tip that it stops.
#[derive(Clone, Debug)]
pub(super) struct Wall {
    /// The point of M that touches, m.
    pub(super) tip_m: Vector3<f64>,
    plane: PlaneContact<f64>,
    changed: Option<ChangedContact>,
}

impl Wall {
    /// A wall with the hidden effects of the contact; `axis` is the guide's free direction.
    pub(super) fn new(wall: &WallSettings, hidden: &[Hidden], axis: &Vector3<f64>) -> Result<Self> {
        check_all("tip_m", &wall.tip_m, -100.0, 100.0)?;
        let plane = PlaneContact::new(&PlaneParameters {
            point_m: wall.point_m,
            normal: wall.normal,
            stiffness_n_per_m: wall.stiffness_n_per_m,
            damping_n_s_per_m: wall.damping_n_s_per_m,
            damping_onset_m: wall.damping_onset_m,
            gap_m: wall.gap_m,
            friction_coefficient: wall.friction_coefficient,
            smoothing_speed_m_s: wall.smoothing_speed_m_s,
        })?;
        let effects = ContactEffects::new(wall, hidden)?;
        Ok(Self {
            tip_m: vector(&wall.tip_m),
            plane,
            changed: effects
                .map(|effects| ChangedContact::new(wall, axis, effects))
                .transpose()?,
        })
    }

    /// Force on the tip at a position (m) with a velocity (m/s), axes of C.
    pub(super) fn evaluate(
        &self,
        tip: &Vector3<f64>,
        velocity: &Vector3<f64>,
    ) -> ContactForce<f64> {
        match &self.changed {
            Some(changed) => changed.evaluate(tip, velocity),
            None => self.plane.evaluate(tip, velocity),
        }
    }
}

/// Hidden effects of the contact, each with the values that do nothing where it is not hidden.
#[derive(Clone, Debug)]
struct ContactEffects {
    position: WallPosition<f64>,
    play: DeadZone<f64>,
    stiffness: StiffnessError<f64>,
    cubic: CubicSpring<f64>,
    damping: ContactDamping<f64>,
    hunt_crossley: Option<HuntCrossley<f64>>,
    friction: Option<CoulombFriction<f64>>,
}

impl ContactEffects {
    /// `None` if no effect of the contact is hidden.
    fn new(wall: &WallSettings, hidden: &[Hidden]) -> Result<Option<Self>> {
        if !hidden
            .iter()
            .any(|h| hidden::AT_WALLS.contains(&h.id.as_str()))
        {
            return Ok(None);
        }
        let value = |id, name| hidden::find(hidden, id).map_or(0.0, |hidden| hidden.value(name));
        let damping = value("contact_damping", "damping_n_s_per_m");
        let hunt_crossley = hidden::find(hidden, "hunt_crossley").map(|h| {
            let [damping, exponent] = h.values(["damping_n_s_per_m2", "exponent"]);
            prefixed(
                "rig.hidden hunt_crossley.",
                HuntCrossley::new(damping, exponent),
            )
        });
        let friction = hidden::find(hidden, "contact_coulomb").map(|h| {
            let [coefficient, speed] = h.values(["friction_coefficient", "smoothing_speed_m_s"]);
            prefixed(
                "rig.hidden contact_coulomb.",
                CoulombFriction::new(coefficient, speed),
            )
        });
        Ok(Some(Self {
            position: WallPosition::new(value("wall_position", "shift_m"))?,
            play: DeadZone::new(value("contact_deadzone", "gap_m"))?,
            stiffness: StiffnessError::new(value("contact_stiffness", "stiffness_error_n_per_m"))?,
            cubic: CubicSpring::new(value("contact_cubic", "stiffness_n_per_m3"))?,
            damping: ContactDamping::new(damping, wall.damping_onset_m)?,
            hunt_crossley: hunt_crossley.transpose()?,
            friction: friction.transpose()?,
        }))
    }
}

/// A plane with hidden effects: the catalogue's pieces put together as [`PlaneContact`] does.
#[derive(Clone, Debug)]
struct ChangedContact {
    normal: Vector3<f64>,
    /// Component of the normal along the guide.
    normal_along_axis: f64,
    /// The nominal spring begins where n·tip equals this, m.
    offset_m: f64,
    spring: StiffnessError<f64>,
    damping: ContactDamping<f64>,
    friction: Option<CoulombFriction<f64>>,
    effects: ContactEffects,
}

impl ChangedContact {
    /// From a wall that [`PlaneContact::new`] has checked.
    fn new(wall: &WallSettings, axis: &Vector3<f64>, effects: ContactEffects) -> Result<Self> {
        let normal = vector::<f64>(&wall.normal).normalize();
        let friction = (wall.friction_coefficient != 0.0)
            .then(|| CoulombFriction::new(wall.friction_coefficient, wall.smoothing_speed_m_s));
        Ok(Self {
            normal,
            normal_along_axis: normal.dot(axis),
            offset_m: vector::<f64>(&wall.point_m).dot(&normal) - wall.gap_m,
            spring: StiffnessError::new(wall.stiffness_n_per_m)?,
            damping: ContactDamping::new(wall.damping_n_s_per_m, wall.damping_onset_m)?,
            friction: friction.transpose()?,
            effects,
        })
    }

    fn evaluate(&self, tip: &Vector3<f64>, velocity: &Vector3<f64>) -> ContactForce<f64> {
        let effects = &self.effects;
        let nominal_m = self.offset_m - self.normal.dot(tip);
        let distance_m = effects
            .position
            .penetration(nominal_m, self.normal_along_axis);
        let depth = effects.play.penetration(distance_m);
        if depth <= 0.0 {
            return ContactForce {
                penetration_m: distance_m.min(0.0),
                force: Vector3::zeros(),
            };
        }
        let receding = self.normal.dot(velocity);
        let push = self.spring.force(depth)
            + self.damping.force(depth, -receding)
            + effects.stiffness.force(depth)
            + effects.cubic.force(depth)
            + effects.damping.force(depth, -receding)
            + effects
                .hunt_crossley
                .map_or(0.0, |law| law.force(depth, -receding));
        let normal_force = push.max(0.0);
        let sliding = velocity - self.normal * receding;
        let mut force = self.normal * normal_force;
        for friction in self.friction.iter().chain(&effects.friction) {
            force += friction.force(normal_force, &sliding);
        }
        ContactForce {
            penetration_m: depth,
            force,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With effects of no size, the pieces give what the nominal plane gives.
    #[test]
    fn the_changed_contact_without_a_change_is_the_nominal_plane() {
        let wall = WallSettings {
            point_m: [0.01, 0.0, 0.0],
            normal: [-2.0, 1.0, 0.0],
            tip_m: [0.0; 3],
            stiffness_n_per_m: 5000.0,
            damping_n_s_per_m: 80.0,
            damping_onset_m: 0.001,
            gap_m: 0.002,
            friction_coefficient: 0.2,
            smoothing_speed_m_s: 1e-3,
        };
        let nothing = Hidden {
            id: "contact_cubic".to_owned(),
            parameters: [("stiffness_n_per_m3".to_owned(), 0.0)].into(),
        };
        let nominal = Wall::new(&wall, &[], &Vector3::x()).unwrap();
        let changed = Wall::new(&wall, &[nothing], &Vector3::x()).unwrap();
        assert!(changed.changed.is_some());
        let velocity = Vector3::new(0.01, -0.02, 0.03);
        for x in [-0.01, 0.011, 0.0125, 0.02] {
            let tip = Vector3::new(x, 0.001, 0.0);
            let (a, b) = (
                nominal.evaluate(&tip, &velocity),
                changed.evaluate(&tip, &velocity),
            );
            assert!((a.force - b.force).norm() < 1e-9, "{x}");
            assert!((a.penetration_m - b.penetration_m).abs() < 1e-12, "{x}");
        }
    }
}
