//! A mechanism between a target that is fixed in the laboratory and the robot's flange, as settings describe it.

use crate::{
    EddyCurrent, EnergyBalance, EnergyTracked, HuntCrossley, Loads, Mechanism, ProbeCone, Reaction,
    Relative, SoftCapture, TwoStage,
};
use serde::{Deserialize, Serialize};
use softdock_control::frames::{Pose, Twist, Wrench, orientation_from_abc, vector};
use softdock_control::range::{SettingsError, in_range};

/// A spring with a damper between the two sides, along x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Stiffness, N/m.
    pub stiffness_n_per_m: f64,
    /// Damping, N·s/m.
    pub damping_n_s_per_m: f64,
}

/// A mechanism of any kind, with its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(
    clippy::large_enum_variant,
    reason = "there are a handful; a box would allocate"
)]
pub enum Kind {
    /// Two rounded bodies.
    HuntCrossley(HuntCrossley),
    /// A preloaded spring in two stages with a brake.
    TwoStage(TwoStage),
    /// An eddy-current brake.
    EddyCurrent(EddyCurrent),
    /// Probe and drogue.
    ProbeCone(ProbeCone),
    /// A ring on six legs, with three petals on the other side.
    SoftCapture(SoftCapture),
}

impl Kind {
    fn validate(&self) -> Result<(), SettingsError> {
        match self {
            Self::HuntCrossley(m) => m.validate(),
            Self::TwoStage(m) => m.validate(),
            Self::EddyCurrent(m) => m.validate(),
            Self::ProbeCone(m) => m.validate(),
            Self::SoftCapture(m) => m.validate(),
        }
    }

    /// Stiffness and damping of the first contact along x; None where no linear spring describes it. Until an absorber moves,
    /// at preload plus brake force, its head rests on its seat as on a wall.
    pub fn first_contact(&self) -> Option<Joint> {
        match self {
            Self::TwoStage(m) if m.preload_n + m.brake_n > 0.0 => None,
            Self::TwoStage(m) => Some(Joint {
                stiffness_n_per_m: m.stiffness_n_per_m,
                damping_n_s_per_m: 0.0,
            }),
            Self::ProbeCone(m) => Some(m.first_contact()),
            Self::SoftCapture(m) => Some(m.first_contact()),
            Self::HuntCrossley(_) | Self::EddyCurrent(_) => None,
        }
    }

    /// Stiffness and damping along x that hold the two sides together after capture; None for a mechanism without latches.
    pub fn latched(&self) -> Option<Joint> {
        match self {
            Self::ProbeCone(m) => m.socket.map(|socket| Joint {
                stiffness_n_per_m: socket.stiffness_n_per_m(),
                damping_n_s_per_m: socket.damping_n_s_per_m(),
            }),
            Self::SoftCapture(m) => Some(m.legs.axial()),
            Self::HuntCrossley(_) | Self::EddyCurrent(_) | Self::TwoStage(_) => None,
        }
    }

    /// Largest step with which the simulation follows a motion, s. A ring without mass needs small steps, as it yields as
    /// fast as its legs and surfaces are stiff. Friction and brakes depend on the distance and allow any step.
    pub fn longest_step_s(&self) -> f64 {
        match self {
            Self::SoftCapture(_) => 8e-5,
            Self::HuntCrossley(_)
            | Self::EddyCurrent(_)
            | Self::TwoStage(_)
            | Self::ProbeCone(_) => 4e-4,
        }
    }

    fn inner(&self) -> &dyn Mechanism {
        match self {
            Self::HuntCrossley(m) => m,
            Self::TwoStage(m) => m,
            Self::EddyCurrent(m) => m,
            Self::ProbeCone(m) => m,
            Self::SoftCapture(m) => m,
        }
    }

    fn inner_mut(&mut self) -> &mut dyn Mechanism {
        match self {
            Self::HuntCrossley(m) => m,
            Self::TwoStage(m) => m,
            Self::EddyCurrent(m) => m,
            Self::ProbeCone(m) => m,
            Self::SoftCapture(m) => m,
        }
    }
}

impl Mechanism for Kind {
    fn reaction(&self, at: &Relative) -> Reaction {
        self.inner().reaction(at)
    }
    fn advance(&mut self, at: &Relative, step_s: f64) -> f64 {
        self.inner_mut().advance(at, step_s)
    }
    fn captured(&self) -> bool {
        self.inner().captured()
    }
}

/// A mechanism and its mounting.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DockingSettings {
    /// Origin of the target's docking frame P in C, m; its x axis is the closing direction.
    pub position_m: [f64; 3],
    /// Orientation of P in C: A, B, C, rad.
    #[serde(default)]
    pub orientation_abc_rad: [f64; 3],
    /// Origin of the moving docking frame J in M, m.
    #[serde(default)]
    pub tip_m: [f64; 3],
    /// Orientation of J in M: A, B, C, rad.
    #[serde(default)]
    pub tip_abc_rad: [f64; 3],
    /// Limits of the loads on the docking plane, which a run reports beside its largest loads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<Loads>,
    /// Kind of the mechanism.
    pub kind: Kind,
}

impl DockingSettings {
    /// Checks every value; the error names the key without that of the section.
    ///
    /// # Errors
    /// A value is outside of its range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let all = |name, values: &[f64; 3], limit: f64| {
            values
                .iter()
                .try_for_each(|v| in_range(name, *v, -limit, limit))
        };
        all("position_m", &self.position_m, 1e3)?;
        all("orientation_abc_rad", &self.orientation_abc_rad, 10.0)?;
        all("tip_m", &self.tip_m, 100.0)?;
        all("tip_abc_rad", &self.tip_abc_rad, 10.0)?;
        self.kind.validate()
    }
}

/// A mechanism between the laboratory and M, with its energy balance and largest loads.
#[derive(Clone, Debug)]
pub struct Docking {
    p_from_c: Pose<f64>,
    m_from_j: Pose<f64>,
    tracked: EnergyTracked<Kind>,
    loads: Loads,
}

impl Docking {
    /// A mechanism that nothing has touched yet.
    ///
    /// # Errors
    /// A value is outside of its range.
    pub fn new(settings: &DockingSettings) -> Result<Self, SettingsError> {
        settings.validate()?;
        let pose = |position, abc| {
            Pose::from_parts(vector::<f64>(position).into(), orientation_from_abc(abc))
        };
        Ok(Self {
            p_from_c: pose(&settings.position_m, &settings.orientation_abc_rad).inverse(),
            m_from_j: pose(&settings.tip_m, &settings.tip_abc_rad),
            tracked: EnergyTracked::new(settings.kind),
            loads: Loads::default(),
        })
    }

    /// Motion of J relative to P for a pose and a twist of M (linear in C, angular in M).
    fn relative(&self, c_from_m: &Pose<f64>, twist: &Twist<f64>) -> Relative {
        let to_j = &self.m_from_j;
        let tip = twist.linear + c_from_m.rotation * twist.angular.cross(&to_j.translation.vector);
        Relative {
            p_from_j: self.p_from_c * c_from_m * to_j,
            twist: Twist {
                linear: self.p_from_c.rotation * tip,
                angular: to_j.rotation.inverse() * twist.angular,
            },
        }
    }

    /// Wrench at M, in axes of M.
    pub fn wrench(&self, c_from_m: &Pose<f64>, twist: &Twist<f64>) -> Wrench<f64> {
        let reaction = self
            .tracked
            .mechanism
            .reaction(&self.relative(c_from_m, twist));
        reaction.wrench.transferred(&self.m_from_j)
    }

    /// Advances the state of the mechanism by a step that ends here, with the step's mean velocity.
    pub fn advance(&mut self, c_from_m: &Pose<f64>, twist: &Twist<f64>, step_s: f64) {
        let at = self.relative(c_from_m, twist);
        let on_j = self.tracked.advance(&at, step_s).wrench;
        let in_p = on_j.map(|v| at.p_from_j.rotation * v);
        self.loads = self.loads.largest(&Loads::of(&in_p));
    }

    /// As [`Self::advance`], but without energy balance and loads.
    pub fn follow(&mut self, c_from_m: &Pose<f64>, twist: &Twist<f64>, step_s: f64) {
        let at = self.relative(c_from_m, twist);
        self.tracked.mechanism.advance(&at, step_s);
    }

    /// The largest loads so far, at the ends of steps.
    pub fn loads(&self) -> Loads {
        self.loads
    }

    /// Whether latches hold the two sides together.
    pub fn captured(&self) -> bool {
        self.tracked.mechanism.captured()
    }

    /// The energy balance so far.
    pub fn balance(&self) -> EnergyBalance {
        self.tracked.balance()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    fn settings() -> DockingSettings {
        DockingSettings {
            position_m: [1.0, 0.2, 0.3],
            orientation_abc_rad: [std::f64::consts::FRAC_PI_2, 0.0, 0.0],
            tip_m: [0.0, 0.5, 0.0],
            tip_abc_rad: [0.0; 3],
            limits: None,
            kind: Kind::HuntCrossley(HuntCrossley {
                stiffness_n_per_m15: 1e6,
                loss_s_per_m: 0.0,
            }),
        }
    }

    /// Here x of P is y of C: a tip 1 mm beyond P is pushed back along y, with its lever about M.
    #[test]
    fn places_are_those_of_the_settings() {
        let docking = Docking::new(&settings()).unwrap();
        let c_from_m = Pose::from_parts(
            Vector3::new(1.0, -0.3 + 0.001, 0.3).into(),
            orientation_from_abc(&[0.0, 0.0, 0.0]),
        );
        let wrench = docking.wrench(&c_from_m, &Twist::zero());
        let push = 1e6 * 0.001_f64.powf(1.5);
        assert!(
            (wrench.force - Vector3::new(0.0, -push, 0.0)).norm() < 1e-9,
            "{wrench:?}"
        );
        assert!(
            wrench.torque.norm() < 1e-9,
            "the force goes through M: {wrench:?}"
        );
    }

    #[test]
    fn errors_name_the_key() {
        let mut wrong = settings();
        wrong.tip_m[1] = f64::NAN;
        let error = Docking::new(&wrong).unwrap_err();
        assert_eq!(error.to_string(), "`tip_m` is NaN; allowed is -100 to 100");
    }
}
