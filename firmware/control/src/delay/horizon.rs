//! How far ahead of the robot a law has to look.

use super::{DelaySettings, ModelVelocity};

impl DelaySettings {
    /// Time from the instant that the model's velocity stands for to its execution, s: the mean
    /// delay of the robot ([`ActuatorSettings::mean_delay_s`]), and half a cycle if the model's
    /// velocity is the mean over the cycle that has just passed (A11).
    ///
    /// [`ActuatorSettings::mean_delay_s`]: super::actuator::ActuatorSettings::mean_delay_s
    pub fn horizon_s(&self, cycle_s: f64) -> f64 {
        self.actuator.mean_delay_s() + self.half_cycle_s(cycle_s)
    }

    /// The part of the horizon that is the model's, s.
    pub(super) fn half_cycle_s(&self, cycle_s: f64) -> f64 {
        match self.model_velocity {
            ModelVelocity::Mean => 0.5 * cycle_s,
            ModelVelocity::End => 0.0,
        }
    }
}
