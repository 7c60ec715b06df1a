//! Stages of one axis of the arm behind its transport delay.

use super::checks::{named, prefixed};
use super::hidden::{self, Hidden};
use super::settings::{ActuatorSettings, RigSettings, ServoSettings};
use anyhow::Result;
use softdock_physics::effects::actuator::actuation_lag::FirstOrderLag;
use softdock_physics::effects::actuator::backlash::Backlash;
use softdock_physics::effects::actuator::jerk_limit::JerkLimit;
use softdock_physics::effects::actuator::rate_limit::RateLimit;
use softdock_physics::effects::actuator::second_order_servo::SecondOrderServo;
use softdock_physics::effects::actuator::velocity_gain::VelocityGain;
use softdock_physics::effects::actuator::velocity_saturation::VelocitySaturation;
use softdock_physics::effects::actuator::zero_cross_pause::ZeroCrossingPause;
use softdock_physics::effects::{CATALOGUE, Group};

/// One stage: mean velocity over a step in, mean velocity out.
#[derive(Clone, Debug)]
enum Stage {
    Lag(FirstOrderLag),
    Servo(SecondOrderServo),
    Pause(ZeroCrossingPause),
    RateLimit(RateLimit),
    JerkLimit(JerkLimit),
    Saturation(VelocitySaturation),
    Gain(VelocityGain),
    Backlash(Backlash),
}

impl Stage {
    fn advance(&mut self, velocity: f64) -> f64 {
        match self {
            Self::Lag(stage) => stage.advance(velocity),
            Self::Servo(stage) => stage.advance(velocity),
            Self::Pause(stage) => stage.advance(velocity),
            Self::RateLimit(stage) => stage.advance(velocity),
            Self::JerkLimit(stage) => stage.advance(velocity),
            Self::Saturation(stage) => stage.apply(velocity),
            Self::Gain(stage) => stage.apply(velocity),
            Self::Backlash(stage) => stage.advance(velocity),
        }
    }

    /// The stage of a hidden effect; `None` for those that act on the command itself.
    fn of(hidden: &Hidden, step_s: f64) -> Result<Option<Self>> {
        let value = |name| hidden.value(name);
        let servo = || {
            let [frequency_hz, damping_ratio] = hidden.values(["frequency_hz", "damping_ratio"]);
            SecondOrderServo::new(frequency_hz, damping_ratio, step_s).map(Self::Servo)
        };
        let built = match hidden.id.as_str() {
            "actuation_lag" => FirstOrderLag::new(value("extra_lag_s"), step_s).map(Self::Lag),
            "second_order_servo" | "structural_resonance" => servo(),
            "zero_cross_pause" => ZeroCrossingPause::new(value("pause_s"), step_s).map(Self::Pause),
            "rate_limit" => {
                RateLimit::new(value("max_acceleration_m_s2"), step_s).map(Self::RateLimit)
            }
            "jerk_limit" => JerkLimit::new(value("max_jerk_m_s3"), step_s).map(Self::JerkLimit),
            "velocity_saturation" => {
                VelocitySaturation::new(value("max_velocity_m_s")).map(Self::Saturation)
            }
            "velocity_gain" => VelocityGain::new(value("gain_error")).map(Self::Gain),
            "backlash" => Backlash::new(value("width_m"), step_s).map(Self::Backlash),
            _ => return Ok(None),
        };
        prefixed(&format!("rig.hidden {}.", hidden.id), built).map(Some)
    }
}

/// What follows the transport delay on one axis.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    stages: Vec<Stage>,
}

impl Axis {
    /// Nominal and hidden stages in the catalogue's order; of the same kind, the nominal one first.
    /// `unit` is that of the axis, `m` or `rad`.
    pub(super) fn new(settings: &RigSettings, step_s: f64, unit: &str) -> Result<Self> {
        let mut stages = nominal(&settings.robot.actuator, step_s, unit)?;
        for (effect, _) in hidden::in_order(&settings.hidden, Group::Actuator) {
            let hidden = hidden::find(&settings.hidden, effect.id);
            let stage = hidden.map(|hidden| Stage::of(hidden, step_s)).transpose()?;
            let stage = stage.flatten();
            stages.extend(stage.map(|stage| (effect.id, stage)));
        }
        stages.sort_by_key(|(id, _)| CATALOGUE.iter().position(|effect| effect.id == *id));
        Ok(Self {
            stages: stages.into_iter().map(|(_, stage)| stage).collect(),
        })
    }

    /// One step.
    pub(super) fn advance(&mut self, delayed: f64) -> f64 {
        self.stages
            .iter_mut()
            .fold(delayed, |velocity, stage| stage.advance(velocity))
    }
}

/// The stages of the settings, with the ids that place them.
fn nominal(
    actuator: &ActuatorSettings,
    step_s: f64,
    unit: &str,
) -> Result<Vec<(&'static str, Stage)>> {
    let (acceleration, velocity) = match unit {
        "rad" => (
            actuator.max_acceleration_rad_s2,
            actuator.max_velocity_rad_s,
        ),
        _ => (actuator.max_acceleration_m_s2, actuator.max_velocity_m_s),
    };
    let key = |name: &str| format!("rig.robot.actuator.{name}");
    let lag = named(&key("lag_s"), FirstOrderLag::new(actuator.lag_s, step_s))?;
    let pause = ZeroCrossingPause::new(actuator.pause_s, step_s);
    let pause = named(&key("pause_s"), pause)?;
    let mut stages = vec![
        ("actuation_lag", Stage::Lag(lag)),
        ("zero_cross_pause", Stage::Pause(pause)),
    ];
    if let Some(ServoSettings {
        frequency_hz,
        damping_ratio,
    }) = actuator.servo
    {
        let built = SecondOrderServo::new(frequency_hz, damping_ratio, step_s);
        let servo = prefixed(&key("servo."), built)?;
        stages.push(("second_order_servo", Stage::Servo(servo)));
    }
    if let Some(limit) = acceleration {
        let field = key(&format!("max_acceleration_{unit}_s2"));
        let built = named(&field, RateLimit::new(limit, step_s))?;
        stages.push(("rate_limit", Stage::RateLimit(built)));
    }
    if let Some(limit) = velocity {
        let field = key(&format!("max_velocity_{unit}_s"));
        let built = named(&field, VelocitySaturation::new(limit))?;
        stages.push(("velocity_saturation", Stage::Saturation(built)));
    }
    Ok(stages)
}
