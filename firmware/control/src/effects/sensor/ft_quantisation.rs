//! Resolution of the sensor.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::frames::Wrench;
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

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
        Parameter::new("lsb_force_n", "N", 0.0, 20.0),
        Parameter::new("lsb_torque_n_m", "N m", 0.0, 2.0),
    ],
    confused_with: &["ft_dropout", "ft_low_pass"],
    tell_apart: "sort the values of a slow ramp: a lattice has gaps of one size, held samples repeat in time but \
                 take any value",
};

/// Lattices of force and torque.
#[derive(Clone, Copy, Debug)]
pub struct WrenchQuantisation<S: Scalar> {
    force: S,
    torque: S,
}

impl<S: Scalar> WrenchQuantisation<S> {
    /// `lsb_force_n` 0 (not rounded) to 1e5 N, `lsb_torque_n_m` 0 to 1e5 N·m.
    pub fn new(lsb_force_n: f64, lsb_torque_n_m: f64) -> Result<Self, SettingsError> {
        in_range("lsb_force_n", lsb_force_n, 0.0, 1e5)?;
        in_range("lsb_torque_n_m", lsb_torque_n_m, 0.0, 1e5)?;
        Ok(Self {
            force: S::of(lsb_force_n),
            torque: S::of(lsb_torque_n_m),
        })
    }

    /// What the sensor reads of a wrench, halves away from zero.
    pub fn apply(&self, wrench: &Wrench<S>) -> Wrench<S> {
        Wrench {
            force: wrench.force.map(|value| on_lattice(value, self.force)),
            torque: wrench.torque.map(|value| on_lattice(value, self.torque)),
        }
    }
}

/// `value` on a lattice, unless its pitch is finer than the scalars' resolution.
fn on_lattice<S: Scalar>(value: S, pitch: S) -> S {
    if pitch <= S::of(1e-6) {
        value
    } else {
        (value / pitch).round() * pitch
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Fixed;

    fn lattice<S: Scalar>() {
        let sensor = WrenchQuantisation::<S>::new(0.5, 0.0).unwrap();
        let got = sensor.apply(&Wrench::of(&[1.2, -1.3, 0.1, 0.125, 0.25, 0.0]));
        assert_eq!(got.get(), [1.0, -1.5, 0.0, 0.125, 0.25, 0.0]);
    }

    #[test]
    fn forces_stand_on_a_lattice_and_torques_pass() {
        lattice::<f64>();
        lattice::<Fixed>();
    }
}
