//! Stages of the actuator that a model file can add, one per effect.

use crate::effects::actuator::{
    actuation_delay, actuation_lag, backlash, command_deadzone, command_quantisation,
    gain_by_direction, jerk_limit, rate_limit, second_order_servo, structural_resonance,
    velocity_gain, velocity_saturation, zero_cross_pause,
};
use crate::effects::by_id;
use crate::model::{EffectModel, Model};
use softdock_actuator::{Chain, PauseKind, PauseTrigger, Resonance};
use std::collections::BTreeMap;

/// A stage of the actuator that the nominal model does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// More transport delay.
    Delay,
    /// A second lag.
    Lag,
    /// A lightly damped mode.
    Resonance,
    /// A well damped second-order response behind the lag.
    Servo,
    /// The same instead of the lag.
    ServoForLag,
    /// Standstill at a zero crossing.
    Pause(PauseTrigger, PauseKind),
    /// Limit of the executed acceleration.
    DriveAcceleration,
    /// Limit of the acceleration inside the loop that causes the lag.
    LoopAcceleration,
    /// Limit of the planned acceleration, before the lag.
    PlannerAcceleration,
    /// Limit of the executed jerk.
    DriveJerk,
    /// Limit of the planned jerk, before the lag.
    PlannerJerk,
    /// Limit of the executed velocity.
    DriveVelocity,
    /// Limit of the planned velocity, before the lag.
    PlannerVelocity,
    /// Ratio of executed to sent velocity other than 1.
    Gain,
    /// Lost motion.
    Backlash,
    /// The sent velocity is rounded.
    CommandStep,
    /// Dead zone: small commanded velocities move nothing.
    DeadZone,
    /// Ratio of executed to sent velocity that differs by direction.
    Direction,
}

/// Name and unit of a parameter.
type ParameterName = (&'static str, &'static str);

impl Stage {
    /// All stages, the likelier first.
    pub const ALL: [Self; 23] = [
        Self::Delay,
        Self::Lag,
        Self::Pause(PauseTrigger::Output, PauseKind::Resumes),
        Self::Pause(PauseTrigger::Output, PauseKind::RestartsFromRest),
        Self::Pause(PauseTrigger::Output, PauseKind::HoldsCommand),
        Self::Pause(PauseTrigger::Command, PauseKind::Resumes),
        Self::Pause(PauseTrigger::Command, PauseKind::RestartsFromRest),
        Self::Pause(PauseTrigger::Command, PauseKind::HoldsCommand),
        Self::DriveAcceleration,
        Self::LoopAcceleration,
        Self::PlannerAcceleration,
        Self::DriveJerk,
        Self::PlannerJerk,
        Self::DriveVelocity,
        Self::PlannerVelocity,
        Self::Resonance,
        Self::Servo,
        Self::ServoForLag,
        Self::Gain,
        Self::Backlash,
        Self::CommandStep,
        Self::DeadZone,
        Self::Direction,
    ];

    /// Id in the catalogue.
    pub fn id(self) -> &'static str {
        match self {
            Self::Delay => actuation_delay::EFFECT.id,
            Self::Lag => actuation_lag::EFFECT.id,
            Self::Resonance => structural_resonance::EFFECT.id,
            Self::Servo | Self::ServoForLag => second_order_servo::EFFECT.id,
            Self::Pause(..) => zero_cross_pause::EFFECT.id,
            Self::DriveAcceleration | Self::LoopAcceleration | Self::PlannerAcceleration => {
                rate_limit::EFFECT.id
            }
            Self::DriveJerk | Self::PlannerJerk => jerk_limit::EFFECT.id,
            Self::DriveVelocity | Self::PlannerVelocity => velocity_saturation::EFFECT.id,
            Self::Gain => velocity_gain::EFFECT.id,
            Self::Backlash => backlash::EFFECT.id,
            Self::CommandStep => command_quantisation::EFFECT.id,
            Self::DeadZone => command_deadzone::EFFECT.id,
            Self::Direction => gain_by_direction::EFFECT.id,
        }
    }

    /// Its parameters for translations, or for rotations: limits have another unit there.
    pub fn parameters(self, rotation: bool) -> &'static [ParameterName] {
        match self {
            Self::Delay => &[("extra_delay_s", "s")],
            Self::Lag => &[("extra_lag_s", "s")],
            Self::Resonance | Self::Servo | Self::ServoForLag => {
                &[("frequency_hz", "Hz"), ("damping_ratio", "-")]
            }
            Self::Pause(..) => &[("pause_s", "s")],
            Self::DriveAcceleration | Self::LoopAcceleration | Self::PlannerAcceleration => {
                if rotation {
                    &[("max_acceleration_rad_s2", "rad/s^2")]
                } else {
                    &[("max_acceleration_m_s2", "m/s^2")]
                }
            }
            Self::DriveJerk | Self::PlannerJerk if rotation => &[("max_jerk_rad_s3", "rad/s^3")],
            Self::DriveJerk | Self::PlannerJerk => &[("max_jerk_m_s3", "m/s^3")],
            Self::DriveVelocity | Self::PlannerVelocity if rotation => {
                &[("max_velocity_rad_s", "rad/s")]
            }
            Self::DriveVelocity | Self::PlannerVelocity => &[("max_velocity_m_s", "m/s")],
            Self::Gain => &[("gain_error", "-")],
            Self::Backlash if rotation => &[("width_rad", "rad")],
            Self::Backlash => &[("width_m", "m")],
            Self::CommandStep if rotation => &[("step_rad_s", "rad/s")],
            Self::CommandStep => &[("step_m_s", "m/s")],
            Self::DeadZone if rotation => &[("width_rad_s", "rad/s"), ("centre_rad_s", "rad/s")],
            Self::DeadZone => &[("width_m_s", "m/s"), ("centre_m_s", "m/s")],
            Self::Direction => &[("asymmetry", "-")],
        }
    }

    /// Whether values of its parameters are within the ranges of the catalogue.
    pub fn holds(self, rotation: bool, values: &[f64]) -> bool {
        let catalogued = by_id(self.id()).map_or(&[][..], |effect| effect.parameters);
        let mut both = self.parameters(false).iter().zip(values);
        both.all(|((name, _), value)| {
            let parameter = catalogued.iter().find(|p| p.name == *name);
            parameter.is_none_or(|p| {
                let [low, high] = p.range(rotation);
                (low..=high).contains(value)
            })
        })
    }

    /// Whether translations and rotations have parameters of their own.
    pub fn has_units_of_its_axes(self) -> bool {
        self.parameters(true) != self.parameters(false)
    }

    /// Form of an effect with several ones: names that are 1 in a model file.
    pub fn form(self) -> &'static [&'static str] {
        match self {
            Self::Pause(PauseTrigger::Output, PauseKind::RestartsFromRest) => {
                &["restarts_from_rest"]
            }
            Self::Pause(PauseTrigger::Output, PauseKind::HoldsCommand) => &["holds_command"],
            Self::Pause(PauseTrigger::Command, PauseKind::Resumes) => &["begins_with_command"],
            Self::Pause(PauseTrigger::Command, PauseKind::RestartsFromRest) => {
                &["restarts_from_rest", "begins_with_command"]
            }
            Self::Pause(PauseTrigger::Command, PauseKind::HoldsCommand) => {
                &["holds_command", "begins_with_command"]
            }
            Self::ServoForLag => &["instead_of_lag"],
            Self::LoopAcceleration => &["inside_of_loop"],
            Self::PlannerAcceleration | Self::PlannerJerk | Self::PlannerVelocity => {
                &["before_lag"]
            }
            _ => &[],
        }
    }

    /// Adds the stage to a chain; values in the order of [`Self::parameters`].
    pub fn apply(self, chain: &mut Chain, values: &[f64]) {
        let first = values.first().copied().unwrap_or(0.0);
        let second = values.get(1).copied().unwrap_or(0.0);
        match self {
            Self::Delay => chain.delay_s += first,
            Self::Lag => chain.extra_lag_s += first,
            Self::Resonance | Self::Servo | Self::ServoForLag => {
                if self == Self::ServoForLag {
                    chain.lag_s = 0.0;
                }
                chain.resonance = Some(Resonance {
                    frequency_hz: first,
                    damping_ratio: second,
                });
            }
            Self::Pause(trigger, kind) => {
                chain.pause_s = first;
                chain.pause_trigger = trigger;
                chain.pause_kind = kind;
            }
            Self::DriveAcceleration => chain.drive.acceleration = first,
            Self::LoopAcceleration => chain.loop_acceleration = first,
            Self::PlannerAcceleration => chain.planner.acceleration = first,
            Self::DriveJerk => chain.drive.jerk = first,
            Self::PlannerJerk => chain.planner.jerk = first,
            Self::DriveVelocity => chain.drive.velocity = first,
            Self::PlannerVelocity => chain.planner.velocity = first,
            Self::Gain => chain.gain *= 1.0 + first,
            Self::Backlash => chain.backlash_m = first,
            Self::CommandStep => chain.command_step = first,
            Self::DeadZone => chain.dead_zone = [second - 0.5 * first, second + 0.5 * first],
            Self::Direction => chain.asymmetry = first,
        }
    }

    /// The stage of an effect in a model file; `None` if the effect is not one of the actuator.
    pub fn of(id: &str, parameters: &BTreeMap<String, f64>) -> Option<Self> {
        let is_set = |name: &&str| parameters.get(*name) == Some(&1.0);
        let fits = |stage: &Self| stage.form().iter().all(is_set);
        Self::ALL
            .into_iter()
            .filter(|stage| stage.id() == id && fits(stage))
            .max_by_key(|stage| stage.form().len())
    }
}

/// Whether an effect of a model file acts on an axis.
fn acts_on(effect: &EffectModel, axis: usize) -> bool {
    effect.axes.is_empty() || effect.axes.iter().any(|a| a.index() == axis)
}

impl Model {
    /// The actuator of an axis: nominal delay and lag, with the effects that were added.
    pub fn chain(&self, axis: usize) -> Chain {
        let mut chain = Chain::nominal(self.actuator.transport_delay_s, self.actuator.lag_s);
        for effect in self.effects.iter().filter(|e| acts_on(e, axis)) {
            if let Some(stage) = Stage::of(&effect.id, &effect.parameters) {
                let value = |(name, _): &ParameterName| effect.parameters.get(*name).copied();
                // Without values for its kind of axis an effect does not act on the axis.
                let values: Option<Vec<f64>> =
                    stage.parameters(axis >= 3).iter().map(value).collect();
                if let Some(values) = values {
                    stage.apply(&mut chain, &values);
                }
            }
        }
        chain
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps of a command up to 10 mm/s and 1 rad/s.
    #[test]
    fn values_are_held_against_the_range_of_their_kind_of_axis() {
        let holds = |rotation, step: f64| Stage::CommandStep.holds(rotation, &[step]);
        assert!(holds(false, 0.01) && !holds(false, 0.011));
        assert!(holds(true, 1.0) && !holds(true, 1.01) && !holds(true, f64::NAN));
        assert!(Stage::Delay.holds(false, &[1.0]) && !Stage::Delay.holds(false, &[100.0]));
    }
}
