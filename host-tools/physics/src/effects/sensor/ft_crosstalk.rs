//! Cross-talk between the axes of the sensor.

use super::WITH_ZERO;
use crate::effects::{Effect, Group, Law, Naming, Parameter};
use softdock_control::frames::Wrench;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "ft_crosstalk",
    title: "Cross-talk of the sensor",
    summary: "a share of one axis of the wrench appears on another",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "W_to = W_nominal,to + sum over from of to_from_from W_nominal,from",
    source: "calibration certificates of strain-gauge sensors (coupling matrix)",
    signature: "one axis carries a copy of another, in contact as in tilting, without delay and at every size",
    typical: "1 to 3 % of the range of the other axis",
    parameters: &[
        Parameter::new("fx_from_fy", "-", -0.2, 0.2),
        Parameter::new("fx_from_fz", "-", -0.2, 0.2),
        Parameter::new("fx_from_tx", "1/m", -2.0, 2.0),
        Parameter::new("fx_from_ty", "1/m", -2.0, 2.0),
        Parameter::new("fx_from_tz", "1/m", -2.0, 2.0),
        Parameter::new("fy_from_fx", "-", -0.2, 0.2)
            .hidden(0.03, 0.06)
            .either_sign()
            .pictured(0.03),
        Parameter::new("fy_from_fz", "-", -0.2, 0.2),
        Parameter::new("fy_from_tx", "1/m", -2.0, 2.0),
        Parameter::new("fy_from_ty", "1/m", -2.0, 2.0),
        Parameter::new("fy_from_tz", "1/m", -2.0, 2.0),
        Parameter::new("fz_from_fx", "-", -0.2, 0.2),
        Parameter::new("fz_from_fy", "-", -0.2, 0.2),
        Parameter::new("fz_from_tx", "1/m", -2.0, 2.0),
        Parameter::new("fz_from_ty", "1/m", -2.0, 2.0),
        Parameter::new("fz_from_tz", "1/m", -2.0, 2.0),
        Parameter::new("tx_from_fx", "m", -0.05, 0.05),
        Parameter::new("tx_from_fy", "m", -0.05, 0.05),
        Parameter::new("tx_from_fz", "m", -0.05, 0.05),
        Parameter::new("tx_from_ty", "-", -0.2, 0.2),
        Parameter::new("tx_from_tz", "-", -0.2, 0.2),
        Parameter::new("ty_from_fx", "m", -0.05, 0.05)
            .hidden(0.005, 0.01)
            .either_sign(),
        Parameter::new("ty_from_fy", "m", -0.05, 0.05),
        Parameter::new("ty_from_fz", "m", -0.05, 0.05),
        Parameter::new("ty_from_tx", "-", -0.2, 0.2),
        Parameter::new("ty_from_tz", "-", -0.2, 0.2),
        Parameter::new("tz_from_fx", "m", -0.05, 0.05),
        Parameter::new("tz_from_fy", "m", -0.05, 0.05),
        Parameter::new("tz_from_fz", "m", -0.05, 0.05),
        Parameter::new("tz_from_tx", "-", -0.2, 0.2),
        Parameter::new("tz_from_ty", "-", -0.2, 0.2),
        WITH_ZERO,
    ],
    confused_with: &[
        "ft_mounting",
        "tool_com_error",
        "contact_coulomb",
        "ft_scale",
    ],
    tell_apart: "load the axes one after the other, with known weights in six orientations: cross-talk copies \
                 single axes, a turned sensor exchanges them in antisymmetric pairs",
    law: Law::SensorGain(read),
    separable: true,
    ..Effect::PLAIN
};

/// The reading, with the coupling of each axis to each other one.
fn read(p: &[f64], load: &Wrench<f64>) -> Wrench<f64> {
    let (felt, mut axes) = (load.get(), load.get());
    let couplings = p.chunks_exact(5).zip(axes.iter_mut()).enumerate();
    for (to, (row, value)) in couplings {
        let others = (0..6).filter(|from| *from != to);
        *value += row
            .iter()
            .zip(others)
            .map(|(c, from)| c * felt[from])
            .sum::<f64>();
    }
    Wrench::of(&axes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_force_leaks_into_a_torque() {
        let place = EFFECT.place("ty_from_fx").unwrap();
        let mut couplings = [0.0; 31];
        couplings[place] = 0.5;
        let got = read(&couplings, &Wrench::of(&[10.0, 0.0, 0.0, 0.0, 1.0, 0.0])).get();
        assert_eq!(got, [10.0, 0.0, 0.0, 0.0, 6.0, 0.0]);
    }
}
