//! The guide of the mechanism: the spring that centres the tip, and hidden forces along the free direction.

use super::checks::{check, check_all};
use super::drive::Axes;
use super::hidden::{self, Hidden};
use anyhow::{Result, ensure};
use nalgebra::Vector3;
use softdock_control::frames::{Pose, Twist, Wrench, vector};
use softdock_physics::effects::{self, Direction, Group, Law, Slide};
use softdock_physics::model::GuideModel;
use softdock_physics::model::load::{self, on_tip, tip_motion};

/// A hidden force on the moving side.
#[derive(Clone, Debug)]
enum Force {
    /// Along the free direction, with the state of the direction of motion that the law needs.
    Along(effects::Guide, Direction),
    /// In all directions.
    Spring(fn(&[f64], &Vector3<f64>) -> Vector3<f64>),
}

/// A hidden force with its values and the point of M on which it acts.
#[derive(Clone, Debug)]
struct Acting {
    force: Force,
    values: Vec<f64>,
    point: Vector3<f64>,
}

/// Everything that acts on M along and across the guide.
#[derive(Clone, Debug)]
pub(super) struct Guide {
    centring: Option<GuideModel>,
    /// The free direction in C.
    pub(super) axis: Vector3<f64>,
    acting: Vec<Acting>,
    start: Vector3<f64>,
    /// Position at the last integration step, m.
    last: Vector3<f64>,
}

impl Guide {
    /// A guide, with M at `start`; `tip` and `sensor` are where forces may act instead of at M, m.
    pub(super) fn new(
        centring: Option<&GuideModel>,
        hidden: &[Hidden],
        start: &Axes,
        [tip, sensor]: [Vector3<f64>; 2],
    ) -> Result<Self> {
        if let Some(guide) = centring {
            check_guide(guide)?;
        }
        let acting = hidden::in_order(hidden, Group::Mechanism).filter_map(|(effect, values)| {
            let force = match effect.law {
                Law::Guide(law) => Force::Along(law, Direction::new((law.reversal)(&values)?)),
                Law::Spring(law) => Force::Spring(law),
                _ => return None,
            };
            let point = match effect.place("acts_at").map(|k| values[k] as u8) {
                Some(1) => tip,
                Some(2) => sensor,
                _ => Vector3::zeros(),
            };
            Some(Acting {
                force,
                values,
                point,
            })
        });
        let start = Vector3::new(start[0], start[1], start[2]);
        Ok(Self {
            centring: centring.cloned(),
            axis: centring.map_or_else(Vector3::x, |g| vector::<f64>(&g.axis).normalize()),
            acting: acting.collect(),
            start,
            last: start,
        })
    }

    /// Advances laws with a memory to the end of an integration step.
    pub(super) fn advance(&mut self, now: Vector3<f64>) {
        let path = self.axis.dot(&(now - self.last));
        for acting in &mut self.acting {
            if let Force::Along(_, direction) = &mut acting.force {
                direction.advance_by(path);
            }
        }
        self.last = now;
    }

    /// Energy in the spring that centres the tip, J, and its rate of change, W.
    pub(super) fn stored(&self, c_from_m: &Pose<f64>, twist: &Twist<f64>) -> [f64; 2] {
        let Some(model) = &self.centring else {
            return [0.0; 2];
        };
        let guide = load::Guide::new(model);
        let (tip, velocity) = tip_motion(c_from_m, twist, &guide.tip);
        let away = tip - guide.point;
        let across = away - guide.axis * guide.axis.dot(&away);
        [
            0.5 * guide.stiffness * across.norm_squared(),
            guide.stiffness * across.dot(&velocity),
        ]
    }

    /// Wrench at M in M axes for a pose C_from_M and the twist of M.
    pub(super) fn wrench(&self, c_from_m: &Pose<f64>, twist: &Twist<f64>) -> Wrench<f64> {
        let mut wrench = Wrench::zero();
        if let Some(model) = &self.centring {
            let guide = load::Guide::new(model);
            let force = guide.force(c_from_m, twist);
            wrench = on_tip(c_from_m, &guide.tip, &force);
        }
        for acting in &self.acting {
            let (_, velocity) = tip_motion(c_from_m, twist, &acting.point);
            let force = match &acting.force {
                Force::Along(law, direction) => {
                    let velocity = self.axis.dot(&velocity);
                    let slide = Slide {
                        position: self.axis.dot(&c_from_m.translation.vector),
                        direction: direction.at(velocity),
                        velocity,
                        ..Slide::default()
                    };
                    self.axis * (law.force)(&acting.values, &slide)
                }
                Force::Spring(law) => {
                    law(&acting.values, &(c_from_m.translation.vector - self.start))
                }
            };
            wrench = wrench + on_tip(c_from_m, &acting.point, &force);
        }
        wrench
    }
}

fn check_guide(guide: &GuideModel) -> Result<()> {
    let key = |name: &str| format!("rig.mechanism.guide.{name}");
    check_all(&key("axis"), &guide.axis, -1e3, 1e3)?;
    ensure!(
        vector::<f64>(&guide.axis).norm() > 1e-6,
        "`{}` is [0, 0, 0]; it has to point somewhere, as [1, 0, 0] does",
        key("axis")
    );
    check_all(&key("point_m"), &guide.point_m, -1e3, 1e3)?;
    check_all(&key("tip_m"), &guide.tip_m, -100.0, 100.0)?;
    let (stiffness, damping) = (guide.stiffness_n_per_m, guide.damping_n_s_per_m);
    check(&key("stiffness_n_per_m"), stiffness, 0.0, 1e8)?;
    check(&key("damping_n_s_per_m"), damping, 0.0, 1e7)
}
