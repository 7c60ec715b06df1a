//! The mean reading at rest, which the `zero` command takes as the sensor's zero.

use crate::frames::Wrench;
use crate::scalar::Scalar;

/// Samples of the mean: 64 cycles are a quarter second.
const SAMPLES: u32 = 64;

/// Mean of the good samples: arithmetic for the first 64, then exponential with that many.
#[derive(Clone, Debug)]
pub struct RestMean<S: Scalar> {
    mean: Wrench<S>,
    samples: u32,
}

impl<S: Scalar> RestMean<S> {
    /// No sample yet.
    pub fn new() -> Self {
        Self {
            mean: Wrench::zero(),
            samples: 0,
        }
    }

    /// Takes a sample: the contact wrench in S.
    pub fn push(&mut self, contact: &Wrench<S>) {
        self.samples = (self.samples + 1).min(SAMPLES);
        let share = S::of(1.0 / f64::from(self.samples));
        self.mean = self.mean + (*contact - self.mean) * share;
    }

    /// The mean, once there are enough samples for one.
    pub fn get(&self) -> Option<Wrench<S>> {
        (self.samples == SAMPLES).then_some(self.mean)
    }
}

impl<S: Scalar> Default for RestMean<S> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_needs_64_samples_and_is_theirs() {
        let mut mean = RestMean::<f64>::new();
        for n in 0..63 {
            mean.push(&Wrench::of(&[f64::from(n), 0.0, 0.0, 0.0, 0.0, 0.0]));
            assert_eq!(mean.get(), None);
        }
        mean.push(&Wrench::of(&[63.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
        assert!((mean.get().unwrap().force.x - 31.5).abs() < 1e-12);
    }
}
