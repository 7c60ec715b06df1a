//! Smith predictor behind a dead zone of the force, with an observer of the force that the zone removes.
//!
//! ```text
//! F_z = F_meas where |F_meas| ≥ δ in a component, else 0
//! d̂  += g (F̂(x_exec) − F_z − d̂)      |d̂| ≤ δ, in a contact alone
//! F   = F_z + F̂(x_model) − F̂(x_exec), and d̂ where F_z is 0
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
use crate::scalar::Scalar;

crate::described! {
/// Settings of the Smith predictor behind a dead zone; its contact is that of `smith`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct SmithDeadZoneSettings: "delay.smith_dead_zone" {
    /// δ: force below which nothing is felt, N.
    pub dead_zone_n: f64 = 1.0 => 0.0..=1e3,
    /// g: gain of the observer per cycle.
    pub observer_gain: f64 = 0.5 => 0.01..=1.0,
}
}

/// The law: a Smith predictor, with the dead zone and its observer before it.
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

    /// The wrench with which the model gets the velocity of the replayed contact.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::docking::{Docking, believed, between_walls, robot};
    use crate::delay::{Law, LawName, ModelVelocity};
    use softdock_delay_plants::{Actuator, Measurement};

    fn docking(law: LawName, dead_zone_n: f64, observer_gain: f64) -> Docking {
        let late = Actuator {
            pause_s: 0.0,
            ..robot()
        };
        let mut settings = believed(law, &late);
        settings.model_velocity = ModelVelocity::End;
        settings.smith.threshold_n = 1.0;
        settings.smith_dead_zone = SmithDeadZoneSettings {
            dead_zone_n,
            observer_gain,
        };
        Docking::new(
            &settings,
            &between_walls(late, 0.0, Measurement::default()),
            0.005,
        )
    }

    fn law(docking: &Docking) -> &SmithDeadZone<f64> {
        match &docking.law {
            Law::SmithDeadZone(law) => law,
            _ => panic!("another law"),
        }
    }

    #[test]
    fn without_a_dead_zone_it_is_the_smith_predictor() {
        let mut with = docking(LawName::SmithDeadZone, 0.0, 0.5);
        let mut without = docking(LawName::Smith, 0.0, 0.5);
        for n in 0..700 {
            with.step();
            without.step();
            assert_eq!(with.speed(), without.speed(), "{n}");
            assert_eq!(with.status, without.status);
        }
    }

    /// 0.9 N in free flight, against the motion.
    #[test]
    fn what_is_within_the_zone_is_not_felt() {
        for (force, felt) in [(-0.9, false), (0.9, false), (1.1, true)] {
            let mut docking = docking(LawName::SmithDeadZone, 1.0, 0.5);
            docking.run(150);
            docking.sample.wrench[0] = force;
            docking.step();
            assert_eq!(docking.speed() != 0.005, felt, "{force}");
        }
    }

    /// Of a contact, the zone removes what the contact model expects there. With a gain of 1 the observer shows this at once; it
    /// is zero when the contact is over.
    #[test]
    fn what_the_zone_swallows_is_what_the_contact_model_expects() {
        let (mut lost, mut least) = ([0.0; 2], f64::MAX);
        for (lost, gain) in lost.iter_mut().zip([1.0, 0.01]) {
            let mut docking = docking(LawName::SmithDeadZone, 5.0, gain);
            for _ in 0..330 {
                docking.step();
                let moments = &docking.plant.log().moments;
                let load = moments[moments.len().saturating_sub(2)].wrench[0].abs();
                let swallowed = law(&docking).swallowed;
                assert!(swallowed.abs() <= 5.0);
                if load < 5.0 && load > 0.1 {
                    *lost += load - swallowed;
                }
                if load >= 5.0 && gain == 1.0 {
                    least = least.min(swallowed.abs());
                }
            }
            assert_eq!(law(&docking).swallowed, 0.0);
        }
        assert!(least < 0.05, "{least}");
        assert!(lost[0].abs() < 0.3 * lost[1], "{lost:?}");
    }

    /// As if the sensor had measured it.
    #[test]
    fn what_is_swallowed_is_felt_within_the_zone() {
        let mut docking = docking(LawName::SmithDeadZone, 20.0, 1.0);
        let mut checked = 0;
        for _ in 0..330 {
            docking.step();
            let measured = Wrench::of(&docking.sample.wrench);
            let mut law = law(&docking).clone();
            let mut smith = law.smith.clone();
            let felt = law.condition(&docking.spacecraft.input(&measured));
            if measured.force.amax() < 20.0 && law.swallowed != 0.0 {
                let swallowed = smith.along(law.swallowed);
                let expected = smith.condition(&docking.spacecraft.input(&swallowed));
                assert_eq!(felt, expected);
                checked += 1;
            }
        }
        assert!(checked > 3, "{checked}");
    }

    /// The observer removes half of its error in each cycle.
    #[test]
    fn the_observer_comes_closer_by_its_gain() {
        let mut docking = docking(LawName::SmithDeadZone, 50.0, 0.5);
        while docking.plant.log().contacts.is_empty() {
            docking.step();
        }
        let mut checked = 0;
        for _ in 0..60 {
            let before = law(&docking).swallowed;
            let expected = law(&docking).smith.expected(&Wrench::zero());
            let within = docking.sample.wrench[0].abs() < 50.0;
            docking.step();
            if let (Some((_, expected)), true) = (expected, within) {
                let after = law(&docking).swallowed;
                let wanted = (before + 0.5 * (expected - before)).clamp(-50.0, 50.0);
                assert!((after - wanted).abs() < 1e-9, "{after} {wanted}");
                checked += 1;
            }
        }
        assert!(checked > 5, "{checked}");
    }
}
