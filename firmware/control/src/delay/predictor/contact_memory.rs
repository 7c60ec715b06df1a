//! The contact memory of a run: where a contact is expected, the robot reverses before the load is measured.

use super::V6;
use super::contact::Contact;
use super::contact_estimator::{Estimate, Information};
use super::reference::Reference;
use super::tuning::*;

/// A contact that was identified.
#[derive(Clone, Debug)]
struct Remembered {
    direction: V6,
    latency: usize,
    information: Information,
    estimate: Estimate,
}

/// The contacts of a run, by the directions of their loads.
#[derive(Clone, Debug, Default)]
pub(super) struct ContactMemory {
    kept: [Option<Remembered>; REMEMBERED_CONTACTS],
    /// The slot that is overwritten next.
    next: usize,
}

impl ContactMemory {
    /// The latency and information of the remembered contact with a load of this direction; `None` if there is none.
    pub(super) fn of(&self, direction: &V6) -> Option<(usize, &Information)> {
        let same = |known: &&Remembered| cosine(&known.direction, direction) > SAME_CONTACT;
        let known = self.kept.iter().flatten().find(same)?;
        Some((known.latency, &known.information))
    }

    /// Remembers a contact in place of an earlier one of the same direction.
    pub(super) fn keep(&mut self, contact: &Contact, latency: usize) {
        let (direction, _) = contact.direction();
        let same = |slot: &Option<Remembered>| {
            slot.as_ref()
                .is_none_or(|known| cosine(&known.direction, &direction) > SAME_CONTACT)
        };
        let index = self.kept.iter().position(same).unwrap_or(self.next);
        self.next = (index + 1) % REMEMBERED_CONTACTS;
        if let Some(slot) = self.kept.get_mut(index) {
            *slot = Some(Remembered {
                direction,
                latency,
                information: contact.information(latency),
                estimate: *contact.estimate(latency),
            });
        }
    }

    /// The next expected contact, for a straight flight from a position at a cycle: the nearest of those within a horizon
    /// (cycles), as reference and estimate. A contact that should have been felt already is forgotten.
    pub(super) fn ahead(
        &mut self,
        (cycle, position, velocity): (usize, &V6, &V6),
        horizon: f64,
        cycle_s: f64,
    ) -> Option<(Reference, Estimate)> {
        let mut nearest: Option<(f64, Estimate)> = None;
        for slot in &mut self.kept {
            let Some(known) = slot else { continue };
            let estimate = known.estimate;
            let closing = estimate.gradient.dot(velocity);
            if closing <= LEAST_CLOSING * velocity.norm() {
                continue;
            }
            let distance = estimate.surface - estimate.gradient.dot(position);
            let cycles = distance / (closing * cycle_s);
            if cycles < -MISSED_CONTACT {
                *slot = None;
            } else if cycles < horizon && nearest.is_none_or(|(best, _)| cycles < best) {
                nearest = Some((cycles, estimate));
            }
        }
        let (cycles, estimate) = nearest?;
        let onset = (
            cycle as f64 + cycles,
            position + velocity * (cycles * cycle_s),
        );
        let closing = estimate.gradient.dot(velocity);
        let reference = Reference::into_contact(&estimate, onset, (*velocity, closing));
        Some((reference, estimate))
    }
}

fn cosine(a: &V6, b: &V6) -> f64 {
    a.dot(b) / (a.norm() * b.norm()).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::predictor::bounce::{Bounce, MASS, STIFFNESS, x};
    use crate::delay::spacecraft::CYCLE_S;

    /// A contact whose surface is at this depth along a direction.
    fn known(direction: V6, surface: f64, latency: usize) -> Remembered {
        let mut estimate = Estimate::exact(STIFFNESS, 0.0, MASS);
        (estimate.gradient, estimate.push, estimate.surface) = (direction, direction, surface);
        Remembered {
            direction,
            latency,
            information: Information::new(V6::zeros()),
            estimate,
        }
    }

    /// Directions within 18° are the same contact: cosine 0.95.
    #[test]
    fn a_contact_is_known_by_the_direction_of_its_load() {
        let y = V6::ith(1, 1.0);
        let memory = ContactMemory {
            kept: [Some(known(x(1.0), 0.1, 2)), Some(known(-y, 0.1, 3))],
            next: 0,
        };
        let turned = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            (x(1.0) * cos + y * sin) * 40.0
        };
        for (degrees, latency) in [
            (0.0, Some(2)),
            (18.0, Some(2)),
            (19.0, None),
            (-71.0, None),
            (-73.0, Some(3)),
            (90.0, None),
        ] {
            let found = memory.of(&turned(degrees)).map(|(latency, _)| latency);
            assert_eq!(found, latency, "{degrees}");
        }
        assert!(cosine(&V6::zeros(), &x(1.0)) == 0.0);
    }

    /// A contact replaces the one of its direction, or else the oldest.
    #[test]
    fn two_contacts_are_remembered() {
        let mut memory = ContactMemory::default();
        let contact = Bounce::spring(0.5).followed(0.01, 20);
        let along = |direction: V6| {
            let mut contact = contact.clone();
            contact.load_sum = direction;
            contact
        };
        let latencies = |memory: &ContactMemory| {
            [0, 1, 2].map(|i| memory.of(&V6::ith(i, 1.0)).map(|(latency, _)| latency))
        };
        for (i, latency, kept) in [
            (0, 1, [Some(1), None, None]),
            (0, 2, [Some(2), None, None]),
            (1, 3, [Some(2), Some(3), None]),
            (0, 4, [Some(4), Some(3), None]),
            (2, 0, [Some(4), None, Some(0)]),
            (1, 1, [None, Some(1), Some(0)]),
        ] {
            memory.keep(&along(V6::ith(i, 30.0)), latency);
            assert_eq!(latencies(&memory), kept, "{i}");
        }
    }

    /// Straight on at 5 mm/s, 20 µm in a cycle.
    fn ahead(memory: &mut ContactMemory, position: f64, velocity: V6) -> Option<(f64, V6)> {
        let at = V6::new(position, 0.7, 0.0, 0.0, 0.0, 0.0);
        let found = memory.ahead((1000, &at, &velocity), 36.0, CYCLE_S);
        found.map(|(reference, estimate)| {
            let closing = estimate.gradient.dot(&velocity);
            assert_eq!((reference.closing, reference.velocity), (closing, velocity));
            (reference.onset, reference.position)
        })
    }

    #[test]
    fn a_contact_that_is_remembered_begins_where_it_was() {
        let velocity = V6::new(0.005, 0.001, 0.0, 0.0, 0.0, 0.0);
        for (distance, comes) in [
            (20.0, true),
            (35.5, true),
            (36.5, false),
            (-5.5, true),
            (-6.5, false),
        ] {
            let mut memory = ContactMemory {
                kept: [None, Some(known(x(1.0), 0.1, 0))],
                next: 0,
            };
            let found = ahead(&mut memory, 0.1 - distance * 2e-5, velocity);
            assert_eq!(found.is_some(), comes, "{distance}");
            if let Some((onset, position)) = found {
                assert!((onset - 1000.0 - distance).abs() < 1e-9);
                let expected = V6::new(0.1, 0.7 + distance * 4e-6, 0.0, 0.0, 0.0, 0.0);
                assert!((position - expected).amax() < 1e-12, "{position}");
            }
            // One that should have been felt is forgotten.
            assert_eq!(memory.kept[1].is_some(), distance > -6.0, "{distance}");
        }
    }

    #[test]
    fn the_nearest_of_the_contacts_on_the_way_is_ahead() {
        let other = V6::new(0.8, 0.6, 0.0, 0.0, 0.0, 0.0);
        for swapped in [false, true] {
            let mut kept = [
                Some(known(x(1.0), 0.1, 0)),
                Some(known(
                    other,
                    other.dot(&V6::new(0.1 - 1e-4, 0.7, 0.0, 0.0, 0.0, 0.0)),
                    0,
                )),
            ];
            if swapped {
                kept.swap(0, 1);
            }
            let mut memory = ContactMemory { kept, next: 0 };
            let (onset, _) = ahead(&mut memory, 0.1 - 3e-4, x(0.005)).unwrap();
            assert!((onset - 1010.0).abs() < 1e-6, "{onset}");
        }
    }

    /// Closing in with a thousandth of the velocity is no approach.
    #[test]
    fn a_contact_that_is_not_on_the_way_is_kept_but_not_expected() {
        for (closing, comes) in [(-0.005, false), (4.9e-6, false), (5.1e-6, true)] {
            let across = f64::sqrt(0.005 * 0.005 - closing * closing);
            let velocity = V6::new(closing, across, 0.0, 0.0, 0.0, 0.0);
            let mut memory = ContactMemory {
                kept: [Some(known(x(1.0), 0.1, 0)), None],
                next: 0,
            };
            let found = ahead(&mut memory, 0.1 - 10.0 * closing * CYCLE_S, velocity);
            assert_eq!(found.is_some(), comes, "{closing}");
            let missed = ahead(&mut memory, 0.1 - 10.0 * closing * CYCLE_S + 1.0, x(-0.005));
            assert!(missed.is_none() && memory.kept[0].is_some(), "{closing}");
        }
    }
}
