//! The docking mechanism: contact forces on the moving craft at one instant.
//!
//! The robot is stiff: contact does not move it. The force therefore depends on pose and twist
//! alone and is evaluated only when somebody looks.

use super::checks::check_all;
use super::settings::{MechanismSettings, WallSettings};
use anyhow::{Context, Result, ensure};
use nalgebra::Vector3;
use softdock_control::effects::mechanism::lever::{tip_motion, wrench_at_origin};
use softdock_control::effects::mechanism::plane_contact::{PlaneContact, PlaneParameters};
use softdock_control::frames::{Pose, Twist, Wrench, vector};

/// Planes that a mechanism can have.
pub const MAX_WALLS: usize = 8;

/// All contacts at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Contact {
    /// At M, in M axes.
    pub(super) wrench: Wrench<f64>,
    /// Penetration of each wall, m; negative is the distance, unused walls are 0.
    pub(super) penetration_m: [f64; MAX_WALLS],
}

/// Planes, each with the tip that it stops.
#[derive(Clone, Debug)]
pub(super) struct Mechanism {
    walls: Vec<(PlaneContact<f64>, Vector3<f64>)>,
}

impl Mechanism {
    pub(super) fn new(settings: &MechanismSettings) -> Result<Self> {
        let count = settings.walls.len();
        ensure!(
            count <= MAX_WALLS,
            "rig.mechanism.walls: {count} walls, allowed are 0 to {MAX_WALLS}"
        );
        let walls = settings.walls.iter().enumerate().map(|(i, wall)| {
            let section = || format!("in [[rig.mechanism.walls]] number {}", i + 1);
            plane(wall).with_context(section)
        });
        Ok(Self {
            walls: walls.collect::<Result<_>>()?,
        })
    }

    /// Forces for a pose C_from_M and the twist of M.
    pub(super) fn evaluate(&self, c_from_m: &Pose<f64>, twist: &Twist<f64>) -> Contact {
        let mut contact = Contact {
            wrench: Wrench::zero(),
            penetration_m: [0.0; MAX_WALLS],
        };
        for ((plane, tip_m), penetration_m) in self.walls.iter().zip(&mut contact.penetration_m) {
            let (tip, velocity) = tip_motion(c_from_m, twist, tip_m);
            let touch = plane.evaluate(&tip, &velocity);
            *penetration_m = touch.penetration_m;
            if touch.penetration_m > 0.0 {
                contact.wrench =
                    contact.wrench + wrench_at_origin(&c_from_m.rotation, &touch.force, tip_m);
            }
        }
        contact
    }
}

fn plane(wall: &WallSettings) -> Result<(PlaneContact<f64>, Vector3<f64>)> {
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
    Ok((plane, vector(&wall.tip_m)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::drive::pose;

    fn wall(point_m: [f64; 3], normal: [f64; 3], tip_m: [f64; 3]) -> WallSettings {
        WallSettings {
            point_m,
            normal,
            tip_m,
            stiffness_n_per_m: 1e5,
            damping_n_s_per_m: 0.0,
            damping_onset_m: 0.0,
            gap_m: 0.0,
            friction_coefficient: 0.0,
            smoothing_speed_m_s: 1e-3,
        }
    }

    /// An oblique stop meets a tip off the axis of a turned craft: force along the normal, torque
    /// by the lever, both in M axes.
    #[test]
    fn oblique_and_off_centre() {
        let walls = vec![wall([0.1, 0.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.5, 0.0])];
        let mechanism = Mechanism::new(&MechanismSettings { walls }).unwrap();
        // M turned by 90 deg about z: its y axis is C's -x, so the tip is at x = p_x - 0.5.
        let at = pose(&[0.602, 0.0, 0.0, std::f64::consts::FRAC_PI_2, 0.0, 0.0]);
        let contact = mechanism.evaluate(&at, &Twist::zero());
        let depth = 0.002 / 2.0_f64.sqrt();
        assert!((contact.penetration_m[0] - depth).abs() < 1e-12);
        let share = 1e5 * depth / 2.0_f64.sqrt(); // force in C: (-share, share, 0); in M: (share, share, 0)
        let expected = [share, share, 0.0, 0.0, 0.0, -0.5 * share];
        for (got, expected) in contact.wrench.get().iter().zip(expected) {
            assert!((got - expected).abs() < 1e-6, "{got} {expected}");
        }
    }

    #[test]
    fn a_rod_between_two_stops_is_pushed_back_by_each() {
        let walls = vec![
            wall([0.01, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0; 3]),
            wall([-0.01, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]),
        ];
        let mechanism = Mechanism::new(&MechanismSettings { walls }).unwrap();
        let force = |x: f64| {
            mechanism
                .evaluate(&pose(&[x, 0.0, 0.0, 0.0, 0.0, 0.0]), &Twist::zero())
                .wrench
                .force
                .x
        };
        assert!((force(0.011) + 100.0).abs() < 1e-6 && (force(-0.012) - 200.0).abs() < 1e-6);
        assert_eq!(force(0.0), 0.0);
    }

    #[test]
    fn errors_name_the_wall() {
        let mut soft = wall([0.0; 3], [1.0, 0.0, 0.0], [0.0; 3]);
        soft.stiffness_n_per_m = -5.0;
        let walls = vec![wall([0.0; 3], [1.0, 0.0, 0.0], [0.0; 3]), soft];
        let error = format!(
            "{:#}",
            Mechanism::new(&MechanismSettings { walls }).unwrap_err()
        );
        let expected = "in [[rig.mechanism.walls]] number 2: stiffness_n_per_m = -5: allowed is 0 to 100000000";
        assert_eq!(error, expected);
    }
}
