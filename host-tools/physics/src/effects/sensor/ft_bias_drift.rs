//! Drift of the sensor's zero.

use super::six;
use crate::effects::{Effect, Group, Law, Naming, Parameter};
use softdock_control::frames::Wrench;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "ft_bias_drift",
    title: "Drift of the sensor's zero",
    summary: "the zero of the wrench creeps to a new value",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "W(t) = W_nominal + (fx_n, .., tz_n_m) (1 - exp(-t/time_constant_s)), t from the beginning of the log",
    source: "strain-gauge data sheets (drift of the zero with temperature); first-order warming",
    signature: "a slow bend of the wrench that depends on neither pose nor motion; over a short log it is a ramp, of which only the rate, value over time constant, is known",
    typical: "0.5 to 3 N over some seconds to minutes after the load or the temperature has changed",
    // Over a short log only the rate (final value over time constant) is determined. The final values may therefore be as large
    // as a plausible rate, 1 N/s, times the longest time constant.
    parameters: &[
        Parameter::new("fx_n", "N", -1e4, 1e4)
            .hidden(1.0, 2.0)
            .either_sign()
            .pictured(2.0),
        Parameter::new("fy_n", "N", -1e4, 1e4),
        Parameter::new("fz_n", "N", -1e4, 1e4),
        Parameter::new("tx_n_m", "N·m", -1e4, 1e4),
        Parameter::new("ty_n_m", "N·m", -1e4, 1e4),
        Parameter::new("tz_n_m", "N·m", -1e4, 1e4),
        // A transient that ends within a second is no drift: apart from the first rows it is a constant, like an offset of the
        // guide.
        Parameter::new("time_constant_s", "s", 1.0, 1e4)
            .shape(&[1.2, 2.0, 3.0, 4.0, 5.5, 8.0, 12.0, 25.0, 1e3], 1e3)
            .hidden(3.0, 8.0)
            .pictured(15.0),
    ],
    confused_with: &["ft_bias", "cable_stiffness", "tool_mass_error"],
    tell_apart: "a long log at standstill: only drift changes there; a cable needs motion",
    law: Law::SensorZero(zero),
    separable: true,
    ..Effect::PLAIN
};

/// The offset at a time after the log began; it approaches its final value exponentially.
fn zero(p: &[f64], time_s: f64) -> Wrench<f64> {
    six(p) * -(-time_s.max(0.0) / p[6]).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_creeps_to_its_last_value() {
        let at = |t| zero(&[1.0, 0.0, 0.0, 0.0, 0.0, -2.0, 4.0], t);
        assert_eq!(at(0.0).get(), [0.0; 6]);
        assert!((at(4.0).force.x - (1.0 - (-1.0_f64).exp())).abs() < 1e-12);
        assert!((at(400.0).torque.z + 2.0).abs() < 1e-12);
    }
}
