//! The preload: the displacement into a contact beyond that of the ideal motion, which gives back the impulse that the delay has
//! taken.

use super::tuning::*;
use nalgebra::ComplexField;

/// A displacement into the contact in addition to the ideal motion. Up to the time at which a command of this cycle is executed
/// it is as commanded; from then on it stays, or is taken back until the contact ends.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Preload {
    /// At the time `executed_until_cycle`, and a cycle before, two cycles ..., m.
    displacement: [f64; PRELOAD_HISTORY],
    /// The time at which a command of this cycle is executed, cycles.
    executed_until_cycle: f64,
    /// Time at which it is taken back completely, cycles; `None`: it stays.
    end: Option<f64>,
}

impl Preload {
    /// The same moves, executed up to the time `executed_until_cycle`, and taken back linearly from then to `end`, if given;
    /// cycles.
    pub(super) fn planned(&self, executed_until_cycle: f64, end: Option<f64>) -> Self {
        Self {
            displacement: self.displacement,
            executed_until_cycle,
            end,
        }
    }

    /// A cycle later, with a new move (m).
    pub(super) fn advance(&mut self, by: f64) {
        let next = self.at(self.executed_until_cycle + 1.0) + by;
        self.displacement.rotate_right(1);
        self.displacement[0] = next;
    }

    /// At a time (cycles), m.
    pub(super) fn at(&self, cycle: f64) -> f64 {
        let before = self.executed_until_cycle - cycle;
        if before <= 0.0 {
            return self.displacement[0] * self.remaining_fraction(cycle);
        }
        let whole = ComplexField::floor(before);
        let of = |index: usize| self.displacement.get(index).copied().unwrap_or(0.0);
        let (later, earlier) = (of(whole as usize), of(whole as usize + 1));
        later + (earlier - later) * (before - whole)
    }

    /// Fraction of it that is left at a time (cycles).
    pub(super) fn remaining_fraction(&self, cycle: f64) -> f64 {
        let Some(end) = self.end.filter(|_| cycle > self.executed_until_cycle) else {
            return 1.0;
        };
        if cycle < end {
            (end - cycle) / (end - self.executed_until_cycle)
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::predictor::reference::Deviation;
    use crate::delay::predictor::scene::oblique;
    use crate::delay::spacecraft::CYCLE_S;

    /// Time of the onset, cycles.
    const ONSET: f64 = 100.5;

    /// Moves of 1, 2 ... 40 mm, each executed a cycle after the one before; linear in between.
    #[test]
    fn a_preload_is_the_sum_of_its_moves() {
        let mut preload = Preload::default();
        for n in 0..40 {
            preload = preload.planned(f64::from(n), None);
            preload.advance(1e-3 * f64::from(n + 1));
        }
        preload = preload.planned(40.0, None);
        let (_, reference) = oblique(0.0, ONSET);
        let mut pressed = reference;
        pressed.preload = preload;
        let sum = |n: i32| 0.5e-3 * f64::from(n * (n + 1));
        for n in 18..40 {
            for part in [0.0, 0.25, 0.5] {
                let cycle = f64::from(n) + part;
                let expected = sum(n) + (sum(n + 1) - sum(n)) * part;
                assert!((preload.at(cycle) - expected).abs() < 1e-12, "{cycle}");
                // Deeper than the bounce by the preload.
                let with: [Deviation; 4] = pressed.deviations(cycle - 3.0, CYCLE_S);
                let without: [Deviation; 4] = reference.deviations(cycle - 3.0, CYCLE_S);
                let deeper = without[3].displacement - with[3].displacement;
                assert!((deeper - expected).abs() < 1e-12, "{cycle}");
            }
        }
        // From then on it stays; what is older than the history is not kept.
        for (cycle, expected) in [
            (40.0, sum(40)),
            (41.3, sum(40)),
            (90.0, sum(40)),
            (10.0, 0.0),
        ] {
            assert!((preload.at(cycle) - expected).abs() < 1e-12, "{cycle}");
        }
    }

    /// Executed up to cycle 20, and none of it is left at 30.
    #[test]
    fn a_preload_is_taken_back_straight_until_its_end() {
        let mut preload = Preload::default();
        for _ in 0..2 {
            preload.advance(1e-3);
        }
        preload = preload.planned(20.0, Some(30.0));
        for (cycle, expected) in [
            (19.0, 1.0),
            (19.5, 1.5),
            (20.0, 2.0),
            (20.5, 1.9),
            (25.0, 1.0),
            (29.0, 0.2),
            (30.0, 0.0),
            (99.0, 0.0),
        ] {
            let found = preload.at(cycle) * 1e3;
            assert!((found - expected).abs() < 1e-12, "{cycle}: {found}");
        }
        // A new move is added to what is left by then.
        preload.advance(1e-3);
        assert!((preload.displacement[0] - 2.8e-3).abs() < 1e-15);
    }
}
