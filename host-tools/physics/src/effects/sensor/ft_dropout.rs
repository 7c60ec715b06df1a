//! Samples of the sensor that are lost; the last one is held.

use crate::effects::law::Six;
use crate::effects::{Effect, Group, Law, Naming, Parameter, Sampling, Values};
use softdock_control::frames::Wrench;

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
    parameters: &[Parameter::new("held_share", "-", 0.0, 0.95)
        .hidden(0.15, 0.3)
        .pictured(0.6)],
    confused_with: &["ft_latency", "ft_quantisation", "ft_low_pass"],
    tell_apart: "look for samples that equal the one before in all six values: noise makes that impossible \
                 otherwise; a latency shifts every sample",
    law: Law::Sample(Sampling { sent, read }),
    ..Effect::PLAIN
};

/// A lost sample repeats the last one; `draw` is uniform in (0, 1].
fn sent(p: Values<'_>, wrench: &Wrench<f64>, last: &Wrench<f64>, draw: f64) -> Wrench<f64> {
    if draw > p[0] { *wrench } else { *last }
}

/// A repeated reading carries no information.
fn read(_: Values<'_>, predicted: Six, measured: &Six, before: Option<&Six>) -> Option<Six> {
    (before != Some(measured)).then_some(predicted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lost_sample_repeats_the_last_one() {
        let sent = |draw| {
            super::sent(
                &[0.25],
                &Wrench::of(&[2.0; 6]),
                &Wrench::of(&[1.0; 6]),
                draw,
            )
        };
        assert_eq!([0.9, 0.1].map(|draw| sent(draw).force.x), [2.0, 1.0]);
    }
}
