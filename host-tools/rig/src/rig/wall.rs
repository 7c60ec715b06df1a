//! One wall of the mechanism: `pen = −n·(tip − point) − gap`, `N = max(0, k pen + c onset dpen/dt)`
//! while pen > 0, `F = N n + friction` (Kelvin-Voigt, clipped because a wall cannot pull), and what
//! hidden effects make of it.

use super::checks::{check, check_all};
use super::hidden::{self, Hidden};
use super::settings::WallSettings;
use anyhow::Result;
use nalgebra::Vector3;
use softdock_control::frames::vector;
use softdock_physics::effects::mechanism::contact_coulomb;
use softdock_physics::effects::{Facing, Group, Law, Penetration};

/// Contact of the tip with a wall at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Contact {
    /// Penetration into the spring, m; negative is the distance to it.
    pub(super) penetration_m: f64,
    /// Force on the tip, N, axes of C.
    pub(super) force: Vector3<f64>,
    /// Energy in the spring, J; in the next field its rate of change, W.
    pub(super) stored_j: f64,
    pub(super) charging_w: f64,
}

/// An elastic plane and the tip that it stops.
#[derive(Clone, Debug)]
pub(super) struct Wall {
    /// The point of M that touches, m.
    pub(super) tip_m: Vector3<f64>,
    normal: Vector3<f64>,
    facing: Facing,
    /// The spring begins where n·tip equals this, m.
    offset_m: f64,
    settings: WallSettings,
    /// Hidden effects of the contact, with their values.
    laws: Vec<(Law, Vec<f64>)>,
}

impl Wall {
    /// Wall number `number`, from 1, with the hidden effects of the contact; `axis` is the guide's
    /// free direction.
    pub(super) fn new(
        wall: &WallSettings,
        number: usize,
        hidden: &[Hidden],
        axis: &Vector3<f64>,
    ) -> Result<Self> {
        check_wall(wall)?;
        let normal = vector::<f64>(&wall.normal).normalize();
        let laws = hidden::in_order(hidden, Group::Mechanism);
        Ok(Self {
            tip_m: vector(&wall.tip_m),
            normal,
            facing: Facing {
                along_axis: normal.dot(axis),
                number,
            },
            offset_m: vector::<f64>(&wall.point_m).dot(&normal) - wall.gap_m,
            settings: wall.clone(),
            laws: laws
                .filter(|(effect, _)| hidden::acts_at_walls(effect))
                .map(|(effect, values)| (effect.law, values))
                .collect(),
        })
    }

    /// Force on the tip at a position (m) with a velocity (m/s), axes of C.
    pub(super) fn evaluate(&self, tip: &Vector3<f64>, velocity: &Vector3<f64>) -> Contact {
        let wall = &self.settings;
        let depth = self.depth(tip);
        if depth <= 0.0 {
            return Contact {
                penetration_m: depth,
                force: Vector3::zeros(),
                stored_j: 0.0,
                charging_w: 0.0,
            };
        }
        let receding = self.normal.dot(velocity);
        let touch = Penetration {
            depth,
            rate: -receding,
            onset: match wall.damping_onset_m > 1e-9 {
                true => (depth / wall.damping_onset_m).min(1.0),
                false => 1.0,
            },
        };
        let push = self.push(&touch);
        let force = self.force(push, &(velocity - self.normal * receding));
        Contact {
            penetration_m: depth,
            force,
            stored_j: 0.5 * wall.stiffness_n_per_m * depth * depth,
            charging_w: wall.stiffness_n_per_m * depth * touch.rate,
        }
    }

    /// Penetration into the spring, m; negative is the distance to it.
    fn depth(&self, tip: &Vector3<f64>) -> f64 {
        let mut depth = self.offset_m - self.normal.dot(tip);
        for (law, p) in &self.laws {
            if let Law::Depth(law) = law {
                depth = law(p, depth, &self.facing);
            }
        }
        depth
    }

    /// Size of the force along the normal, N.
    fn push(&self, touch: &Penetration) -> f64 {
        let wall = &self.settings;
        let mut push = wall.stiffness_n_per_m * touch.depth
            + wall.damping_n_s_per_m * touch.onset * touch.rate;
        for (law, p) in &self.laws {
            if let Law::Push(law) = law {
                push += law(p, touch);
            }
        }
        push.max(0.0)
    }

    /// The push along the normal, N, with the friction on a tip that slides (m/s) across it.
    fn force(&self, push: f64, sliding: &Vector3<f64>) -> Vector3<f64> {
        let wall = &self.settings;
        let nominal = [wall.friction_coefficient, wall.smoothing_speed_m_s];
        let mut force = self.normal * push;
        if wall.friction_coefficient != 0.0 {
            force += contact_coulomb::force(&nominal, push, sliding);
        }
        for (law, p) in &self.laws {
            if let Law::Friction(law) = law {
                force += law(p, push, sliding);
            }
        }
        force
    }
}

fn check_wall(wall: &WallSettings) -> Result<()> {
    let normal = vector::<f64>(&wall.normal);
    check_all("tip_m", &wall.tip_m, -100.0, 100.0)?;
    check("normal length", normal.norm(), 1e-6, 1e6)?;
    check("gap_m", wall.gap_m, 0.0, 10.0)?;
    check("stiffness_n_per_m", wall.stiffness_n_per_m, 0.0, 1e8)?;
    check("damping_n_s_per_m", wall.damping_n_s_per_m, 0.0, 1e7)?;
    check("damping_onset_m", wall.damping_onset_m, 0.0, 1.0)?;
    let offset_m = vector::<f64>(&wall.point_m).dot(&normal.normalize());
    check("point_m", offset_m, -1e3, 1e3)?;
    check("friction_coefficient", wall.friction_coefficient, 0.0, 10.0)?;
    if wall.friction_coefficient != 0.0 {
        check("smoothing_speed_m_s", wall.smoothing_speed_m_s, 1e-4, 1.0)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall at x = 0.02 m whose free side is −x.
    const WALL: WallSettings = WallSettings {
        point_m: [0.02, 0.0, 0.0],
        normal: [-2.0, 0.0, 0.0],
        tip_m: [0.0; 3],
        stiffness_n_per_m: 1e4,
        damping_n_s_per_m: 100.0,
        damping_onset_m: 0.0,
        gap_m: 0.001,
        friction_coefficient: 0.5,
        smoothing_speed_m_s: 0.001,
    };

    fn at(wall: &WallSettings, x: f64, v: [f64; 3]) -> Contact {
        let wall = Wall::new(wall, 1, &[], &Vector3::x()).unwrap();
        wall.evaluate(&Vector3::new(x, 0.3, 0.0), &v.into())
    }

    #[test]
    fn known_forces() {
        let free = at(&WALL, 0.0205, [1.0, 0.0, 0.0]); // inside the gap
        assert!((free.penetration_m + 0.0005).abs() < 1e-8 && free.force == Vector3::zeros());
        let pressed = at(&WALL, 0.023, [0.05, 0.0, 0.0]).force; // 1e4 · 2 mm + 100 · 50 mm/s
        assert!((pressed.x + 25.0).abs() < 1e-3, "{pressed}");
        let sliding = at(&WALL, 0.023, [0.0, 0.0, 0.5]).force;
        assert!((sliding.x + 20.0).abs() < 1e-3 && (sliding.z + 10.0).abs() < 1e-3);
        let pulled = at(&WALL, 0.023, [-0.5, 0.0, 0.5]).force; // damping would pull with 30 N
        assert_eq!(pulled, Vector3::zeros());
    }

    #[test]
    fn damping_can_set_in_without_a_jump() {
        let soft = WallSettings {
            damping_onset_m: 0.002,
            ..WALL
        };
        let force = at(&soft, 0.0215, [0.05, 0.0, 0.0]).force;
        assert!((force.x + 5.0 + 1.25).abs() < 1e-9); // a quarter of the damping at 0.5 mm of 2 mm
    }

    #[test]
    fn a_normal_without_direction_is_refused() {
        let flat = WallSettings {
            normal: [0.0; 3],
            ..WALL
        };
        let error = Wall::new(&flat, 1, &[], &Vector3::x()).unwrap_err();
        assert!(
            error.to_string().contains("`normal length` is 0"),
            "{error}"
        );
    }
}
