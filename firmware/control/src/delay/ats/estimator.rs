//! Parts of the identification of the robot: a low-pass that also gives derivatives, and least squares of three coefficients with
//! forgetting.

use crate::scalar::Scalar;

/// Gains of the low-pass.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gains<S> {
    /// ω² / (1 + 2 ω Ts + ω² Ts²), 1/s².
    stiffness: S,
    /// 2 ω / (the same), 1/s.
    damping: S,
}

impl<S: Scalar> Gains<S> {
    /// `corner_hz` in Hz, `cycle_s` in s.
    pub(super) fn new(corner_hz: f64, cycle_s: f64) -> Self {
        let omega = core::f64::consts::TAU * corner_hz;
        let implicit = 1.0 + 2.0 * omega * cycle_s + omega * omega * cycle_s * cycle_s;
        Self {
            stiffness: S::of(omega * omega / implicit),
            damping: S::of(2.0 * omega / implicit),
        }
    }
}

/// A critically damped low-pass of second order, integrated implicitly (backward Euler), so that it is stable
/// at any corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct LowPass<S> {
    value: S,
    rate: S,
    acceleration: S,
}

impl<S: Scalar> LowPass<S> {
    /// At rest at zero.
    pub(super) fn new() -> Self {
        Self {
            value: S::zero(),
            rate: S::zero(),
            acceleration: S::zero(),
        }
    }

    /// One cycle.
    pub(super) fn step(&mut self, input: S, gains: &Gains<S>, ts: S) {
        let ahead = self.value + self.rate * ts;
        self.acceleration = (input - ahead) * gains.stiffness - self.rate * gains.damping;
        self.rate += self.acceleration * ts;
        self.value += self.rate * ts;
    }

    /// The output, its rate (per s) and its acceleration (per s²): backward differences.
    pub(super) fn derivatives(&self) -> [S; 3] {
        [self.value, self.rate, self.acceleration]
    }
}

/// Least squares of three coefficients with forgetting and a ridge: sums of the normal equations, upper
/// triangle row by row, and the right side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Regression<S> {
    matrix: [[S; 3]; 3],
    right: [S; 3],
}

impl<S: Scalar> Regression<S> {
    /// Nothing seen.
    pub(super) fn new() -> Self {
        Self {
            matrix: [[S::zero(); 3]; 3],
            right: [S::zero(); 3],
        }
    }

    /// Multiplies all sums by `kept` (forgetting), then adds the equation `row · a = value`.
    pub(super) fn push(&mut self, row: &[S; 3], value: S, kept: S) {
        for i in 0..3 {
            for j in i..3 {
                self.matrix[i][j] = self.matrix[i][j] * kept + row[i] * row[j];
            }
            self.right[i] = self.right[i] * kept + row[i] * value;
        }
    }

    /// The coefficients, with `ridge` drawing each to zero.
    ///
    /// The equations are scaled to a unit diagonal first, which keeps the digits of fixed point; the
    /// elimination needs no pivoting because the matrix is positive definite.
    pub(super) fn solve(&self, ridge: S) -> [S; 3] {
        // At least a number that fixed point can divide by.
        let least = S::of(1e-6);
        let size: [S; 3] = core::array::from_fn(|i| (self.matrix[i][i] + ridge).max(least).sqrt());
        let mut m = [[S::zero(); 3]; 3];
        let mut right = [S::zero(); 3];
        for i in 0..3 {
            for j in i..3 {
                m[i][j] = self.matrix[i][j] / size[i] / size[j];
            }
            m[i][i] = S::one();
            right[i] = self.right[i] / size[i];
        }
        let pivot_least = S::of(1e-5);
        for i in 0..2 {
            let row = m[i];
            for k in i + 1..3 {
                let factor = row[k] / row[i].max(pivot_least);
                m[k] = core::array::from_fn(|j| m[k][j] - factor * row[j]);
                right[k] -= factor * right[i];
            }
        }
        let mut found = [S::zero(); 3];
        for i in (0..3).rev() {
            let known = (i + 1..3).fold(S::zero(), |sum, j| sum + m[i][j] * found[j]);
            found[i] = (right[i] - known) / m[i][i].max(pivot_least);
        }
        core::array::from_fn(|i| found[i] / size[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Fixed;

    fn follows<S: Scalar>(tolerance: f64) {
        let ts = 0.004;
        let gains = Gains::<S>::new(10.0, ts);
        let mut filter = LowPass::<S>::new();
        for n in 0..500 {
            let t = f64::from(n) * ts;
            filter.step(S::of(3.0 * t + 5.0 * t * t), &gains, S::of(ts));
        }
        let t = 499.0 * ts;
        let [x, dx, ddx] = filter.derivatives().map(S::get);
        // Late by 2/ω, and by what backward differences add.
        let late = 2.0 / (core::f64::consts::TAU * 10.0);
        assert!((ddx - 10.0).abs() < 1e3 * tolerance, "{ddx}");
        assert!((dx - (3.0 + 10.0 * (t - late))).abs() < 0.05, "{dx}");
        let shifted = t - late;
        assert!(
            (x - (3.0 * shifted + 5.0 * shifted * shifted)).abs() < 0.02,
            "{x}"
        );
    }

    #[test]
    fn a_parabola_is_followed_late() {
        follows::<f64>(1e-9);
        follows::<Fixed>(1e-5);
    }

    fn finds<S: Scalar>(tolerance: f64) {
        let mut regression = Regression::<S>::new();
        let wanted = [0.01, -0.2, 0.5];
        for n in 0..400 {
            let t = f64::from(n) * 0.02;
            let row = [20.0 * t.sin(), 0.5 * t.cos(), 0.02 * (2.3 * t).sin()];
            let value: f64 = row.iter().zip(wanted).map(|(z, a)| z * a).sum();
            regression.push(&row.map(S::of), S::of(value), S::of(0.996));
        }
        let found = regression.solve(S::of(1e-6)).map(S::get);
        for (found, wanted) in found.into_iter().zip(wanted) {
            assert!((found - wanted).abs() < tolerance, "{found} {wanted}");
        }
    }

    #[test]
    fn coefficients_of_very_different_rows_are_found() {
        finds::<f64>(1e-4);
        finds::<f32>(2e-2);
        finds::<Fixed>(1e-3);
    }

    #[test]
    fn what_the_data_do_not_tell_stays_at_the_belief() {
        let mut regression = Regression::<f64>::new();
        for _ in 0..400 {
            regression.push(&[5.0, 0.0, 0.0], 1.0, 0.996);
        }
        let [a, b, c] = regression.solve(1e-3);
        assert!((a - 0.2).abs() < 1e-4);
        assert_eq!([b, c], [0.0, 0.0]);
        assert_eq!(Regression::<f64>::new().solve(1e-3), [0.0; 3]);
    }

    /// Two equal poles at 1/(1 + ω Ts).
    #[test]
    fn the_low_pass_answers_a_step_as_two_poles_do() {
        for (corner_hz, ts) in [(10.0, 0.004), (3.0, 0.012)] {
            let gains = Gains::<f64>::new(corner_hz, ts);
            let mut filter = LowPass::<f64>::new();
            let pole = 1.0 / (1.0 + core::f64::consts::TAU * corner_hz * ts);
            for n in 1..40 {
                filter.step(1.0, &gains, ts);
                let expected = 1.0 - pole.powi(n) * (1.0 + f64::from(n) * (1.0 - pole));
                let [found, ..] = filter.derivatives();
                assert!((found - expected).abs() < 1e-12, "{n}: {found} {expected}");
            }
        }
    }
}
