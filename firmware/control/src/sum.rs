//! A sum of many small velocities without loss by rounding.

use crate::frames::components;
use crate::scalar::Scalar;
use nalgebra::Vector3;

/// The sum of the velocities that were sent, m/s: times the cycle, the commanded translation.
///
/// Adding steps of a micrometre to a decimetre rounds each of them, in the same direction while the velocity is constant: an hour
/// between two walls leaves 5 µm in f32, and 0.1 mm in fixed point, where each product with the cycle time is rounded down. Here
/// velocities are added, which is exact in fixed point, and the rounding error of a float is carried into the next addition
/// (Kahan, "Further remarks on reducing truncation errors", CACM 8(1), 1965).
#[derive(Clone, Copy, Debug)]
pub(crate) struct VelocitySum<S: Scalar> {
    sum: Vector3<S>,
    /// Excess of `sum` over the exact sum.
    excess: Vector3<S>,
}

impl<S: Scalar> VelocitySum<S> {
    /// Nothing yet.
    pub(crate) fn zero() -> Self {
        Self {
            sum: Vector3::zeros(),
            excess: Vector3::zeros(),
        }
    }

    /// Adds a cycle's velocity, m/s.
    pub(crate) fn add(&mut self, velocity: &Vector3<S>) {
        let missing = velocity - self.excess;
        let sum = self.sum + missing;
        self.excess = (sum - self.sum) - missing;
        self.sum = sum;
    }

    /// The translation, m, in the precision of the cycle.
    pub(crate) fn translation(&self, ts: S) -> Vector3<S> {
        self.sum * ts
    }

    /// The translation, m, in f64: it is rounded to the digits of a correction.
    pub(crate) fn translation_m(&self, cycle_s: f64) -> [f64; 3] {
        let (sum, excess) = (components(&self.sum), components(&self.excess));
        core::array::from_fn(|i| (sum[i] - excess[i]) * cycle_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::vector;
    use crate::scalar::Fixed;

    /// An hour at slightly more than 1 mm/s, whose steps of 4 µm the scalar rounds.
    fn an_hour<S: Scalar>() -> f64 {
        let velocity = vector::<S>(&[1.234_567e-3, 0.0, 0.0]);
        let mut sum = VelocitySum::zero();
        (0..900_000).for_each(|_| sum.add(&velocity));
        let [x, ..] = sum.translation_m(0.004);
        x - velocity.x.get() * 3600.0
    }

    #[test]
    fn a_sum_of_an_hour_is_exact_to_a_nanometre() {
        let errors = [an_hour::<f64>(), an_hour::<f32>(), an_hour::<Fixed>()];
        assert!(errors.iter().all(|e| e.abs() < 1e-9), "{errors:?}");
    }
}
