//! Compensation of the robot's delay: one law per file, chosen by a setting.
//!
//! A law turns the velocity that the model wants into the velocity that the robot is commanded. It gets what it may need and
//! nothing else ([`LawInput`]): the model's velocity, the contact wrench, both spacecraft, the measured and the commanded pose,
//! and the commands that were sent and may not have been executed yet.
//!
//! Each cycle calls a law twice. [`Law::condition`], before the two spacecraft are moved, returns the wrench that they feel;
//! [`Law::step`], after that, returns the velocity that the robot is commanded. Most laws leave the wrench as it is measured.
//! Momentum that a law adds is in the trace of every cycle (`unaccounted_impulse`).
//!
//! **A new law** is its file here, its lines in this file, its page `docs/delay/<law>.md` and its row in
//! `docs/delay/README.md`. Commands, parameter service, benchmarks and tests of all laws go through
//! [`LawName::ALL`] and [`DelaySettings::DESCRIPTIONS`].

pub mod actuator;
pub mod ats;
mod axes;
mod contact;
pub mod desired_restitution;
#[cfg(test)]
mod docking;
mod energy_bound;
pub mod guarded;
pub mod lead;
pub mod passivity;
pub mod polynomial;
pub mod predictor;
pub mod seed;
pub mod smith;
pub mod smith_dead_zone;
#[cfg(test)]
mod spacecraft;
pub mod status;
pub mod switching_gain;

use crate::described::Description;
use crate::dynamics::{TwoBody, TwoBodyState};
use crate::fault::Fault;
use crate::frames::{Pose, Twist, Wrench};
use crate::range::SettingsError;
use crate::scalar::Scalar;
use actuator::ActuatorSettings;
use ats::{Ats, AtsSettings};
use desired_restitution::{DesiredRestitution, DesiredRestitutionSettings};
use lead::{Lead, LeadSettings};
use nalgebra::UnitQuaternion;
use passivity::{Passivity, PassivitySettings};
use polynomial::{Polynomial, PolynomialSettings};
use predictor::{Predictor, PredictorSettings};
use seed::{Seed, SeedCoefficients, SeedSettings};
use smith::{Smith, SmithSettings};
use smith_dead_zone::{SmithDeadZone, SmithDeadZoneSettings};
use status::LawStatus;
use switching_gain::{SwitchingGain, SwitchingGainSettings};

/// Commands kept for laws that look into the pipeline: 64 cycles are 256 ms, several times the
/// delay of an industrial robot (about 32 ms).
pub const SENT_HISTORY: usize = 64;

/// The velocities sent in the last cycles, oldest first.
pub type SentHistory<S> = heapless::HistoryBuf<Twist<S>, SENT_HISTORY>;

/// Which law runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum LawName {
    /// The model's velocity goes to the robot as it is.
    None,
    /// The paper's law, section 4.2.
    Seed,
    /// Second-order lead.
    Lead,
    /// Polynomial extrapolation.
    Polynomial,
    /// Adaptive time series.
    Ats,
    /// Model-assisted Smith predictor.
    Smith,
    /// Time-domain passivity.
    Passivity,
    /// Model predictive control with a robot model, a contact estimator and impulse matching.
    #[default]
    Predictor,
    /// Smith predictor behind a dead zone of the force, with an observer of the force that the zone removes.
    SmithDeadZone,
    /// Virtual damping towards a desired restitution.
    DesiredRestitution,
    /// Force lead with a gain that an energy observer switches.
    SwitchingGain,
}

impl LawName {
    /// Every law, in the order of tables.
    pub const ALL: [Self; 11] = [
        Self::None,
        Self::Seed,
        Self::Lead,
        Self::Polynomial,
        Self::Ats,
        Self::Smith,
        Self::SmithDeadZone,
        Self::Passivity,
        Self::DesiredRestitution,
        Self::SwitchingGain,
        Self::Predictor,
    ];

    /// The name in settings, on the command line and in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Seed => "seed",
            Self::Lead => "lead",
            Self::Polynomial => "polynomial",
            Self::Ats => "ats",
            Self::Smith => "smith",
            Self::Passivity => "passivity",
            Self::Predictor => "predictor",
            Self::SmithDeadZone => "smith_dead_zone",
            Self::DesiredRestitution => "desired_restitution",
            Self::SwitchingGain => "switching_gain",
        }
    }

    /// The law of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|law| law.name() == name)
    }

    /// Whether the law computes in f64 whatever the scalar type of the cycle is. Such a law is too slow on a processor without
    /// double-precision hardware.
    pub const fn needs_double_precision(self) -> bool {
        matches!(
            self,
            Self::Predictor | Self::DesiredRestitution | Self::SwitchingGain
        )
    }

    /// Whether the law uses the measured pose. Such a law is of no use on a robot that does not report its pose, or that reports
    /// the commanded one.
    pub const fn needs_position(self) -> bool {
        match self {
            Self::None | Self::Seed | Self::Lead | Self::Polynomial | Self::DesiredRestitution => {
                false
            }
            Self::Ats
            | Self::Smith
            | Self::SmithDeadZone
            | Self::Passivity
            | Self::SwitchingGain
            | Self::Predictor => true,
        }
    }
}

/// Which velocity of the model stands for a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum ModelVelocity {
    /// 0.5 (v(n−1) + v(n)), as printed; half a cycle late (A11).
    #[default]
    Mean,
    /// v(n): no added energy on a rig without delay.
    End,
}

crate::described! {
/// Settings of the delay compensation.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct DelaySettings {
    /// The law. Of a cycle `predictor` takes 0.2 to 0.5 ms on the NUCLEO, `seed` 0.06 to 0.15 ms; a cycle of
    /// 1 ms needs `seed` or `lead`.
    pub law: LawName,
    /// The model's velocity that the law gets.
    pub model_velocity: ModelVelocity,
    /// What is believed about the robot.
    pub actuator: ActuatorSettings,
    /// Bounds the energy of both spacecraft in a contact to what they brought, beside any law.
    pub passivity_guard: bool,
    /// Settings of the paper's law.
    pub seed: SeedSettings,
    /// Settings of the second-order lead.
    pub lead: LeadSettings,
    /// Settings of the polynomial extrapolation.
    pub polynomial: PolynomialSettings,
    /// Settings of the adaptive time series.
    pub ats: AtsSettings,
    /// Settings of the Smith predictor.
    pub smith: SmithSettings,
    /// Settings of time-domain passivity; the guard takes its threshold from there.
    pub passivity: PassivitySettings,
    /// Settings of the predictor.
    pub predictor: PredictorSettings,
    /// Settings of the Smith predictor behind a dead zone.
    pub smith_dead_zone: SmithDeadZoneSettings,
    /// Settings of the damping towards a desired restitution.
    pub desired_restitution: DesiredRestitutionSettings,
    /// Settings of the switched force lead.
    pub switching_gain: SwitchingGainSettings,
}
}

impl DelaySettings {
    /// The doc comments of these settings, of the robot's and of those of all laws.
    pub const DESCRIPTIONS: &[Description] = &[
        Self::DESCRIPTION,
        ActuatorSettings::DESCRIPTION,
        SeedSettings::DESCRIPTION,
        SeedCoefficients::DESCRIPTION,
        LeadSettings::DESCRIPTION,
        PolynomialSettings::DESCRIPTION,
        AtsSettings::DESCRIPTION,
        SmithSettings::DESCRIPTION,
        PassivitySettings::DESCRIPTION,
        PredictorSettings::DESCRIPTION,
        SmithDeadZoneSettings::DESCRIPTION,
        DesiredRestitutionSettings::DESCRIPTION,
        SwitchingGainSettings::DESCRIPTION,
    ];

    /// Checks every field.
    pub fn validate(&self) -> Result<(), SettingsError> {
        self.actuator.validate()?;
        self.seed.validate()?;
        self.predictor.check_ranges()?;
        self.lead.validate()?;
        self.polynomial.check_ranges()?;
        self.ats.check_ranges()?;
        self.smith.check_ranges()?;
        self.smith_dead_zone.check_ranges()?;
        self.desired_restitution.check_ranges()?;
        self.switching_gain.check_ranges()?;
        self.passivity.check_ranges()
    }

    /// Time from the instant at which the model has the velocity that the law gets to the execution of that velocity, s: the mean
    /// delay of the robot ([`ActuatorSettings::mean_delay_s`]), plus half a cycle if that velocity is the mean over the cycle
    /// that has just passed (A11).
    pub fn horizon_s(&self, cycle_s: f64) -> f64 {
        self.actuator.mean_delay_s() + self.half_cycle_s(cycle_s)
    }

    /// The part of the horizon that comes from averaging the model's velocity, s.
    fn half_cycle_s(&self, cycle_s: f64) -> f64 {
        match self.model_velocity {
            ModelVelocity::Mean => 0.5 * cycle_s,
            ModelVelocity::End => 0.0,
        }
    }
}

/// Input of a law in a cycle: the state before the two spacecraft are moved for [`Law::condition`], after it for [`Law::step`].
#[derive(Debug)]
pub struct LawInput<'a, S: Scalar> {
    /// Velocity that the model wants, by [`ModelVelocity`]: linear in C, angular in M.
    pub model: Twist<S>,
    /// Velocity of the model at the end of the cycle, in the same axes.
    pub model_end: Twist<S>,
    /// Contact wrench at M as it was measured, axes of M.
    pub wrench: &'a Wrench<S>,
    /// Measured pose of M in C.
    pub measured: &'a Pose<S>,
    /// Commanded pose of M in C: the sum of what was sent.
    pub commanded: &'a Pose<S>,
    /// Velocities sent in earlier cycles.
    pub sent: &'a SentHistory<S>,
    /// The two spacecraft.
    pub bodies: &'a TwoBody<S>,
    /// Their motion.
    pub state: &'a TwoBodyState<S>,
    /// Orientation of Q in the laboratory, where it stands still.
    pub c_from_q: UnitQuaternion<S>,
    /// The start ramp is over: the wrench moves the model.
    pub released: bool,
    /// The model does not move in this cycle (stale sensor, or the robot clamps).
    pub frozen: bool,
}

/// Number of visible parts of a law (Fig. 9 has seven).
pub const PARTS: usize = 7;

/// Output of a law in a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawOutput<S: Scalar> {
    /// Velocity for the robot: linear in C, angular in M.
    pub command: Twist<S>,
    /// The parts that were added to the model's velocity, for the trace.
    pub parts: [Twist<S>; PARTS],
    /// What the law has identified and done.
    pub status: LawStatus,
    /// A reason to stop: the robot does not behave as the settings say.
    pub fault: Option<Fault>,
}

impl<S: Scalar> LawOutput<S> {
    /// A command without parts, status and fault.
    pub fn of(command: Twist<S>) -> Self {
        Self {
            command,
            parts: [Twist::zero(); PARTS],
            status: LawStatus::default(),
            fault: None,
        }
    }
}

/// A law and its state.
#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is one law, nothing is allocated, and the default is the large one"
)]
pub enum Law<S: Scalar> {
    /// No compensation.
    None,
    /// The paper's law.
    Seed(Seed<S>),
    /// Second-order lead.
    Lead(Lead<S>),
    /// Polynomial extrapolation.
    Polynomial(Polynomial<S>),
    /// Adaptive time series.
    Ats(Ats<S>),
    /// Model-assisted Smith predictor.
    Smith(Smith<S>),
    /// Time-domain passivity.
    Passivity(Passivity<S>),
    /// The predictor.
    Predictor(Predictor),
    /// Smith predictor behind a dead zone.
    SmithDeadZone(SmithDeadZone<S>),
    /// Damping towards a desired restitution.
    DesiredRestitution(DesiredRestitution<S>),
    /// Switched force lead.
    SwitchingGain(SwitchingGain<S>),
}

impl<S: Scalar> Law<S> {
    /// The chosen law in its initial state; `cycle_s` in s.
    #[inline(always)] // or each level would hold a copy of the law on the stack
    pub fn new(settings: &DelaySettings, cycle_s: f64) -> Self {
        match settings.law {
            LawName::None => Self::None,
            LawName::Seed => Self::Seed(Seed::new(&settings.seed, cycle_s)),
            LawName::Lead => Self::Lead(Lead::new(settings, cycle_s)),
            LawName::Polynomial => Self::Polynomial(Polynomial::new(settings, cycle_s)),
            LawName::Ats => Self::Ats(Ats::new(settings, cycle_s)),
            LawName::Smith => Self::Smith(Smith::new(settings, cycle_s)),
            LawName::Passivity => Self::Passivity(Passivity::new(settings, cycle_s)),
            LawName::Predictor => Self::Predictor(Predictor::new(settings, cycle_s)),
            LawName::SmithDeadZone => Self::SmithDeadZone(SmithDeadZone::new(settings, cycle_s)),
            LawName::DesiredRestitution => {
                Self::DesiredRestitution(DesiredRestitution::new(settings, cycle_s))
            }
            LawName::SwitchingGain => Self::SwitchingGain(SwitchingGain::new(settings, cycle_s)),
        }
    }

    /// The initial state again, in place where it is large.
    #[inline(never)]
    pub fn restart(&mut self, settings: &DelaySettings, cycle_s: f64) {
        match self {
            Self::Predictor(law) if settings.law == LawName::Predictor => {
                law.restart(settings, cycle_s);
            }
            other => *other = Self::new(settings, cycle_s),
        }
    }

    /// The wrench that the two spacecraft feel in this cycle, at M in axes of M: for most laws the
    /// measured one. Not called while the start ramp runs or the model is frozen.
    pub fn condition(&mut self, input: &LawInput<'_, S>) -> Wrench<S> {
        match self {
            Self::None | Self::Seed(_) | Self::Lead(_) | Self::Polynomial(_) | Self::Ats(_) => {
                *input.wrench
            }
            Self::Smith(law) => law.condition(input),
            Self::Passivity(law) => law.condition(input, *input.wrench),
            Self::Predictor(law) => law.condition(input),
            Self::SmithDeadZone(law) => law.condition(input),
            Self::DesiredRestitution(law) => law.condition(input),
            Self::SwitchingGain(law) => law.condition(input),
        }
    }

    /// One cycle: the velocity that the robot is commanded.
    pub fn step(&mut self, input: &LawInput<'_, S>) -> LawOutput<S> {
        match self {
            Self::None => LawOutput::of(input.model),
            Self::Seed(law) => law.step(&input.model),
            Self::Lead(law) => law.step(&input.model),
            Self::Polynomial(law) => law.step(&input.model),
            Self::Ats(law) => law.step(input),
            Self::Smith(law) => law.step(input),
            Self::Passivity(law) => LawOutput {
                status: law.status(),
                ..LawOutput::of(input.model)
            },
            Self::Predictor(law) => law.step(input),
            Self::SmithDeadZone(law) => law.step(input),
            Self::DesiredRestitution(law) => LawOutput {
                status: law.status(),
                ..LawOutput::of(input.model)
            },
            Self::SwitchingGain(law) => LawOutput {
                status: law.status(),
                ..LawOutput::of(input.model)
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_law_has_a_name_of_its_own() {
        for law in LawName::ALL {
            assert_eq!(LawName::named(law.name()), Some(law));
        }
        assert_eq!(LawName::named("nothing"), None);
    }

    /// Half a cycle longer if the model's velocity is the mean over the cycle.
    #[test]
    fn the_horizon_is_from_the_models_instant_to_its_execution() {
        for (model_velocity, horizon_s) in
            [(ModelVelocity::End, 0.032), (ModelVelocity::Mean, 0.034)]
        {
            let settings = DelaySettings {
                model_velocity,
                ..DelaySettings::default()
            };
            assert!((settings.horizon_s(0.004) - horizon_s).abs() < 1e-15);
        }
    }

    /// A field out of range of each law's settings.
    #[test]
    fn the_settings_of_every_law_are_checked() {
        type Change = fn(&mut DelaySettings);
        let changes: [(&str, Change); 18] = [
            ("actuator.delay_s", |s| s.actuator.delay_s = -1.0),
            ("seed.threshold_mm_s", |s| s.seed.threshold_mm_s = -1.0),
            ("seed.rotation.k_i", |s| s.seed.rotation.k_i = 101.0),
            ("seed.translation.c", |s| s.seed.translation.c[3] = 3e4),
            ("lead.extra_s", |s| s.lead.extra_s = 0.1),
            ("lead.low_pass_hz", |s| s.lead.low_pass_hz = 5.0),
            ("polynomial.order", |s| s.polynomial.order = 4),
            ("polynomial.extra_s", |s| s.polynomial.extra_s = -0.1),
            ("ats.window_s", |s| s.ats.window_s = 0.0),
            ("ats.bounds", |s| s.ats.bounds[2] = 1.1),
            ("smith.catch_up_s", |s| s.smith.catch_up_s = 0.0),
            ("passivity.largest_share", |s| {
                s.passivity.largest_share = 1.0
            }),
            ("predictor.force_noise_n", |s| {
                s.predictor.force_noise_n = 0.0
            }),
            ("smith_dead_zone.observer_gain", |s| {
                s.smith_dead_zone.observer_gain = 0.0
            }),
            ("desired_restitution.restitution", |s| {
                s.desired_restitution.restitution = 1.1
            }),
            ("desired_restitution.threshold_n", |s| {
                s.desired_restitution.threshold_n = 0.0
            }),
            ("switching_gain.gain", |s| s.switching_gain.gain = 6.0),
            ("switching_gain.threshold_n", |s| {
                s.switching_gain.threshold_n = 0.0
            }),
        ];
        assert_eq!(DelaySettings::default().validate(), Ok(()));
        for (field, change) in changes {
            let mut settings = DelaySettings::default();
            change(&mut settings);
            let error = settings.validate().unwrap_err();
            assert_eq!(error.field, format!("delay.{field}"));
        }
        // A low-pass of the lead below its range.
        let mut settings = DelaySettings::default();
        settings.lead.low_pass_hz = 0.0;
        assert_eq!(settings.validate(), Ok(()));
        settings.lead.low_pass_hz = 10.0;
        assert_eq!(settings.validate(), Ok(()));
    }
}
