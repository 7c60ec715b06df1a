//! Steps of the position at reversals, whose instants no simulation knows exactly.
//!
//! A pause begins and ends at instants of the robot's own clock, and with a velocity that only just reaches zero the axis may
//! pause or not. After each reversal the position may therefore be off by a little, permanently. Without an allowance for such
//! steps, a structure with one more parameter explains them by it, and a step that lasts to the end of the recording outweighs
//! everything else.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Standard deviation of the instant of a reversal, s. Interpolators and drives have cycles of about a millisecond. The value is
/// not critical: from 0.1 ms to 1 ms, delay and pause of the simulated robots are found equally well.
const INSTANT_S: f64 = 2.5e-4;

/// Steps of the position at reversals, with Gaussian priors, and the origin, which is free.
#[derive(Clone, Debug)]
pub(super) struct Steps {
    /// First judged position behind each step; 0 for the origin.
    at: Vec<usize>,
    /// Standard deviation of a position divided by that of the step; 0 for the origin.
    ratio: Vec<f64>,
    /// Cholesky factor of the normal equations; None without a position.
    normal: Option<Cholesky<f64, Dyn>>,
}

impl Steps {
    /// The origin alone, for so many judged positions.
    pub(super) fn origin(count: usize) -> Self {
        Self::new(count, vec![0], vec![0.0])
    }

    /// One step more for each reversal of `sent`, the velocities of the judged positions (m/s or
    /// rad/s), `late` cycles behind it. Slower than `rest` is no motion; `noise` is that of a position,
    /// m or rad.
    pub(super) fn at_reversals(sent: &[f64], late: usize, rest: f64, noise: f64) -> Self {
        let (mut at, mut ratio) = (vec![0], vec![0.0]);
        let mut last = 0.0_f64;
        for (n, velocity) in sent.iter().enumerate().filter(|(_, v)| v.abs() > rest) {
            if last * velocity < 0.0 && n + late < sent.len() {
                let speed = 0.5 * (velocity - last).abs();
                at.push(n + late);
                ratio.push(noise / (speed * INSTANT_S));
            }
            last = *velocity;
        }
        Self::new(sent.len(), at, ratio)
    }

    fn new(count: usize, at: Vec<usize>, ratio: Vec<f64>) -> Self {
        let normal = DMatrix::from_fn(at.len(), at.len(), |i, k| {
            let behind_both = count.saturating_sub(at[i].max(at[k])) as f64;
            behind_both + if i == k { ratio[i] * ratio[i] } else { 0.0 }
        });
        Self {
            at,
            ratio,
            normal: Cholesky::new(normal),
        }
    }

    /// Removes the best-fitting steps from the residuals `left` of the judged positions, and appends each step as a residual of
    /// its own, in units of a position.
    pub(super) fn removed(&self, mut left: Vec<f64>) -> Vec<f64> {
        let Some(normal) = &self.normal else {
            return left;
        };
        let sums = self.at.iter().map(|from| left[*from..].iter().sum());
        let steps = normal.solve(&DVector::from_iterator(self.at.len(), sums));
        for (from, step) in self.at.iter().zip(steps.iter()) {
            left[*from..].iter_mut().for_each(|place| *place -= step);
        }
        left.extend(steps.iter().zip(&self.ratio).map(|(s, ratio)| s * ratio));
        left
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOISE: f64 = 5e-6;

    fn to_and_fro() -> Vec<f64> {
        let sign = |n: usize| if n % 40 < 20 { 0.02 } else { -0.02 };
        (0..200).map(sign).collect()
    }

    /// Sum of squares that is left of a jump of the position, in units of the noise.
    fn left_of_jump(steps: &Steps, from: usize, jump: f64) -> f64 {
        let place = (0..200).map(|n| if n < from { 0.1 } else { 0.1 + jump });
        let left = steps.removed(place.collect());
        left.iter().map(|l| l * l).sum::<f64>() / (NOISE * NOISE)
    }

    #[test]
    fn the_origin_is_free() {
        assert!(left_of_jump(&Steps::origin(200), 0, 0.0) < 1e-12);
        let mean = left_of_jump(&Steps::origin(200), 100, 2.0 * NOISE);
        assert!((mean - 200.0).abs() < 1e-6, "{mean}");
    }

    /// A step of one standard deviation of the instant costs 1 at a reversal, and much elsewhere.
    #[test]
    fn a_step_at_a_reversal_costs_little() {
        let steps = Steps::at_reversals(&to_and_fro(), 3, 1e-4, NOISE);
        assert_eq!(steps.at, [0, 23, 43, 63, 83, 103, 123, 143, 163, 183]);
        let jump = 0.02 * INSTANT_S;
        let cost = left_of_jump(&steps, 103, jump);
        assert!(cost < 1.0 && cost > 0.8, "{cost}");
        let elsewhere = left_of_jump(&steps, 113, 10.0 * jump);
        assert!(elsewhere > 100.0, "{elsewhere}");
    }
}
