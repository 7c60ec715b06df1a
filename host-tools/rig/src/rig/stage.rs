//! Stages of one axis of the arm behind its transport delay.

use super::checks::{named, prefixed};
use super::hidden;
use super::settings::{ActuatorSettings, RigSettings, ServoSettings};
use anyhow::Result;
use softdock_physics::effects::actuator::AxisStage;
use softdock_physics::effects::actuator::actuation_lag::{self, FirstOrderLag};
use softdock_physics::effects::actuator::rate_limit::{self, RateLimit};
use softdock_physics::effects::actuator::second_order_servo::{self, SecondOrderServo};
use softdock_physics::effects::actuator::velocity_saturation::{self, VelocitySaturation};
use softdock_physics::effects::actuator::zero_cross_pause::{self, ZeroCrossingPause};
use softdock_physics::effects::{Actuator, CATALOGUE, Effect, Group, Law};

/// What follows the transport delay on one axis.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    stages: Vec<AxisStage>,
}

impl Axis {
    /// Nominal and hidden stages in the catalogue's order; of the same kind, the nominal one first.
    /// `unit` is that of the axis, `m` or `rad`.
    pub(super) fn new(settings: &RigSettings, step_s: f64, unit: &str) -> Result<Self> {
        let mut stages = nominal(&settings.robot.actuator, step_s, unit)?;
        let hidden = hidden_stages(settings, step_s)?.into_iter();
        stages.extend(hidden.filter(|(_, stage)| !stage.is_of_the_command()));
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

/// Hidden stages of an axis, with their ids.
pub(super) fn hidden_stages(
    settings: &RigSettings,
    step_s: f64,
) -> Result<Vec<(&'static str, AxisStage)>> {
    let hidden = hidden::in_order(&settings.hidden, Group::Actuator);
    let stage = |(effect, values): (&'static Effect, Vec<f64>)| match effect.law {
        Law::Actuator(Actuator {
            axis: Some(axis), ..
        }) => {
            let built = prefixed(&format!("rig.hidden {}.", effect.id), axis(&values, step_s));
            Some(built.map(|stage| (effect.id, stage)))
        }
        _ => None,
    };
    hidden.filter_map(stage).collect()
}

/// The stages of the settings, with the ids that place them.
fn nominal(
    actuator: &ActuatorSettings,
    step_s: f64,
    unit: &str,
) -> Result<Vec<(&'static str, AxisStage)>> {
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
        (actuation_lag::EFFECT.id, AxisStage::Lag(lag)),
        (zero_cross_pause::EFFECT.id, AxisStage::Pause(pause)),
    ];
    if let Some(ServoSettings {
        frequency_hz,
        damping_ratio,
    }) = actuator.servo
    {
        let built = SecondOrderServo::new(frequency_hz, damping_ratio, step_s);
        let servo = prefixed(&key("servo."), built)?;
        stages.push((second_order_servo::EFFECT.id, AxisStage::Servo(servo)));
    }
    if let Some(limit) = acceleration {
        let field = key(&format!("max_acceleration_{unit}_s2"));
        let built = named(&field, RateLimit::new(limit, step_s))?;
        stages.push((rate_limit::EFFECT.id, AxisStage::Rate(built)));
    }
    if let Some(limit) = velocity {
        let field = key(&format!("max_velocity_{unit}_s"));
        let built = named(&field, VelocitySaturation::new(limit))?;
        stages.push((velocity_saturation::EFFECT.id, AxisStage::Saturation(built)));
    }
    Ok(stages)
}
