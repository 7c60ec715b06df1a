//! Time-domain passivity: an observer sums the energy that the loop generates, and a controller removes it from the model by
//! damping.
//!
//! ```text
//! E += F (v_exec − v_model) Ts        while E < 0: the model is damped by −E
//! ```
//!
//! De Stefano, Balachandran and Secchi, "A passivity-based approach for simulating satellite
//! dynamics with robots: discrete-time integration and time-delay compensation", IEEE Trans. Robot.
//! 36 (2020) 189. F v_exec is the power of the wall on the robot, from measured force and measured motion; F v_model is the power
//! that the model takes from it. A negative sum of the difference is energy that the loop has generated.
//!
//! Choices that the equation leaves open:
//! - One observer per contact, along its direction (`contact`). It is reset at each contact, so that energy that a damped contact
//!   dissipated does not offset what the next one generates.
//! - The work on the robot is the trapezoidal sum of force over measured motion. The model's part is the exact change of its
//!   kinetic energy along the contact, so that the error of the integrator is counted, too.
//! - A cycle takes away at most `largest_share` of the model's speed. Without this bound the model stops before the robot has
//!   reversed, and stays at rest: the energy that the wall still holds can only come back while the model moves out.
//!
//! It can only remove energy. The rebound of an elastic contact comes out right; force, duration
//! and the motion in between do not. A contact with damping ends too slow or does not end: what the wall
//! really dissipates is counted as energy that the model may not have.

use super::contact::{Along, ContactLine, LATENCIES, saturated};
use super::status::{LawFlags, LawStatus};
use super::{DelaySettings, LawInput};
use crate::frames::Wrench;
use crate::scalar::Scalar;

/// Ranges in which energy per mass, mm²/s², speed, mm/s, and acceleration, mm/s², stay.
const LARGEST_ENERGY: f64 = 1e8;
const FASTEST_MM_S: f64 = 1e4;
const LARGEST_MM_S2: f64 = 1e5;
/// Likewise, motion in a cycle, mm.
const LONGEST_MM: f64 = 1e2;
/// Largest force that damps, N.
const LARGEST_N: f64 = 1e6;

crate::described! {
/// Settings of the passivity observer and controller.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct PassivitySettings: "delay.passivity" {
    /// Force from which a contact counts, N: beyond the sensor's noise.
    pub threshold_n: f64 = 1.0 => 0.01..=1e3,
    /// Part of the model's speed that a cycle takes away at most.
    pub largest_share: f64 = 0.3 => 0.01..=0.9,
}
}

/// Observer and controller, as a law or beside one.
#[derive(Clone, Debug)]
pub struct Passivity<S: Scalar> {
    line: ContactLine<S>,
    ts: S,
    share_kept: S,
    /// Energy per mass that the loop has dissipated, mm²/s²; negative: that it has generated.
    energy: S,
    /// Acceleration of the last cycle by the measured force, mm/s².
    last_pull: S,
    /// Energy per mass that the model took in the last cycles, newest first. It is delayed like the reported pose, with which the
    /// work on the robot is computed.
    taken: [S; LATENCIES],
    latency: usize,
    damped: bool,
}

impl<S: Scalar> Passivity<S> {
    /// No contact yet; `cycle_s` in s.
    pub fn new(settings: &DelaySettings, cycle_s: f64) -> Self {
        let own = &settings.passivity;
        Self {
            line: ContactLine::new(own.threshold_n, &settings.actuator),
            ts: S::of(cycle_s),
            share_kept: S::of(1.0 - own.largest_share),
            energy: S::zero(),
            last_pull: S::zero(),
            taken: [S::zero(); LATENCIES],
            latency: settings.actuator.feedback_latency_cycles.into(),
            damped: false,
        }
    }

    /// `felt` plus the damping force that passivity asks for. `felt` is what the model would feel without it.
    pub fn condition(&mut self, input: &LawInput<'_, S>, felt: Wrench<S>) -> Wrench<S> {
        self.damped = false;
        let Some(along) = self.line.update(input) else {
            return felt;
        };
        let to_mm = S::of(1e3);
        let velocity = saturated(along.velocity * to_mm, FASTEST_MM_S);
        let pull = self.pull(self.line.load(&felt), &along);
        let after = saturated(velocity + pull * self.ts, FASTEST_MM_S);
        self.observe(&along, velocity, after);
        self.line.close_when_quiet();
        let Some(slower) = self.damp(after) else {
            return felt;
        };
        // A force that cannot move the model cannot damp it.
        if along.mobility <= S::of(1e-8) {
            return felt;
        }
        let (wanted, most) = ((slower - after) / self.ts, S::of(LARGEST_N));
        // Checked before the division: in fixed point the quotient would overflow.
        let force = if wanted.abs() * S::of(1e-3) < along.mobility * most {
            wanted / along.mobility * S::of(1e-3)
        } else if wanted < S::zero() {
            -most
        } else {
            most
        };
        felt + self.line.wrench(force)
    }

    /// Status: whether a contact is open, and whether the model is damped in this cycle.
    pub fn status(&self) -> LawStatus {
        let mut status = self.line.status();
        if self.damped {
            status.flags.set(LawFlags::GUARD_PASSIVE);
        }
        status
    }

    /// Acceleration along the contact by a force, mm/s².
    fn pull(&self, load: S, along: &Along<S>) -> S {
        // For small masses: the product must stay within fixed point before it is limited.
        let load = saturated(load, 1e5);
        saturated(load * along.mobility, LARGEST_MM_S2 * 1e-3) * S::of(1e3)
    }

    /// E += work of the wall on the robot − energy that the model took.
    fn observe(&mut self, along: &Along<S>, velocity: S, after: S) {
        let half = S::of(0.5);
        let pull = self.pull(along.load_then, along);
        if along.opened {
            self.energy = S::zero();
            self.last_pull = S::zero();
            self.taken = [S::zero(); LATENCIES];
        }
        let moved = saturated(along.moved * S::of(1e3), LONGEST_MM);
        let paid = (pull + self.last_pull) * half * moved;
        self.last_pull = pull;
        self.taken.rotate_right(1);
        self.taken[0] = (after - velocity) * (after + velocity) * half;
        let taken = self.taken[self.latency.min(LATENCIES - 1)];
        self.energy = saturated(self.energy + paid - taken, LARGEST_ENERGY);
    }

    /// The velocity along the contact after the generated energy is removed, mm/s. `None` if there is none to remove, or no
    /// contact.
    fn damp(&mut self, after: S) -> Option<S> {
        if self.energy >= S::zero() || !self.line.is_open() {
            return None;
        }
        let half = S::of(0.5);
        let square = after * after;
        let left = (square + self.energy + self.energy).max(S::zero()).sqrt();
        let speed = left.max(after.abs() * self.share_kept);
        self.energy += (square - speed * speed) * half;
        self.damped = true;
        Some(if after < S::zero() { -speed } else { speed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::spacecraft::{CYCLE_S, Spacecraft};
    use crate::frames::Twist;
    use crate::settings::BodySettings;

    /// The law for a reported pose that is this many cycles late.
    fn law(latency: u8) -> Passivity<f64> {
        let mut settings = DelaySettings::default();
        settings.actuator.feedback_latency_cycles = latency;
        Passivity::new(&settings, 0.004)
    }

    /// A cycle of 500 kg: loads now and at the time of the reported pose, N, and motion, m.
    fn cycle(opened: bool, load: f64, moved: f64) -> Along<f64> {
        Along {
            opened,
            load,
            load_then: load,
            moved,
            velocity: 0.0,
            mobility: 0.002,
        }
    }

    fn assert_near(found: f64, expected: f64) {
        let apart = (found - expected).abs();
        assert!(apart <= 1e-9 * expected.abs(), "{found} {expected}");
    }

    #[test]
    fn an_acceleration_is_that_of_the_load_and_stays_in_its_range() {
        for (load, mobility, expected) in [
            (100.0, 0.002, 200.0),
            (-100.0, 0.002, -200.0),
            (1e7, 0.0005, 5e4),
            (-1e7, 0.0005, -5e4),
            (1e5, 1.0, LARGEST_MM_S2),
            (-1e5, 1.0, -LARGEST_MM_S2),
        ] {
            let mut along = cycle(false, 0.0, 0.0);
            along.mobility = mobility;
            assert_near(law(0).pull(load, &along), expected);
        }
    }

    /// 100 and 200 N on 500 kg are 200 and 400 mm/s²; the force is linear in between. Energies in mm²/s².
    #[test]
    fn the_energy_is_what_the_wall_did_on_the_robot_less_what_the_model_took() {
        let mut law = law(0);
        law.observe(&cycle(true, 100.0, 0.001), 10.0, 8.0);
        assert_near(law.energy, 100.0 * 1.0 + 18.0);
        law.observe(&cycle(false, 200.0, -0.0005), 8.0, 12.0);
        assert_near(law.energy, 118.0 - 300.0 * 0.5 - 40.0);
        // The next contact begins anew.
        law.observe(&cycle(true, 100.0, 0.001), 0.0, 2.0);
        assert_near(law.energy, 100.0 * 1.0 - 2.0);
    }

    #[test]
    fn what_the_model_took_is_counted_when_the_pose_of_then_is_reported() {
        let mut law = law(2);
        law.observe(&cycle(true, 0.0, 0.0), 0.0, 10.0);
        law.observe(&cycle(false, 0.0, 0.0), 10.0, 10.0);
        assert_eq!(law.energy, 0.0);
        law.observe(&cycle(false, 0.0, 0.0), 10.0, 10.0);
        assert_near(law.energy, -50.0);
    }

    /// Of a jump of the pose at most 0.1 m counts, and the energy stays within its range.
    #[test]
    fn motion_and_energy_stay_in_their_ranges() {
        for sign in [1.0, -1.0] {
            let mut law = law(0);
            law.observe(&cycle(true, 100.0, sign * 3.0), 0.0, 0.0);
            assert_near(law.energy, sign * 100.0 * LONGEST_MM);
            for _ in 0..100 {
                law.observe(&cycle(false, 1e7, sign * 3.0), 0.0, 0.0);
            }
            assert_near(law.energy, sign * LARGEST_ENERGY);
        }
    }

    #[test]
    fn nothing_is_damped_outside_of_a_contact() {
        let mut law = law(0);
        law.energy = -1.0;
        assert_eq!(law.damp(5.0), None);
        assert_eq!(law.status(), LawStatus::default());
    }

    #[test]
    fn its_status_says_when_it_damps() {
        let mut law = law(0);
        law.damped = true;
        let mut expected = LawStatus::default();
        expected.flags.set(LawFlags::GUARD_PASSIVE);
        assert_eq!(law.status(), expected);
    }

    /// Two spacecraft of this mass at rest that feel a force along x, N, with this velocity of the model along it, m/s. Returns
    /// the force with the damping, and the velocity that is left.
    fn condition_of(
        mass_kg: f64,
        law: &mut Passivity<f64>,
        force: f64,
        velocity: f64,
    ) -> (f64, f64) {
        let body = BodySettings {
            mass_kg,
            ..BodySettings::default()
        };
        let spacecraft = Spacecraft::new(&body, &body);
        let model = Twist::of(&[velocity, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let wrench = Wrench::of(&[force, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let input = spacecraft.asked(&wrench, model);
        let felt = law.condition(&input, wrench);
        let change = spacecraft.bodies.mobility(input.state, &felt).linear.x * CYCLE_S;
        (felt.force.x, velocity + change)
    }

    fn condition(law: &mut Passivity<f64>, force: f64, velocity: f64) -> (f64, f64) {
        condition_of(500.0, law, force, velocity)
    }

    /// In a contact: removing 18 mm²/s² from 10 mm/s leaves 8 mm/s, and at most 0.3 of the speed is removed in a cycle.
    #[test]
    fn the_energy_that_was_made_is_taken_from_the_model() {
        let mut law = law(0);
        assert_eq!(condition(&mut law, 100.0, -0.005).0, 100.0);
        let mut contact = LawStatus::default();
        contact.flags.set(LawFlags::CONTACT);
        assert_eq!(law.status(), contact);
        for (energy, left, rest) in [(-18.0, 8.0, 0.0), (-1000.0, 7.0, -974.5)] {
            for sign in [1.0, -1.0] {
                law.energy = energy;
                assert_near(law.damp(sign * 10.0).unwrap(), sign * left);
                assert!((law.energy - rest).abs() < 1e-9);
            }
        }
        law.energy = 0.0;
        assert_eq!(law.damp(10.0), None);
    }

    #[test]
    fn the_damping_is_a_force_that_leaves_that_velocity() {
        for velocity in [0.5, -0.05] {
            let mut law = law(0);
            condition(&mut law, 100.0, -0.005);
            let (_, free) = condition(&mut law.clone(), 0.0, velocity);
            law.energy = -1e6;
            let (_, left) = condition(&mut law, 0.0, velocity);
            assert_near(left, 0.7 * free);
            assert!(law.status().flags.has(LawFlags::GUARD_PASSIVE));
        }
    }

    /// Two spacecraft of 50,000 t at 10 m/s: removing 30 % of that in a cycle would take 19 GN.
    #[test]
    fn the_damping_is_no_larger_than_its_largest_force() {
        for (mass_kg, limited) in [(5e7, true), (1e7, true), (100.0, false)] {
            for sign in [1.0, -1.0] {
                let mut law = law(0);
                condition_of(mass_kg, &mut law, 100.0, -0.005);
                law.energy = -1e8;
                let (force, _) = condition_of(mass_kg, &mut law, 0.0, sign * 10.0);
                assert_eq!(force == -sign * LARGEST_N, limited, "{mass_kg}: {force}");
                assert!(force * sign < 0.0 && force.abs() <= LARGEST_N);
            }
        }
    }

    /// Two spacecraft of 10^9 kg each: 1 N changes the velocity by 2e-9 m/s in a second.
    #[test]
    fn what_a_push_cannot_move_is_not_damped() {
        let mut law = law(0);
        condition_of(1e9, &mut law, 100.0, -0.005);
        law.energy = -1e8;
        assert_eq!(condition_of(1e9, &mut law, 5.0, 10.0).0, 5.0);
    }

    /// The settings allow eight cycles.
    #[test]
    fn a_pose_that_is_older_than_all_that_is_kept_counts_as_the_oldest() {
        let mut law = law(200);
        law.observe(&cycle(true, 0.0, 0.0), 0.0, 10.0);
        for _ in 0..8 {
            assert_eq!(law.energy, 0.0);
            law.observe(&cycle(false, 0.0, 0.0), 10.0, 10.0);
        }
        assert_near(law.energy, -50.0);
    }

    #[test]
    fn settings_beyond_their_range_are_refused() {
        let settings = |threshold_n, largest_share| PassivitySettings {
            threshold_n,
            largest_share,
        };
        assert!(PassivitySettings::default().check_ranges().is_ok());
        for refused in [
            settings(0.0, 0.3),
            settings(2e3, 0.3),
            settings(1.0, 0.0),
            settings(1.0, 1.0),
        ] {
            assert!(refused.check_ranges().is_err(), "{refused:?}");
        }
    }
}
