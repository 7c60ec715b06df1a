//! Settings of the predictor.

use crate::range::{SettingsError, in_range};

crate::described! {
/// What the predictor cannot find out, or should not.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct PredictorSettings {
    /// Stiffness that is expected of the contact, N/m; it need not be better than a factor of
    /// three. 0: derived from the masses and the robot's delay, as the stiffness at which the
    /// contact lasts five delays.
    pub contact_stiffness_n_per_m: f64,
    /// Noise of a force, standard deviation, N: the least that is assumed. The approach to the first
    /// contact shows whether it is more.
    pub force_noise_n: f64,
    /// The rebound is held to the identified contact, or to a passive one, where it departs from
    /// it; each such action is reported.
    pub guard: bool,
    /// A robot that does not move as `delay.actuator` says latches a fault before the first contact.
    pub interlock: bool,
}
}

impl Default for PredictorSettings {
    fn default() -> Self {
        Self {
            contact_stiffness_n_per_m: 0.0,
            force_noise_n: 0.002,
            guard: true,
            interlock: true,
        }
    }
}

impl PredictorSettings {
    /// Checks every field.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let stiffness = self.contact_stiffness_n_per_m;
        let name = "delay.predictor.contact_stiffness_n_per_m";
        in_range(name, stiffness, 0.0, 1e8)?;
        let noise = self.force_noise_n;
        in_range("delay.predictor.force_noise_n", noise, 1e-4, 100.0)
    }
}
