//! A critically damped low-pass of second order that gives its output's two derivatives.

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

/// The low-pass, integrated implicitly (backward Euler), so that it is stable at any corner.
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
}
