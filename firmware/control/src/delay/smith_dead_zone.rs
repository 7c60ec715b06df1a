//! Smith predictor behind a dead zone of the force, with an observer of what the zone has swallowed.
//!
//! ```text
//! F_z = F_meas where |F_meas| ≥ δ, else 0
//! d̂  += g (F̂(x_exec) − F_z − d̂)      |d̂| ≤ δ, in a contact alone
//! F   = F_z + d̂ + F̂(x_model) − F̂(x_exec)
//! ```
//!
//! Li and others, a hybrid Smith predictor with a dead-zone disturbance observer: a dead zone keeps noise from moving the
//! model, and takes or gives energy in each contact. Only the abstract was at hand. It leaves open:
//! - whether the zone shifts the force outside of it (δ less) or not: here it does not, because what is outside is
//!   measured;
//! - the observer: here the contact of the [Smith predictor](super::smith), identified on the loads outside of the
//!   zone, tells what the load inside of it would be, through a first-order filter.

use super::smith::Smith;
use super::{DelaySettings, LawInput, LawOutput};
use crate::frames::Wrench;
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

crate::described! {
/// Settings of the Smith predictor behind a dead zone; its contact is that of `smith`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct SmithDeadZoneSettings {
    /// δ: force below which nothing is felt, N.
    pub dead_zone_n: f64,
    /// g: gain of the observer per cycle.
    pub observer_gain: f64,
}
}

impl Default for SmithDeadZoneSettings {
    fn default() -> Self {
        Self {
            dead_zone_n: 1.0,
            observer_gain: 0.5,
        }
    }
}

impl SmithDeadZoneSettings {
    /// Checks every field.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let (zone, gain) = (self.dead_zone_n, self.observer_gain);
        in_range("delay.smith_dead_zone.dead_zone_n", zone, 0.0, 1e3)?;
        in_range("delay.smith_dead_zone.observer_gain", gain, 0.01, 1.0)
    }
}

/// The law: a Smith predictor, and the observer before it.
#[derive(Clone, Debug)]
pub struct SmithDeadZone<S: Scalar> {
    smith: Smith<S>,
    zone: S,
    gain: S,
    /// d̂, N along the contact.
    swallowed: S,
}

impl<S: Scalar> SmithDeadZone<S> {
    /// No contact yet; `cycle_s` in s.
    pub fn new(settings: &DelaySettings, cycle_s: f64) -> Self {
        let own = &settings.smith_dead_zone;
        Self {
            smith: Smith::new(settings, cycle_s),
            zone: S::of(own.dead_zone_n),
            gain: S::of(own.observer_gain),
            swallowed: S::zero(),
        }
    }

    /// The wrench that gives the model the velocity of the contact replayed.
    pub fn condition(&mut self, input: &LawInput<'_, S>) -> Wrench<S> {
        let within = input.wrench.force.amax() < self.zone;
        let mut wrench = if within {
            Wrench::zero()
        } else {
            *input.wrench
        };
        self.swallowed = match self.smith.expected(&wrench) {
            Some((load, expected)) => {
                let error = expected - load - self.swallowed;
                (self.swallowed + error * self.gain).clamp(-self.zone, self.zone)
            }
            None => S::zero(),
        };
        if within {
            wrench = wrench + self.smith.along(self.swallowed);
        }
        let behind = LawInput {
            wrench: &wrench,
            ..*input
        };
        self.smith.condition(&behind)
    }

    /// One cycle: see [`Smith::step`].
    pub fn step(&mut self, input: &LawInput<'_, S>) -> LawOutput<S> {
        self.smith.step(input)
    }
}
