//! Reproducible random numbers: the same seed gives the same run on every machine.

use nalgebra::ComplexField;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// 2⁻⁵³: spacing of the uniform numbers.
const UNIT: f64 = 1.0 / (1_u64 << 53) as f64;

/// 32-bit words in a block of ChaCha.
const WORDS_PER_PLACE: u128 = 16;

/// One independent stream of random numbers.
#[derive(Clone, Debug)]
pub struct RandomStream {
    generator: ChaCha8Rng,
    spare: Option<f64>,
}

impl RandomStream {
    /// Streams of one seed are independent: enabling one source of noise does not change the others.
    pub fn new(seed: u64, stream: u64) -> Self {
        Self::at(seed, stream, 0)
    }

    /// A stream that begins at a place within it. Places are 512 bits apart: draws from two places are independent as long as
    /// those from one do not reach the other.
    pub fn at(seed: u64, stream: u64, place: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stream);
        generator.set_word_pos(u128::from(place) * WORDS_PER_PLACE);
        Self {
            generator,
            spare: None,
        }
    }

    /// Uniform in (0, 1].
    pub fn uniform(&mut self) -> f64 {
        ((self.generator.next_u64() >> 11) + 1) as f64 * UNIT
    }

    /// Standard normal (Box-Muller), by the portable mathematics library.
    pub fn normal(&mut self) -> f64 {
        if let Some(value) = self.spare.take() {
            return value;
        }
        let radius = ComplexField::sqrt(-2.0 * ComplexField::ln(self.uniform()));
        let (sin, cos) = ComplexField::sin_cos(core::f64::consts::TAU * self.uniform());
        self.spare = Some(radius * sin);
        radius * cos
    }

    /// `value` plus normal noise; a sigma of 0 draws nothing.
    pub fn around(&mut self, value: f64, sigma: f64) -> f64 {
        if sigma > 0.0 {
            value + sigma * self.normal()
        } else {
            value
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_numbers_have_the_moments_of_the_normal_distribution() {
        let mut noise = RandomStream::new(7, 1);
        let n = 200_000;
        let x: Vec<f64> = (0..n).map(|_| noise.normal()).collect();
        let moment = |p| x.iter().map(|v| v.powi(p)).sum::<f64>() / f64::from(n);
        for (p, expected, tolerance) in [
            (1, 0.0, 0.01),
            (2, 1.0, 0.02),
            (3, 0.0, 0.04),
            (4, 3.0, 0.1),
        ] {
            assert!(
                (moment(p) - expected).abs() < tolerance,
                "{p}: {}",
                moment(p)
            );
        }
    }

    #[test]
    fn streams_differ_and_seeds_repeat() {
        let draw = |seed, stream| RandomStream::new(seed, stream).uniform();
        assert_eq!(draw(1, 0), draw(1, 0));
        assert_ne!(draw(1, 0), draw(1, 1));
        assert_ne!(draw(1, 0), draw(2, 0));
        let at = |place| RandomStream::at(1, 0, place).uniform();
        assert_eq!(at(0), draw(1, 0));
        assert_ne!(at(0), at(1));
        assert_ne!(at(u64::MAX), at(1));
    }
}
