//! The contact model F̂, a spring and damper behind a surface, and its identification. All per mass: accelerations in
//! mm/s², depths in mm.

use crate::scalar::Scalar;

/// Largest stiffness per mass, 1/s²: a natural frequency of 300 rad/s, beyond what a cycle of 4 ms
/// can follow.
const STIFFEST: f64 = 1e5;
/// Range of the identified stiffness around the given one.
const STIFFNESS_RANGE: [f64; 2] = [0.05, 20.0];
/// Samples from which a stiffness is identified.
const LEAST_SAMPLES: u32 = 3;

/// A spring and damper behind a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spring<S> {
    /// Given stiffness per mass, 1/s².
    given: S,
    /// Present stiffness per mass, 1/s².
    pub(super) stiffness: S,
    /// Damping per mass, 1/s.
    pub(super) damping: S,
    /// Position of the surface on the scale of the reported depth, mm; none before it is known.
    pub(super) surface: Option<S>,
    /// Weight of the given stiffness, mm².
    pub(super) ridge: S,
    identify: bool,
}

impl<S: Scalar> Spring<S> {
    /// Per mass, with the weight of the given stiffness in mm².
    pub(super) fn new(stiffness: S, damping: S, ridge: S, identify: bool) -> Self {
        let stiffness = stiffness.clamp(S::one(), S::of(STIFFEST));
        Self {
            given: stiffness,
            stiffness,
            damping: damping.min(S::of(1e3)),
            surface: None,
            ridge,
            identify,
        }
    }

    /// Push of the contact at a depth behind the surface; it never pulls. mm/s².
    pub(super) fn push(&self, depth: S, speed: S) -> S {
        if depth <= S::zero() {
            return S::zero();
        }
        (self.stiffness * depth + self.damping * speed).max(S::zero())
    }

    /// Fits surface and stiffness to samples: (depth on the reported scale, push, speed).
    pub(super) fn fit(&mut self, samples: impl Iterator<Item = (S, S, S)> + Clone) {
        let (mut count, mut depth, mut push) = (0u32, S::zero(), S::zero());
        let elastic = samples.map(|(s, a, v)| (s, a - self.damping * v));
        for (s, a) in elastic.clone() {
            (count, depth, push) = (count + 1, depth + s, push + a);
        }
        if count == 0 {
            return;
        }
        let share = S::of(1.0 / f64::from(count));
        let (depth, push) = (depth * share, push * share);
        if self.identify && count >= LEAST_SAMPLES {
            let (mut square, mut product) = (S::zero(), S::zero());
            for (s, a) in elastic {
                square += (s - depth) * (s - depth);
                product += (s - depth) * (a - push);
            }
            let found = (self.given * self.ridge + product) / (self.ridge + square);
            let [low, high] = STIFFNESS_RANGE.map(|factor| self.given * S::of(factor));
            self.stiffness = found.clamp(low, high).clamp(S::one(), S::of(STIFFEST));
        }
        self.surface = Some(depth - push / self.stiffness);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Fixed;

    fn finds<S: Scalar>(tolerance: f64) {
        let mut spring = Spring::<S>::new(S::of(300.0), S::zero(), S::of(1e-6), true);
        let samples = (0..12).map(|i| {
            let s = 0.01 * f64::from(i);
            (S::of(s), S::of(441.0 * (s + 0.005)), S::zero())
        });
        spring.fit(samples);
        assert!((spring.stiffness.get() / 441.0 - 1.0).abs() < tolerance);
        let surface = spring.surface.unwrap().get();
        assert!(
            (surface + 0.005).abs() < 0.005 * 10.0 * tolerance,
            "{surface}"
        );
    }

    #[test]
    fn stiffness_and_wall_are_found() {
        finds::<f64>(1e-3);
        finds::<f32>(1e-3);
        finds::<Fixed>(1e-3);
    }

    #[test]
    fn a_given_stiffness_is_kept() {
        let mut spring = Spring::<f64>::new(300.0, 0.0, 1e-6, false);
        spring.fit((0..12).map(|i| (f64::from(i), 441.0 * f64::from(i), 0.0)));
        assert_eq!(spring.stiffness, 300.0);
    }

    #[test]
    fn a_contact_never_pulls() {
        let spring = Spring::<f64>::new(400.0, 10.0, 1e-6, false);
        assert_eq!(spring.push(-1.0, 5.0), 0.0);
        assert_eq!(spring.push(0.1, -50.0), 0.0);
        assert_eq!(spring.push(0.1, 0.0), 40.0);
    }

    /// 1 to 10⁵/s², per effective mass, and a twentieth to twenty times the given one.
    #[test]
    fn a_stiffness_stays_in_its_range() {
        let spring = |stiffness, given| {
            let mut spring = Spring::<f64>::new(given, 0.0, 1e-6, true);
            spring.fit((0..12).map(|i| (f64::from(i), stiffness * f64::from(i), 0.0)));
            spring.stiffness
        };
        for (stiffness, given, expected) in [
            (300.0, 300.0, 300.0),
            (1e4, 300.0, 6000.0),
            (1.0, 300.0, 15.0),
            (1e9, 1e9, 1e5),
            (0.01, 0.1, 1.0),
        ] {
            let found = spring(stiffness, given);
            assert!(
                (found / expected - 1.0).abs() < 1e-6,
                "{stiffness}: {found}"
            );
        }
        assert_eq!(Spring::<f64>::new(300.0, 1e9, 1e-6, true).damping, 1e3);
    }

    /// A stiffness takes three samples at least. Two give only the surface, none give nothing.
    #[test]
    fn a_stiffness_is_identified_from_three_samples_on() {
        for (count, stiffness, surface) in [
            (0, 300.0, None),
            (1, 300.0, Some(5.0)),
            (2, 300.0, Some(5.0)),
            (3, 600.0, Some(4.0)),
        ] {
            let mut spring = Spring::<f64>::new(300.0, 2.0, 1e-9, true);
            let samples = [(7.0, 602.0, 1.0), (7.0, 602.0, 1.0), (4.0, 4.0, 2.0)];
            let samples = match count {
                3 => [(7.0, 1802.0, 1.0), (5.0, 604.0, 2.0), (6.0, 1200.0, 0.0)],
                _ => samples,
            };
            spring.fit(samples.into_iter().take(count));
            assert!(
                (spring.stiffness - stiffness).abs() < 1e-3,
                "{count}: {}",
                spring.stiffness
            );
            match (spring.surface, surface) {
                (Some(found), Some(surface)) => {
                    assert!((found - surface).abs() < 1e-6, "{count}: {found}")
                }
                (found, surface) => assert_eq!(found, surface, "{count}"),
            }
        }
    }
}
