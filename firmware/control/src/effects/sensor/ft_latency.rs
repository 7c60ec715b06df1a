//! Age of the sensor's samples.

use crate::effects::{Effect, Group, Naming, Parameter, check_step};
use crate::frames::Wrench;
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;
use nalgebra::ComplexField;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "ft_latency",
    title: "Latency of the sensor",
    summary: "the wrench is older than its time stamp says",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "W(t) = W_nominal(t - latency_s)",
    source: "sensor manuals (internal filters and bus transfer)",
    signature: "the wrench is a shifted copy of what the penetration predicts: force against penetration opens to a \
                loop that feeds energy in",
    typical: "1 to 10 ms: one to some cycles of the sensor's own sampling and the bus",
    parameters: &[Parameter::new("latency_s", "s", 0.0, 0.1)],
    confused_with: &[
        "ft_low_pass",
        "clock_offset",
        "actuation_delay",
        "contact_damping",
    ],
    tell_apart: "tap the sensor while the robot stands: a latency shifts the tap, a filter smears it; a negative \
                 damping of the contact is a latency",
};

/// Delay line for `N` samples; the longest latency is `N − 1` steps.
#[derive(Clone, Copy, Debug)]
pub struct Latency<S: Scalar, const N: usize> {
    samples: [Wrench<S>; N],
    newest: usize,
    /// Whole steps, and the rest as a share of a step.
    whole: usize,
    rest: S,
}

impl<S: Scalar, const N: usize> Latency<S, N> {
    /// A line full of zero. `latency_s` 0 to (N − 1) `step_s`, `step_s` in s.
    pub fn new(latency_s: f64, step_s: f64) -> Result<Self, SettingsError> {
        check_step(step_s)?;
        let longest_s = step_s * N.saturating_sub(1) as f64;
        in_range("latency_s", latency_s, 0.0, longest_s)?;
        let steps = latency_s / step_s;
        let whole = ComplexField::floor(steps);
        Ok(Self {
            samples: [Wrench::zero(); N],
            newest: 0,
            whole: whole as usize,
            rest: S::of(steps - whole),
        })
    }

    /// One sample; returns the delayed one, interpolated between two samples.
    pub fn advance(&mut self, wrench: &Wrench<S>) -> Wrench<S> {
        self.newest = (self.newest + 1) % N.max(1);
        if let Some(slot) = self.samples.get_mut(self.newest) {
            *slot = *wrench;
        }
        let (near, far) = (self.sample(self.whole), self.sample(self.whole + 1));
        near + (far - near) * self.rest
    }

    /// The sample so many steps ago.
    fn sample(&self, steps_ago: usize) -> Wrench<S> {
        let back = steps_ago.min(N.saturating_sub(1));
        let slot = (self.newest + N - back) % N.max(1);
        self.samples.get(slot).copied().unwrap_or(Wrench::zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Fixed;

    /// A ramp that is 2.5 steps late.
    fn late_ramp<S: Scalar>() {
        let mut sensor = Latency::<S, 4>::new(0.010, 0.004).unwrap();
        for k in 1..=20 {
            let read = sensor
                .advance(&Wrench::of(&[f64::from(k); 6]))
                .torque
                .z
                .get();
            let expected = (f64::from(k) - 2.5).max(0.0);
            assert!((read - expected).abs() < 1e-6, "{k}: {read}");
        }
    }

    #[test]
    fn a_ramp_is_late_by_the_latency() {
        late_ramp::<f64>();
        late_ramp::<Fixed>();
        assert!(Latency::<f64, 4>::new(0.0121, 0.004).is_err());
    }
}
