//! The correction as its decimal text carries it: integers of the last digit, with the rounding error carried over.
//!
//! RSI takes corrections in mm and degrees with a fixed number of decimals. The rounding error of one cycle must be added in the
//! next, or the robot drifts from the model. Here the whole displacement since the start is rounded and the part already sent is
//! subtracted, in integers: the sum of what was sent never differs from the intended value by more than half a last digit.
//!
//! Rotations: the robot adds A, B and C of the correction to its own A, B and C, component by
//! component. Corrections are therefore differences of A, B, C, not rotation vectors.

use crate::decimal::nearest;

/// Components X Y Z A B C of a correction, in units of the last digit of mm and degrees.
pub type Counts = [i64; 6];

/// Rounds corrections; keeps the sum of what was sent.
#[derive(Clone, Debug)]
pub struct Corrections {
    absolute: bool,
    counts_per_m: f64,
    counts_per_rad: f64,
    counts_per_turn: i64,
    /// A, B, C at the start, rad.
    start_abc: [f64; 3],
    /// Sum of everything sent since the start of the RSI run.
    total: Counts,
    /// That sum when the loop was closed.
    origin: Counts,
}

impl Corrections {
    /// For a number of decimals on the wire. `absolute`: each correction is the total offset (`#ABSOLUTE`), not
    /// added to those before (`#RELATIVE`).
    pub fn new(absolute: bool, decimals: u8) -> Self {
        let digit = (0..decimals).fold(1.0, |d, _| d * 10.0);
        Self {
            absolute,
            counts_per_m: 1000.0 * digit,
            counts_per_rad: digit * 180.0 / core::f64::consts::PI,
            counts_per_turn: 360 * digit as i64,
            start_abc: [0.0; 3],
            total: [0; 6],
            origin: [0; 6],
        }
    }

    /// A new RSI run: the robot has forgotten all corrections.
    pub fn new_run(&mut self) {
        self.total = [0; 6];
        self.origin = [0; 6];
    }

    /// The loop closes here: displacements count from this orientation (A, B, C in rad).
    pub fn start(&mut self, start_abc_rad: [f64; 3]) {
        self.start_abc = start_abc_rad;
        self.origin = self.total;
    }

    /// The answer that moves nothing: zero, or the offset that is held in absolute mode.
    pub fn rest(&self) -> Counts {
        if self.absolute { self.total } else { [0; 6] }
    }

    /// The answer that brings the robot to a displacement since the start (m in C) and to A, B, C
    /// (rad, absolute).
    pub fn advance(&mut self, displacement_m: [f64; 3], abc_rad: [f64; 3]) -> Counts {
        let [x, y, z] = displacement_m.map(|metres| nearest(metres * self.counts_per_m));
        let mut wanted = [x, y, z, 0, 0, 0];
        let angles = abc_rad.iter().zip(&self.start_abc);
        for (counts, (angle, start)) in wanted.iter_mut().skip(3).zip(angles) {
            *counts = nearest((angle - start) * self.counts_per_rad);
        }
        let mut delta = [0; 6];
        for (i, (delta, wanted)) in delta.iter_mut().zip(wanted).enumerate() {
            let [origin, total] =
                [self.origin, self.total].map(|sum| sum.get(i).copied().unwrap_or(0));
            *delta = origin + wanted - total;
            if i >= 3 {
                *delta = shortest(*delta, self.counts_per_turn);
            }
        }
        for (total, delta) in self.total.iter_mut().zip(delta) {
            *total += delta;
        }
        if self.absolute { self.total } else { delta }
    }
}

/// The same angle within half a turn, in counts; `turn` is a full turn.
fn shortest(counts: i64, turn: i64) -> i64 {
    (counts + turn / 2).rem_euclid(turn) - turn / 2
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The sum of what was sent stays within half a digit of what was meant, for ever.
        #[test]
        fn never_drifts(steps in prop::collection::vec(-1e-5..1e-5f64, 1..500)) {
            let mut corrections = Corrections::new(false, 4);
            corrections.start([3.1, 0.0, 0.0]);
            let (mut meant, mut sent) = (0.0, [0_i64; 6]);
            for step in steps {
                meant += step;
                let mut a = 3.1 + meant * 10.0;
                if a > core::f64::consts::PI {
                    a -= core::f64::consts::TAU;
                }
                let delta = corrections.advance([meant, 0.0, 0.0], [a, 0.0, 0.0]);
                for (s, d) in sent.iter_mut().zip(delta) {
                    *s += d;
                }
                prop_assert!((sent[0] as f64 * 1e-7 - meant).abs() <= 0.5001e-7);
                let turned = (sent[3] as f64 * 1e-4).to_radians();
                prop_assert!((turned - meant * 10.0).abs() <= 0.51e-4_f64.to_radians());
            }
        }
    }

    /// A, B, C jump by 360° where they pass ±180°; the robot must not.
    #[test]
    fn a_turn_through_180_degrees_is_a_small_correction() {
        for absolute in [false, true] {
            for (i, sign) in [(0, 1.0), (1, -1.0), (2, 1.0)] {
                let mut corrections = Corrections::new(absolute, 4);
                let at = |degrees: f64| {
                    let mut abc = [0.0; 3];
                    abc[i] = sign * degrees.to_radians();
                    abc
                };
                corrections.start(at(179.99));
                let mut answer = |degrees| corrections.advance([0.0; 3], at(degrees))[3 + i];
                let there = [answer(-179.99), answer(-179.96)];
                let back = [answer(-179.99), answer(179.98)];
                let counts = if absolute {
                    ([200, 500], [200, -100])
                } else {
                    ([200, 300], [-300, -300])
                };
                let signed = |pair: [i64; 2]| pair.map(|counts| counts * sign as i64);
                assert_eq!((there, back), (signed(counts.0), signed(counts.1)));
            }
        }
    }

    #[test]
    fn absolute_mode_holds_the_offset_at_rest_and_forgets_it_in_a_new_run() {
        let mut corrections = Corrections::new(true, 3);
        corrections.start([0.0; 3]);
        let sent = corrections.advance([0.001, 0.0, 0.0], [0.0; 3]);
        assert_eq!(sent[0], 1000);
        assert_eq!(corrections.rest()[0], 1000);
        corrections.start([0.0; 3]);
        assert_eq!(corrections.advance([0.001, 0.0, 0.0], [0.0; 3])[0], 2000);
        corrections.new_run();
        assert_eq!(corrections.rest(), [0; 6]);
    }
}
