//! The guide of the mechanism: what centres the tip, and hidden forces along the free direction.

use super::checks::{check, check_all, prefixed};
use super::drive::Axes;
use super::hidden::{self, Hidden};
use anyhow::{Result, ensure};
use nalgebra::Vector3;
use softdock_analysis::model::GuideModel;
use softdock_analysis::model::load::{self, on_tip};
use softdock_control::effects::mechanism::cable_stiffness::CableSpring;
use softdock_control::effects::mechanism::guide_asymmetry::AsymmetricFriction;
use softdock_control::effects::mechanism::guide_coulomb::DryFriction;
use softdock_control::effects::mechanism::guide_hysteresis::BoucWen;
use softdock_control::effects::mechanism::guide_offset::ConstantForce;
use softdock_control::effects::mechanism::guide_stribeck::StribeckFriction;
use softdock_control::effects::mechanism::guide_viscous::ViscousFriction;
use softdock_control::frames::{Pose, Twist, Wrench, vector};

/// A force along the free direction that depends on the velocity alone.
#[derive(Clone, Debug)]
enum Friction {
    Dry(DryFriction<f64>),
    Viscous(ViscousFriction<f64>),
    Stribeck(StribeckFriction<f64>),
    Asymmetric(AsymmetricFriction<f64>),
    Offset(ConstantForce<f64>),
}

impl Friction {
    fn force(&self, velocity: f64) -> f64 {
        match self {
            Self::Dry(law) => law.force(velocity),
            Self::Viscous(law) => law.force(velocity),
            Self::Stribeck(law) => law.force(velocity),
            Self::Asymmetric(law) => law.force(velocity),
            Self::Offset(law) => law.force(),
        }
    }

    /// The law of a hidden effect, if it is one of these.
    fn of(hidden: &Hidden) -> Result<Option<Self>> {
        let force_n = hidden.value("force_n");
        let built = match hidden.id.as_str() {
            "guide_coulomb" => DryFriction::new(force_n).map(Self::Dry),
            "guide_viscous" => {
                ViscousFriction::new(hidden.value("damping_n_s_per_m")).map(Self::Viscous)
            }
            "guide_stribeck" => {
                let names = ["coulomb_n", "excess_n", "stribeck_speed_m_s"];
                let [coulomb_n, excess_n, speed] = hidden.values(names);
                StribeckFriction::new(coulomb_n, excess_n, speed).map(Self::Stribeck)
            }
            "guide_asymmetry" => {
                let names = ["forward_n", "backward_n", "viscous_difference_n_s_per_m"];
                let [forward_n, backward_n, difference] = hidden.values(names);
                AsymmetricFriction::new(forward_n, backward_n, difference).map(Self::Asymmetric)
            }
            "guide_offset" => ConstantForce::new(force_n).map(Self::Offset),
            _ => return Ok(None),
        };
        prefixed(&format!("rig.hidden {}.", hidden.id), built).map(Some)
    }
}

/// Hysteresis along the guide, and the force that it has built up.
#[derive(Clone, Debug)]
struct Hysteresis {
    law: BoucWen<f64>,
    force_n: f64,
}

/// Everything that acts on M along and across the guide.
#[derive(Clone, Debug)]
pub(super) struct Guide {
    centring: Option<GuideModel>,
    /// The free direction in C.
    pub(super) axis: Vector3<f64>,
    frictions: Vec<Friction>,
    hysteresis: Option<Hysteresis>,
    cable: Option<CableSpring<f64>>,
    start: Vector3<f64>,
    /// Position at the last integration step, m.
    last: Vector3<f64>,
}

impl Guide {
    /// A guide, with M at `start`.
    pub(super) fn new(
        centring: Option<&GuideModel>,
        hidden: &[Hidden],
        start: &Axes,
    ) -> Result<Self> {
        if let Some(guide) = centring {
            check_guide(guide)?;
        }
        let frictions = hidden.iter().filter_map(|h| Friction::of(h).transpose());
        let hysteresis = hidden::find(hidden, "guide_hysteresis").map(|h| {
            let [force_n, displacement_m] = h.values(["force_n", "displacement_m"]);
            prefixed(
                "rig.hidden guide_hysteresis.",
                BoucWen::new(force_n, displacement_m),
            )
        });
        let cable = hidden::find(hidden, "cable_stiffness").map(|h| {
            let built = CableSpring::new(h.value("stiffness_n_per_m"));
            prefixed("rig.hidden cable_stiffness.", built)
        });
        let start = Vector3::new(start[0], start[1], start[2]);
        Ok(Self {
            centring: centring.cloned(),
            axis: centring.map_or_else(Vector3::x, |g| vector::<f64>(&g.axis).normalize()),
            frictions: frictions.collect::<Result<_>>()?,
            hysteresis: hysteresis
                .transpose()?
                .map(|law| Hysteresis { law, force_n: 0.0 }),
            cable: cable.transpose()?,
            start,
            last: start,
        })
    }

    /// Moves what remembers to where an integration step ends.
    pub(super) fn advance(&mut self, position: &Axes) {
        let Some(hysteresis) = &mut self.hysteresis else {
            return;
        };
        let now = Vector3::new(position[0], position[1], position[2]);
        hysteresis.force_n = hysteresis.law.advance(self.axis.dot(&(now - self.last)));
        self.last = now;
    }

    /// Wrench at M in M axes for a pose C_from_M and the twist of M.
    pub(super) fn wrench(&self, c_from_m: &Pose<f64>, twist: &Twist<f64>) -> Wrench<f64> {
        let mut wrench = Wrench::zero();
        if let Some(model) = &self.centring {
            let guide = load::Guide::new(model);
            let force = guide.force(c_from_m, twist);
            wrench = on_tip(c_from_m, &guide.tip, &force);
        }
        let speed = self.axis.dot(&twist.linear);
        let along = self
            .frictions
            .iter()
            .map(|law| law.force(speed))
            .sum::<f64>()
            + self.hysteresis.as_ref().map_or(0.0, |h| h.force_n);
        let mut force = self.axis * along;
        if let Some(cable) = &self.cable {
            force += (c_from_m.translation.vector - self.start).map(|d| cable.force(d));
        }
        wrench + on_tip(c_from_m, &Vector3::zeros(), &force)
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
