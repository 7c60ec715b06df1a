//! The spring rod: walls, each with the tip that it stops, and the guide.
//!
//! Its frames are those of the laboratory: P is C and J is M.

use super::drive::Axes;
use super::guide::Guide;
use super::hidden::Hidden;
use super::settings::MechanismSettings;
use super::wall::Wall;
use anyhow::{Context, Result, ensure};
use nalgebra::Vector3;
use softdock_control::frames::{Pose, Twist, Wrench, vector};
use softdock_mechanism::{Mechanism, Reaction, Relative};
use softdock_physics::model::load::{on_tip, tip_motion};

/// Planes that a mechanism can have.
pub const MAX_WALLS: usize = 8;

/// State of the walls at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Walls {
    /// At M, in M axes.
    pub(super) wrench: Wrench<f64>,
    /// Penetration of each wall, m; negative is the distance, unused walls are 0.
    pub(super) penetration_m: [f64; MAX_WALLS],
    /// Energy in their springs, J, and its rate of change, W.
    stored: [f64; 2],
}

/// Planes, each with the tip that it stops, and the guide.
#[derive(Clone, Debug)]
pub(super) struct SpringRod {
    walls: Vec<Wall>,
    guide: Guide,
}

impl SpringRod {
    /// The rod with M at `start`.
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

    /// State of the walls for a pose C_from_M and the twist of M.
    pub(super) fn walls(&self, c_from_m: &Pose<f64>, twist: &Twist<f64>) -> Walls {
        let mut all = Walls {
            wrench: Wrench::zero(),
            penetration_m: [0.0; MAX_WALLS],
            stored: [0.0; 2],
        };
        for (wall, penetration_m) in self.walls.iter().zip(&mut all.penetration_m) {
            let (tip, velocity) = tip_motion(c_from_m, twist, &wall.tip_m);
            let touch = wall.evaluate(&tip, &velocity);
            *penetration_m = touch.penetration_m;
            if touch.penetration_m > 0.0 {
                all.wrench = all.wrench + on_tip(c_from_m, &wall.tip_m, &touch.force);
                all.stored[0] += touch.stored_j;
                all.stored[1] += touch.charging_w;
            }
        }
        all
    }

    /// Wrench of guide and cables at M, in M axes.
    pub(super) fn guide(&self, c_from_m: &Pose<f64>, twist: &Twist<f64>) -> Wrench<f64> {
        self.guide.wrench(c_from_m, twist)
    }
}

impl Mechanism for SpringRod {
    /// Energy that its springs do not store is lost; the forces of hidden effects count as losses.
    fn reaction(&self, at: &Relative) -> Reaction {
        let walls = self.walls(&at.p_from_j, &at.twist);
        let guide = self.guide.stored(&at.p_from_j, &at.twist);
        let wrench = walls.wrench + self.guide(&at.p_from_j, &at.twist);
        Reaction {
            wrench,
            stored_j: walls.stored[0] + guide[0],
            loss_w: -at.power(&wrench) - walls.stored[1] - guide[1],
        }
    }

    fn advance(&mut self, at: &Relative, _step_s: f64) -> f64 {
        self.guide.advance(at.p_from_j.translation.vector);
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::drive::pose;
    use crate::rig::settings::WallSettings;
    use softdock_mechanism::EnergyTracked;

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

    fn rod(walls: Vec<WallSettings>) -> Result<SpringRod> {
        let settings = MechanismSettings {
            walls,
            ..MechanismSettings::default()
        };
        SpringRod::new(&settings, &[], &[0.0; 6], Vector3::zeros())
    }

    /// An oblique stop meets a tip off the axis of a turned spacecraft: force along the normal, torque
    /// by the lever, both in M axes.
    #[test]
    fn oblique_and_off_centre() {
        let walls = vec![wall([0.1, 0.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.5, 0.0])];
        let rod = rod(walls).unwrap();
        // M turned by 90 deg about z: its y axis is C's -x, so the tip is at x = p_x - 0.5.
        let at = pose(&[0.602, 0.0, 0.0, std::f64::consts::FRAC_PI_2, 0.0, 0.0]);
        let contact = rod.walls(&at, &Twist::zero());
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
        let rod = rod(walls).unwrap();
        let force = |x: f64| {
            rod.walls(&pose(&[x, 0.0, 0.0, 0.0, 0.0, 0.0]), &Twist::zero())
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
        let error = format!("{:#}", rod(walls).unwrap_err());
        let expected = "in [[rig.mechanism.walls]] number 2: `stiffness_n_per_m` is -5; allowed is 0 to 100000000";
        assert_eq!(error, expected);
    }

    /// A damped wall that cannot pull: e = exp(−ζ t1), t1 = (π − atan2(2ζw, 1 − 2ζ²))/w,
    /// w = √(1 − ζ²), t in 1/ω. (If it could, e would be exp(−πζ/w).) Its energy balance holds.
    #[test]
    fn restitution_and_duration_of_a_damped_wall() {
        const TABLE: [[f64; 3]; 6] = [
            [0.05, 0.8588, 3.0454],
            [0.1, 0.7441, 2.9561],
            [0.2, 0.5717, 2.7954],
            [0.3, 0.4510, 2.6545],
            [0.5, 0.2984, 2.4184],
            [0.6, 0.2488, 2.3183],
        ];
        const OMEGA: f64 = 21.0;
        let (mass, speed, step_s) = (500.0, 0.05, 2e-6);
        for [zeta, restitution, duration] in TABLE {
            let damped = WallSettings {
                stiffness_n_per_m: mass * OMEGA * OMEGA,
                damping_n_s_per_m: 2.0 * zeta * mass * OMEGA,
                ..wall([0.0; 3], [-1.0, 0.0, 0.0], [0.0; 3])
            };
            let mut tracked = EnergyTracked::new(rod(vec![damped]).unwrap());
            let (mut x, mut v, mut t) = (1e-12, speed, 0.0);
            let mut force = tracked
                .advance(&Relative::along_x(x, v), 0.0)
                .wrench
                .force
                .x;
            while force < 0.0 || v > 0.0 {
                v += force / mass * step_s;
                x += v * step_s;
                t += step_s;
                force = tracked
                    .advance(&Relative::along_x(x, v), step_s)
                    .wrench
                    .force
                    .x;
            }
            assert!((-v / speed - restitution).abs() < 1e-4, "{zeta}: {v}");
            assert!((t * OMEGA - duration).abs() < 2e-4, "{zeta}: {t}");
            let (balance, energy) = (tracked.balance(), 0.5 * mass * speed * speed);
            assert!(
                balance.imbalance_j().abs() < 1e-4 * energy,
                "{zeta}: {balance:?}"
            );
            let left = 0.5 * mass * v * v + balance.stored_j + balance.dissipated_j;
            assert!(
                (left / energy - 1.0).abs() < 1e-3,
                "{zeta}: {balance:?} {v}"
            );
        }
    }
}
