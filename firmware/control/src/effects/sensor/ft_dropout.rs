//! Samples of the sensor that are lost; the last one is held.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::frames::Wrench;
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "ft_dropout",
    title: "Lost samples of the sensor",
    summary: "samples of the sensor are lost now and then, and the last one is repeated",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "W(n) = W(n-1) with probability held_share, else W_nominal(n)",
    source: "bus and driver behaviour (hold last value)",
    signature: "all six values repeat exactly, at random times; the error is largest where the wrench is steep",
    typical: "0.1 to 5 % of the samples on a busy bus; 50 % where the sensor is half as fast as the cycle",
    parameters: &[Parameter::new("held_share", "-", 0.0, 0.95)],
    confused_with: &["ft_latency", "ft_quantisation", "ft_low_pass"],
    tell_apart: "look for samples that equal the one before in all six values: noise makes that impossible \
                 otherwise; a latency shifts every sample",
};

/// A sensor that sometimes repeats itself.
#[derive(Clone, Copy, Debug)]
pub struct Dropout<S: Scalar> {
    held_share: f64,
    last: Wrench<S>,
}

impl<S: Scalar> Dropout<S> {
    /// Begins with the wrench 0. `held_share` 0 to 1.
    pub fn new(held_share: f64) -> Result<Self, SettingsError> {
        in_range("held_share", held_share, 0.0, 1.0)?;
        Ok(Self {
            held_share,
            last: Wrench::zero(),
        })
    }

    /// One sample; `draw` is a random number of the caller, uniform in 0..1.
    pub fn advance(&mut self, wrench: &Wrench<S>, draw: f64) -> Wrench<S> {
        if draw >= self.held_share {
            self.last = *wrench;
        }
        self.last
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lost_sample_repeats_the_last_one() {
        let mut sensor = Dropout::<f64>::new(0.25).unwrap();
        let read = [(1.0, 0.9), (2.0, 0.1), (3.0, 0.25)]
            .map(|(value, draw)| sensor.advance(&Wrench::of(&[value; 6]), draw).force.x);
        assert_eq!(read, [1.0, 1.0, 3.0]);
    }
}
