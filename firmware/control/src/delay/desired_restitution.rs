//! Virtual damping towards a desired restitution.
//!
//! ```text
//! F = F_meas − c v        c such that the delayed contact returns e
//! ```
//!
//! Abiko, Uchiyama and others (Tohoku), "Delay time compensation based on coefficient of restitution for collision hybrid
//! motion simulator": straight flight for a delay, then motion by the stiffness, parameters by iteration for a desired
//! restitution; friction very small. Only the abstract was at hand. It does not say what the parameters are. Choices made here:
//! - The only parameter is the damping c of the model's velocity along the contact while a force is felt, as a force that is late
//!   by τ acts like a negative damping of k τ.
//! - c is found for this delayed contact, with ω = 1 and φ = ω τ:
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
use crate::scalar::Scalar;
use nalgebra::ComplexField;

/// Longest integration step, in 1/ω, and most steps of a contact.
const LONGEST_STEP: f64 = 0.05;
const MOST_STEPS: usize = 400;
/// Largest φ, beyond which no law serves a first contact, and the largest number of integration steps in a delay.
const LARGEST_PHASE: f64 = 2.0;
const DELAY_STEPS: usize = 41;
/// Below this φ the damping is that of the small delay, φ/2.
const SMALL_PHASE: f64 = 0.02;
/// Largest damping ratio, and halvings of its range.
const LARGEST_RATIO: f64 = 2.0;
const HALVINGS: usize = 14;
/// Largest part of the model's speed that the damping takes in a cycle, and its largest force, N.
const LARGEST_SHARE: f64 = 0.5;
const LARGEST_N: f64 = 1e6;

crate::described! {
/// Settings of the damping towards a desired restitution.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct DesiredRestitutionSettings: "delay.desired_restitution" {
    /// Restitution that the contact is to have.
    pub restitution: f64 = 1.0 => 0.0..=1.0,
    /// Stiffness of the contact along its direction, N/m: it must be known.
    pub stiffness_n_per_m: f64 = 1e5 => 10.0..=1e8,
    /// Force from which a contact counts, N: beyond the sensor's noise.
    pub threshold_n: f64 = 1.0 => 0.01..=1e3,
}
}

/// The law and its contact. It computes in f64 whatever the scalar type of the cycle is.
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

    /// The measured wrench plus the damping force.
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

    /// Status: stiffness and delay as set, and whether a contact is open.
    pub fn status(&self) -> LawStatus {
        LawStatus {
            stiffness_n_per_m: self.settings.stiffness_n_per_m,
            delay_s: self.delay_s,
            ..self.line.status()
        }
    }
}

/// Damping ratio ζ with which a contact of phase φ = `phase` has this restitution.
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
            // The contact ends within the step.
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
    use crate::delay::spacecraft::{CYCLE_S, Spacecraft};
    use crate::delay::status::LawFlags;
    use crate::frames::Twist;
    use crate::settings::BodySettings;

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

    /// X' = v(t − φ), v' = −X − 2 ζ v in a thousand steps of the delay, with the motion half a step later than the velocity.
    fn fine_rebound(phase: f64, ratio: f64) -> f64 {
        let late = 1000;
        let step = phase / late as f64;
        let mut speeds = vec![1.0; late];
        let (mut depth, mut v) = (0.0, 1.0);
        for n in 0.. {
            let slot = n % late;
            depth += speeds[slot] * step;
            if depth <= 0.0 {
                break;
            }
            speeds[slot] = v;
            v -= (depth + 2.0 * ratio * v) * step;
        }
        -v
    }

    #[test]
    fn the_rebound_is_that_of_the_delayed_contact() {
        for (phase, ratio) in [(0.3, 0.0), (0.3, 0.2), (0.7, 0.4), (1.2, 0.9), (2.0, 1.2)] {
            let (found, expected) = (rebound(phase, ratio), fine_rebound(phase, ratio));
            assert!(
                (found / expected - 1.0).abs() < 0.05,
                "{phase} {ratio}: {found} {expected}"
            );
        }
    }

    /// A damping ratio of φ/2 removes the energy that a small delay adds. Beyond φ = 2 the ratio stays that of 2.
    #[test]
    fn a_small_delay_is_made_up_for_by_half_of_it() {
        assert_eq!(damping_ratio(0.01, 1.0), 0.005);
        assert!((damping_ratio(0.1, 1.0) / 0.05 - 1.0).abs() < 0.3);
        assert!(damping_ratio(0.021, 1.0) > 0.0105);
        assert!(damping_ratio(0.01, 0.5) > 0.2);
        assert_eq!(damping_ratio(5.0, 0.5), damping_ratio(2.0, 0.5));
        assert_eq!(damping_ratio(-1.0, 1.0), 0.0);
        // Without damping more than all of the speed comes back.
        assert!(damping_ratio(2.0, 0.0) <= LARGEST_RATIO);
    }

    /// Two spacecraft of this mass that separate at this velocity (m/s), with a load along x (N); returns what they feel.
    fn cycle(law: &mut DesiredRestitution<f64>, mass_kg: f64, load: f64, velocity: f64) -> f64 {
        let body = BodySettings {
            mass_kg,
            ..BodySettings::default()
        };
        let spacecraft = Spacecraft::new(&body, &body);
        let wrench = Wrench::of(&[load, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let model = Twist::of(&[velocity, 0.0, 0.0, 0.0, 0.0, 0.0]);
        law.condition(&spacecraft.asked(&wrench, model)).force.x
    }

    /// The damping force is 2 ζ ω m v against the motion, with the reduced mass m = 250 kg, while a force is felt.
    #[test]
    fn the_damping_is_that_of_the_contact_with_its_delay() {
        let mut settings = DelaySettings::default();
        settings.desired_restitution.restitution = 0.8;
        let mut law = DesiredRestitution::new(&settings, CYCLE_S);
        assert_eq!(cycle(&mut law, 500.0, 0.5, -0.01), 0.5);
        let omega = f64::sqrt(1e5 / 250.0);
        let ratio = damping_ratio(omega * 0.034, 0.8);
        for (load, velocity) in [(10.0, -0.01), (30.0, -0.004), (20.0, 0.01), (1.1, 0.01)] {
            let found = cycle(&mut law, 500.0, load, velocity);
            let expected = load - 2.0 * ratio * omega * 250.0 * velocity;
            assert!(
                (found / expected - 1.0).abs() < 1e-9,
                "{load}: {found} {expected}"
            );
        }
        assert_eq!(cycle(&mut law, 500.0, 0.9, 0.01), 0.9);
        let status = law.status();
        assert!(status.flags.has(LawFlags::CONTACT));
        assert_eq!((status.stiffness_n_per_m, status.delay_s), (1e5, 0.034));
        // Eight cycles later it is over.
        for _ in 0..9 {
            cycle(&mut law, 500.0, 0.0, 0.01);
        }
        assert!(!law.status().flags.has(LawFlags::CONTACT));
    }

    /// At most half of the speed in a cycle, at most a meganewton, and nothing where a force does not move the spacecraft.
    #[test]
    fn the_damping_is_bounded() {
        let mut settings = DelaySettings::default();
        settings.desired_restitution.stiffness_n_per_m = 1e8;
        settings.desired_restitution.restitution = 0.0;
        let mut law = DesiredRestitution::new(&settings, CYCLE_S);
        let found = cycle(&mut law, 500.0, 10.0, -0.01);
        assert!(
            (found - 10.0 - 0.5 * 0.01 * 250.0 / CYCLE_S).abs() < 1e-6,
            "{found}"
        );
        for sign in [1.0, -1.0] {
            let found = cycle(&mut law, 500.0, 10.0, sign * 100.0);
            assert!((found - 10.0 + sign * 1e6).abs() < 1e-6, "{found}");
        }
        let mut law = DesiredRestitution::new(&settings, CYCLE_S);
        assert_eq!(cycle(&mut law, 1e9, 10.0, -0.01), 10.0);
    }
}
