//! Gain of the sensor's axes.

use super::WITH_ZERO;
use crate::effects::{Effect, Group, Law, Naming, Parameter};
use softdock_control::frames::Wrench;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "ft_scale",
    title: "Gain of the sensor",
    summary: "each axis of the wrench reads too much or too little by a factor",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "W_i = (1 + i) W_nominal,i for i = fx fy fz tx ty tz",
    source: "strain-gauge data sheets (error of full scale)",
    signature: "the error of an axis is proportional to what it reads, in contact as in tilting",
    typical: "0.5 to 2 %; a wrong calibration file is off by 10 % and more",
    parameters: &[
        Parameter::new("fx", "-", -0.3, 0.3)
            .hidden(0.05, 0.12)
            .either_sign()
            .pictured(0.1),
        Parameter::new("fy", "-", -0.3, 0.3),
        Parameter::new("fz", "-", -0.3, 0.3),
        Parameter::new("tx", "-", -0.3, 0.3),
        Parameter::new("ty", "-", -0.3, 0.3),
        Parameter::new("tz", "-", -0.3, 0.3),
        // One gain for all axes, as by a wrong calibration of the supply.
        Parameter::new("all_axes", "-", -0.3, 0.3).common(),
        WITH_ZERO,
    ],
    confused_with: &[
        "contact_stiffness",
        "tool_mass_error",
        "ft_crosstalk",
        "ft_saturation",
    ],
    tell_apart: "hang known weights on the sensor: a gain shows there too, a wrong stiffness only in contact; with \
                 the gain of one axis wrong the weight of the tool seems to depend on the orientation",
    law: Law::SensorGain(read),
    separable: true,
    ..Effect::PLAIN
};

/// Each axis with its own gain error plus the common one.
fn read(p: &[f64], load: &Wrench<f64>) -> Wrench<f64> {
    let mut axes = load.get();
    for (value, own) in axes.iter_mut().zip(p) {
        *value *= 1.0 + own + p[6];
    }
    Wrench::of(&axes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_axis_has_its_gain() {
        let gains = [0.5, 0.0, -0.25, 0.0, 0.0, 1.0, 0.0, 0.0];
        assert_eq!(
            read(&gains, &Wrench::of(&[2.0; 6])).get(),
            [3.0, 2.0, 1.5, 2.0, 2.0, 4.0]
        );
        let all = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0];
        assert_eq!(read(&all, &Wrench::of(&[2.0; 6])).get(), [3.0; 6]);
    }
}
