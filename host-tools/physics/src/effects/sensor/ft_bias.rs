//! Zero offset of the sensor.

use super::six;
use crate::effects::{Effect, Group, Law, Naming, Parameter};
use softdock_control::frames::Wrench;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "ft_bias",
    title: "Zero offset of the sensor",
    summary: "the wrench has a constant offset in the sensor's axes",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "W = W_nominal + (fx_n, fy_n, fz_n, tx_n_m, ty_n_m, tz_n_m)",
    source: "strain-gauge data sheets (zero balance)",
    signature: "a constant error of the wrench from the first sample to the last, whatever pose and motion",
    typical: "0.1 to 5 N and 0.01 to 0.5 N m after a warm-up without zeroing",
    parameters: &[
        Parameter::new("fx_n", "N", -1e4, 1e4)
            .hidden(0.6, 1.2)
            .either_sign()
            .pictured(1.5),
        Parameter::new("fy_n", "N", -1e4, 1e4)
            .hidden(0.6, 1.2)
            .either_sign(),
        Parameter::new("fz_n", "N", -1e4, 1e4),
        Parameter::new("tx_n_m", "N·m", -1e4, 1e4),
        Parameter::new("ty_n_m", "N·m", -1e4, 1e4),
        Parameter::new("tz_n_m", "N·m", -1e4, 1e4),
    ],
    confused_with: &[
        "ft_bias_drift",
        "tool_mass_error",
        "base_tilt",
        "guide_offset",
    ],
    tell_apart: "hold the sensor in two opposite orientations without contact: the bias is the mean of the two \
                 readings, the weight half of their difference",
    law: Law::SensorZero(zero),
    separable: true,
    ..Effect::PLAIN
};

/// The same at all times.
fn zero(p: &[f64], _: f64) -> Wrench<f64> {
    six(p)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_stays() {
        let offset = [1.0, 0.0, 0.0, 0.0, 0.0, -2.0];
        assert_eq!([0.0, 100.0].map(|t| zero(&offset, t).get()), [offset; 2]);
    }
}
