//! Virtual damping towards a desired restitution.
//!
//! ```text
//! F = F_meas − c v        c such that the delayed contact returns e
//! ```
//!
//! Abiko, Uchiyama and others (Tohoku), "Delay time compensation based on coefficient of restitution for collision hybrid
//! motion simulator": straight flight for a delay, then motion by the stiffness, parameters by iteration for a desired
//! restitution; friction very small. Only the abstract was at hand. It leaves open what the parameters are; here:
//! - One, the damping c of the model's velocity along the contact while a force is felt: a force that is late by τ is a
//!   negative damping of k τ.
//! - The contact that it is found for is, with ω = 1 and φ = ω τ,
//!
//!   ```text
//!   v' = −X − 2 ζ v    X' = v(t − φ)    v = 1 until the touch, over at X = 0
//!   ```
//!
//!   and ζ is found by bisection when a contact opens.
//! - Stiffness, damping of the wall (none) and delay are given, the mass is that along the contact.

use super::contact::ContactLine;
use super::status::LawStatus;
use super::{DelaySettings, LawInput};
use crate::frames::Wrench;
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;
use nalgebra::ComplexField;

/// Longest integration step, in 1/ω, and most steps of a contact.
const LONGEST_STEP: f64 = 0.05;
const MOST_STEPS: usize = 400;
/// Largest φ, beyond which no law serves a first contact, and steps of a delay that long.
const LARGEST_PHASE: f64 = 2.0;
const DELAY_STEPS: usize = 41;
/// Below this φ the damping is that of the small delay, φ/2.
const SMALL_PHASE: f64 = 0.02;
/// Largest damping ratio, and halvings of its range.
const LARGEST_RATIO: f64 = 2.0;
const HALVINGS: usize = 14;
/// Part of the model's speed that the damping takes in a cycle at most, and its largest force, N.
const LARGEST_SHARE: f64 = 0.5;
const LARGEST_N: f64 = 1e6;

crate::described! {
/// Settings of the damping towards a desired restitution.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct DesiredRestitutionSettings {
    /// Restitution that the contact is to have.
    pub restitution: f64,
    /// Stiffness of the contact along its direction, N/m: it must be known.
    pub stiffness_n_per_m: f64,
    /// Force from which a contact counts, N: beyond the sensor's noise.
    pub threshold_n: f64,
}
}

impl Default for DesiredRestitutionSettings {
    fn default() -> Self {
        Self {
            restitution: 1.0,
            stiffness_n_per_m: 1e5,
            threshold_n: 1.0,
        }
    }
}

impl DesiredRestitutionSettings {
    /// Checks every field.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let (e, k) = (self.restitution, self.stiffness_n_per_m);
        in_range("delay.desired_restitution.restitution", e, 0.0, 1.0)?;
        let name = "delay.desired_restitution.stiffness_n_per_m";
        in_range(name, k, 10.0, 1e8)?;
        let name = "delay.desired_restitution.threshold_n";
        in_range(name, self.threshold_n, 0.01, 1e3)
    }
}

/// The law and its contact. It counts in f64 whatever the scalar of the cycle is.
#[derive(Clone, Debug)]
pub struct DesiredRestitution<S: Scalar> {
    settings: DesiredRestitutionSettings,
    line: ContactLine<S>,
    cycle_s: f64,
    delay_s: f64,
    /// Damping over mass of the present contact, 1/s.
    rate: f64,
}

impl<S: Scalar> DesiredRestitution<S> {
    /// No contact yet; `cycle_s` in s.
    pub fn new(settings: &DelaySettings, cycle_s: f64) -> Self {
        let own = settings.desired_restitution;
        Self {
            settings: own,
            line: ContactLine::new(own.threshold_n, &settings.actuator),
            cycle_s,
            delay_s: settings.horizon_s(cycle_s),
            rate: 0.0,
        }
    }

    /// The measured wrench with the damping.
    pub fn condition(&mut self, input: &LawInput<'_, S>) -> Wrench<S> {
        let measured = *input.wrench;
        let Some(along) = self.line.update(input) else {
            return measured;
        };
        self.line.close_when_quiet();
        let mobility = along.mobility.get();
        if mobility <= 1e-8 {
            return measured;
        }
        if along.opened {
            let omega = ComplexField::sqrt(self.settings.stiffness_n_per_m * mobility);
            let ratio = damping_ratio(omega * self.delay_s, self.settings.restitution);
            self.rate = (2.0 * ratio * omega).min(LARGEST_SHARE / self.cycle_s);
        }
        if along.load.get() < self.settings.threshold_n {
            return measured;
        }
        let force = -self.rate * along.velocity.get() / mobility;
        measured + self.line.wrench(S::of(force.clamp(-LARGEST_N, LARGEST_N)))
    }

    /// What it knows: whether a contact is open.
    pub fn status(&self) -> LawStatus {
        LawStatus {
            stiffness_n_per_m: self.settings.stiffness_n_per_m,
            delay_s: self.delay_s,
            ..self.line.status()
        }
    }
}

/// ζ with which a contact of that φ returns e.
fn damping_ratio(phase: f64, restitution: f64) -> f64 {
    let phase = phase.clamp(0.0, LARGEST_PHASE);
    let (mut low, mut high) = (0.0, LARGEST_RATIO);
    if phase < SMALL_PHASE && restitution >= 1.0 {
        return 0.5 * phase;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if rebound(phase.max(SMALL_PHASE), middle) > restitution {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Restitution of the delayed contact with ω = 1.
fn rebound(phase: f64, ratio: f64) -> f64 {
    let late = ComplexField::ceil(phase / LONGEST_STEP) as usize;
    let late = late.clamp(1, DELAY_STEPS);
    let step = phase / late as f64;
    let mut earlier = [1.0; DELAY_STEPS];
    let (mut depth, mut v) = (0.0, 1.0);
    for n in 0..MOST_STEPS {
        let Some(slot) = earlier.get_mut(n % late) else {
            break;
        };
        let moved = core::mem::replace(slot, v) * step;
        if depth + moved <= 0.0 {
            // It ends within the step.
            let part = depth / -moved;
            v -= (0.5 * depth + 2.0 * ratio * v) * step * part;
            break;
        }
        let force = depth + 0.5 * moved;
        depth += moved;
        v = (v * (1.0 - ratio * step) - force * step) / (1.0 + ratio * step);
    }
    -v
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Without damping a delay makes energy: 1.11 at φ = 0.06 to 2.85 at 0.7 (measured on an independent plant).
    #[test]
    fn the_delayed_contact_is_that_of_the_plant() {
        for (phase, e) in [(0.06, 1.11), (0.16, 1.30), (0.32, 1.68), (0.64, 2.63)] {
            let found = rebound(phase, 0.0);
            assert!((found / e - 1.0).abs() < 0.04, "{phase}: {found}");
        }
    }

    #[test]
    fn the_damping_gives_the_restitution() {
        for phase in [0.05, 0.3, 0.7, 1.2] {
            for e in [0.3, 0.7, 1.0] {
                let ratio = damping_ratio(phase, e);
                assert!((rebound(phase, ratio) - e).abs() < 0.02, "{phase} {e}");
            }
        }
    }
}
