//! Resolution of the sensor.

use crate::effects::law::Six;
use crate::effects::{Effect, Group, Law, Naming, Parameter, Sampling, Values};
use softdock_control::frames::Wrench;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "ft_quantisation",
    title: "Resolution of the sensor",
    summary: "the wrench is rounded to the sensor's resolution",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "F_i = lsb_force_n round(F_nominal,i / lsb_force_n), T_i likewise with lsb_torque_n_m",
    source: "textbook (uniform quantiser); sensor manuals (counts per unit)",
    signature: "values of the wrench stand on a lattice, with nothing between; the error is a sawtooth of the value",
    typical: "1/1000 to 1/16000 of the range",
    parameters: &[
        Parameter::new("lsb_force_n", "N", 0.0, 20.0)
            .hidden(0.5, 1.5)
            .in_steps(0.05)
            .pictured(2.0),
        Parameter::new("lsb_torque_n_m", "N·m", 0.0, 2.0)
            .hidden(0.04, 0.08)
            .in_steps(0.005),
        Parameter::choice("rounds_down", &["rounds to the nearest", "rounds down"]),
    ],
    confused_with: &["ft_dropout", "ft_low_pass"],
    tell_apart: "sort the values of a slow ramp: a lattice has gaps of one size, held samples repeat in time but \
                 take any value",
    law: Law::Sample(Sampling { sent, read }),
    ..Effect::PLAIN
};

/// Forces and torques rounded to multiples of their steps, halves away from zero, or rounded down.
fn sent(p: Values<'_>, wrench: &Wrench<f64>, _: &Wrench<f64>, _: f64) -> Wrench<f64> {
    let on_lattice = |value: f64, pitch: f64| match pitch > 0.0 {
        true if p[2] > 0.5 => (value / pitch).floor() * pitch,
        true => (value / pitch).round() * pitch,
        false => value,
    };
    Wrench {
        force: wrench.force.map(|value| on_lattice(value, p[0])),
        torque: wrench.torque.map(|value| on_lattice(value, p[1])),
    }
}

/// A rounded reading stands for an interval; only the distance of the prediction to that interval is an error.
fn read(p: Values<'_>, predicted: Six, measured: &Six, _: Option<&Six>) -> Option<Six> {
    let near = |axis: usize| {
        let (half, measured) = (0.5 * p[axis / 3], measured[axis]);
        let middle = if p[2] > 0.5 {
            measured + half
        } else {
            measured
        };
        let nearest = predicted[axis].clamp(middle - half, middle + half);
        measured + (predicted[axis] - nearest)
    };
    Some(std::array::from_fn(near))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_stand_on_a_lattice_and_torques_pass() {
        let sent = |down| {
            let wrench = Wrench::of(&[1.4, -1.3, 0.1, 0.125, 0.25, 0.0]);
            super::sent(&[0.5, 0.0, down], &wrench, &Wrench::zero(), 0.0).get()
        };
        assert_eq!(sent(0.0), [1.5, -1.5, 0.0, 0.125, 0.25, 0.0]);
        assert_eq!(sent(1.0), [1.0, -1.5, 0.0, 0.125, 0.25, 0.0]);
    }

    /// 1.0 was sent for all values from 0.75 to 1.25, or from 1.0 to 1.5 with rounding down.
    #[test]
    fn within_a_step_nothing_is_missing() {
        let error = |down: f64, predicted: f64| {
            let read = read(&[0.5, 0.0, down], [predicted; 6], &[1.0; 6], None);
            read.unwrap()[0] - 1.0
        };
        assert_eq!([0.8, 1.2, 1.5].map(|f| error(0.0, f)), [0.0, 0.0, 0.25]);
        assert_eq!([1.4, 0.75].map(|f| error(1.0, f)), [0.0, -0.25]);
    }
}
