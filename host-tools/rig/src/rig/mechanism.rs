//! The docking mechanism: contact and guide forces on the moving spacecraft at one instant.
//!
//! The robot is stiff: contact does not move it. The force therefore depends on pose and twist
//! alone, and is evaluated only when somebody looks; only a hidden hysteresis of the guide
//! remembers the way.

use super::drive::Axes;
use super::guide::Guide;
use super::hidden::Hidden;
use super::settings::MechanismSettings;
use super::wall::Wall;
use anyhow::{Context, Result, ensure};
use nalgebra::Vector3;
use softdock_analysis::model::load::{on_tip, tip_motion};
use softdock_control::frames::{Pose, Twist, Wrench, vector};

/// Planes that a mechanism can have.
pub const MAX_WALLS: usize = 8;

/// All contacts at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Contact {
    /// Of the walls, at M, in M axes.
    pub(super) wrench: Wrench<f64>,
    /// Of the guide and the cables, likewise.
    pub(super) guide: Wrench<f64>,
    /// Penetration of each wall, m; negative is the distance, unused walls are 0.
    pub(super) penetration_m: [f64; MAX_WALLS],
}

/// Planes, each with the tip that it stops, and the guide.
#[derive(Clone, Debug)]
pub(super) struct Mechanism {
    walls: Vec<Wall>,
    guide: Guide,
}

impl Mechanism {
    /// The mechanism with M at `start`.
    pub(super) fn new(
        settings: &MechanismSettings,
        hidden: &[Hidden],
        start: &Axes,
        sensor: Vector3<f64>,
    ) -> Result<Self> {
        let count = settings.walls.len();
        ensure!(
            count <= MAX_WALLS,
            "rig.mechanism.walls: {count} walls, allowed are 0 to {MAX_WALLS}"
        );
        let tips = settings.guide.iter().map(|guide| guide.tip_m);
        let mut tips = tips.chain(settings.walls.iter().map(|wall| wall.tip_m));
        let tip = tips.next().map_or_else(Vector3::zeros, |tip| vector(&tip));
        let guide = Guide::new(settings.guide.as_ref(), hidden, start, [tip, sensor])?;
        let walls = settings.walls.iter().enumerate().map(|(i, wall)| {
            let section = || format!("in [[rig.mechanism.walls]] number {}", i + 1);
            Wall::new(wall, i + 1, hidden, &guide.axis).with_context(section)
        });
        Ok(Self {
            walls: walls.collect::<Result<_>>()?,
            guide,
        })
    }

    /// Moves what remembers to where an integration step ends.
    pub(super) fn advance(&mut self, position: &Axes) {
        self.guide.advance(position);
    }

    /// Forces for a pose C_from_M and the twist of M.
    pub(super) fn evaluate(&self, c_from_m: &Pose<f64>, twist: &Twist<f64>) -> Contact {
        let mut contact = Contact {
            wrench: Wrench::zero(),
            guide: self.guide.wrench(c_from_m, twist),
            penetration_m: [0.0; MAX_WALLS],
        };
        for (wall, penetration_m) in self.walls.iter().zip(&mut contact.penetration_m) {
            let (tip, velocity) = tip_motion(c_from_m, twist, &wall.tip_m);
            let touch = wall.evaluate(&tip, &velocity);
            *penetration_m = touch.penetration_m;
            if touch.penetration_m > 0.0 {
                contact.wrench = contact.wrench + on_tip(c_from_m, &wall.tip_m, &touch.force);
            }
        }
        contact
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::drive::pose;
    use crate::rig::settings::WallSettings;

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

    fn mechanism(walls: Vec<WallSettings>) -> Result<Mechanism> {
        let settings = MechanismSettings { walls, guide: None };
        Mechanism::new(&settings, &[], &[0.0; 6], Vector3::zeros())
    }

    /// An oblique stop meets a tip off the axis of a turned spacecraft: force along the normal, torque
    /// by the lever, both in M axes.
    #[test]
    fn oblique_and_off_centre() {
        let walls = vec![wall([0.1, 0.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.5, 0.0])];
        let mechanism = mechanism(walls).unwrap();
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
        let mechanism = mechanism(walls).unwrap();
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
        let error = format!("{:#}", mechanism(walls).unwrap_err());
        let expected = "in [[rig.mechanism.walls]] number 2: `stiffness_n_per_m` is -5; allowed is 0 to 100000000";
        assert_eq!(error, expected);
    }
}
