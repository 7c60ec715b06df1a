//! Noise of measured quantities: of positions against the robot model, of the residuals of a fit, and of loads in free flight.

use super::V6;
use super::tuning::*;
use nalgebra::ComplexField;

/// Noise of the measured positions: mean squares of their differences from one cycle to the next.
#[derive(Clone, Debug, Default)]
pub(super) struct PositionNoise {
    /// Distance from the model, m.
    apart: V6,
    squares: V6,
    count: f64,
}

impl PositionNoise {
    /// Takes in a cycle's distance; `is_noise` tells whether its change counts as noise.
    pub(super) fn take(&mut self, apart: &V6, is_noise: bool) {
        let change = apart - self.apart;
        self.apart = *apart;
        if is_noise {
            self.squares += change.component_mul(&change);
            self.count += 1.0;
        }
    }

    /// Variance of the position of each axis, m²; that of one along the approach (`noise_m`) until enough samples are known.
    pub(super) fn variance(&self, noise_m: f64) -> V6 {
        if self.count < NOISE_SAMPLES {
            return V6::repeat(noise_m * noise_m);
        }
        self.squares / (2.0 * self.count)
    }
}

/// Noise of residuals, from their second differences: an error of structure is smooth and does not count.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ResidualNoise {
    last: [f64; 2],
    squares: f64,
    count: f64,
}

impl ResidualNoise {
    pub(super) fn add(&mut self, rest: f64) {
        let [before, earlier] = self.last;
        if self.count >= 2.0 {
            let second = rest - 2.0 * before + earlier;
            self.squares += second * second;
        }
        self.count += 1.0;
        self.last = [rest, before];
    }

    /// Standard deviation.
    pub(super) fn deviation(&self) -> f64 {
        ComplexField::sqrt(self.squares / (6.0 * (self.count - 2.0).max(1.0)))
    }
}

/// Noise of the load: mean squares of the six components in free flight, about zero, because a constant load without a contact is
/// an error as well.
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
        if self.count < NOISE_SAMPLES {
            return self.least;
        }
        ComplexField::sqrt(self.squares.amax() / self.count).max(self.least)
    }

    /// Norm above which a load is not noise, N: from the largest noise of the six components, and that of the others together.
    pub(super) fn threshold(&self) -> f64 {
        let largest = self.sigma();
        if self.count < NOISE_SAMPLES {
            return LOAD_SIGNIFICANCE * largest;
        }
        let others = (self.squares.sum() - self.squares.amax()).max(0.0) / self.count;
        LOAD_SIGNIFICANCE * largest + ComplexField::sqrt(others)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The difference between two cycles has twice the variance of a position; it counts from 16 differences on.
    #[test]
    fn the_noise_of_a_position_is_half_of_what_it_changes_by() {
        let mut noise = PositionNoise::default();
        let at =
            |n: i32| V6::new(1.0, -2.0, 0.0, 0.5, 0.0, 0.0) * if n % 2 == 0 { 1e-6 } else { -1e-6 };
        noise.take(&at(0), false);
        for n in 1..=16 {
            assert_eq!(noise.variance(3e-6), V6::repeat(3e-6 * 3e-6), "{n}");
            noise.take(&(V6::repeat(1.0)), false);
            noise.take(&at(n - 1), false);
            noise.take(&at(n), true);
        }
        let expected = at(0).component_mul(&at(0)) * 2.0;
        assert!((noise.variance(3e-6) - expected).amax() < 1e-24);
    }

    /// Second differences of white noise have √6 times its standard deviation; those of a straight line are zero, and of c n²
    /// they are 2 c.
    #[test]
    fn what_is_smooth_is_no_noise() {
        for (curvature, slope) in [(0.0, 0.3), (0.5, -2.0), (-0.1, 0.0)] {
            let mut noise = ResidualNoise::default();
            for n in 0..20 {
                let n = f64::from(n);
                noise.add(7.0 + slope * n + curvature * n * n);
            }
            let expected = 2.0 * f64::abs(curvature) / 6.0_f64.sqrt();
            assert!((noise.deviation() - expected).abs() < 1e-9, "{curvature}");
        }
        let mut two = ResidualNoise::default();
        two.add(1.0);
        two.add(5.0);
        assert_eq!(two.deviation(), 0.0);
    }

    /// 4.5 times the largest noise of the six, plus that of the others together; from 16 samples on, and no less than is set.
    #[test]
    fn a_load_is_significant_beyond_the_noise_of_free_flight() {
        let loads = |count: i32, size: f64| {
            let mut noise = LoadNoise::new(0.2);
            for n in 0..count {
                let sign = if n % 2 == 0 { size } else { -size };
                noise.add(&(V6::new(3.0, -2.0, 0.0, 6.0, 1.0, -2.0) * sign));
            }
            noise
        };
        for (noise, sigma, threshold) in [
            (loads(0, 1.0), 0.2, 0.9),
            (loads(15, 1.0), 0.2, 0.9),
            (loads(16, 1.0), 6.0, 27.0 + 18.0_f64.sqrt()),
            (loads(100, 1.0), 6.0, 27.0 + 18.0_f64.sqrt()),
            (loads(100, 0.01), 0.2, 0.9 + 0.01 * 18.0_f64.sqrt()),
        ] {
            assert!((noise.sigma() - sigma).abs() < 1e-12, "{}", noise.sigma());
            assert!(
                (noise.threshold() - threshold).abs() < 1e-12,
                "{}",
                noise.threshold()
            );
        }
    }
}
