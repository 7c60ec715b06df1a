//! Noise of the load, from the approach, and what stands out of it.

use super::V6;
use nalgebra::ComplexField;

/// A load this many standard deviations from zero is a contact.
const STANDS_OUT: f64 = 4.5;
/// Samples before the measured noise counts.
const ENOUGH: f64 = 16.0;

/// Running mean squares of the six loads in free flight, about zero: a load that is there without
/// a contact is an error as well.
#[derive(Clone, Debug)]
pub(super) struct LoadNoise {
    least: f64,
    squares: V6,
    count: f64,
}

impl LoadNoise {
    /// `least` standard deviation that is assumed, N.
    pub(super) fn new(least: f64) -> Self {
        Self {
            least,
            squares: V6::zeros(),
            count: 0.0,
        }
    }

    /// A load in free flight.
    pub(super) fn add(&mut self, load: &V6) {
        self.squares += load.component_mul(load);
        self.count += 1.0;
    }

    /// Largest standard deviation of the six, N.
    pub(super) fn sigma(&self) -> f64 {
        if self.count < ENOUGH {
            return self.least;
        }
        ComplexField::sqrt(self.squares.amax() / self.count).max(self.least)
    }

    /// Size of a load that does not come from noise, N: of the loudest of the six, and of the others
    /// together.
    pub(super) fn threshold(&self) -> f64 {
        let largest = self.sigma();
        if self.count < ENOUGH {
            return STANDS_OUT * largest;
        }
        let others = (self.squares.sum() - self.squares.amax()).max(0.0) / self.count;
        STANDS_OUT * largest + ComplexField::sqrt(others)
    }
}
