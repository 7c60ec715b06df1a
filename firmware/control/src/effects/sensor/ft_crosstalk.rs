//! Cross-talk between the axes of the sensor.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::frames::Wrench;
use crate::range::{SettingsError, all_within};
use crate::scalar::Scalar;
use nalgebra::{Matrix6, Vector6};

/// Catalogue entry. The parameters stand row by row: all that leaks into fx first.
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
        Parameter::new("fy_from_fx", "-", -0.2, 0.2),
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
        Parameter::new("ty_from_fx", "m", -0.05, 0.05),
        Parameter::new("ty_from_fy", "m", -0.05, 0.05),
        Parameter::new("ty_from_fz", "m", -0.05, 0.05),
        Parameter::new("ty_from_tx", "-", -0.2, 0.2),
        Parameter::new("ty_from_tz", "-", -0.2, 0.2),
        Parameter::new("tz_from_fx", "m", -0.05, 0.05),
        Parameter::new("tz_from_fy", "m", -0.05, 0.05),
        Parameter::new("tz_from_fz", "m", -0.05, 0.05),
        Parameter::new("tz_from_tx", "-", -0.2, 0.2),
        Parameter::new("tz_from_ty", "-", -0.2, 0.2),
    ],
    confused_with: &[
        "ft_mounting",
        "tool_com_error",
        "contact_coulomb",
        "ft_scale",
    ],
    tell_apart: "load the axes one after the other, with known weights in six orientations: cross-talk copies \
                 single axes, a turned sensor exchanges them in antisymmetric pairs",
};

/// Couplings between the axes fx fy fz tx ty tz.
#[derive(Clone, Copy, Debug)]
pub struct Crosstalk<S: Scalar> {
    coupling: Matrix6<S>,
}

impl<S: Scalar> Crosstalk<S> {
    /// `coupling`: what appears on the row's axis per unit of the column's axis, each within
    /// ±100; the diagonal is the gain error of the axis itself, 0 for cross-talk alone.
    pub fn new(coupling: &[[f64; 6]; 6]) -> Result<Self, SettingsError> {
        all_within("to_from_from", coupling.as_flattened(), 100.0)?;
        let matrix = Matrix6::from_row_iterator(coupling.iter().flatten().copied());
        Ok(Self {
            coupling: matrix.map(S::of),
        })
    }

    /// What the sensor reads of a wrench.
    pub fn apply(&self, wrench: &Wrench<S>) -> Wrench<S> {
        let (f, t) = (&wrench.force, &wrench.torque);
        let leaked = self.coupling * Vector6::new(f.x, f.y, f.z, t.x, t.y, t.z);
        let [a, b, c, d, e, g] = <[S; 6]>::from(leaked);
        Wrench {
            force: wrench.force + nalgebra::Vector3::new(a, b, c),
            torque: wrench.torque + nalgebra::Vector3::new(d, e, g),
        }
    }
}

/// Row and column of a parameter in the coupling matrix; `index` counts the catalogue's parameters.
pub const fn row_and_column(index: usize) -> (usize, usize) {
    let (row, place) = (index / 5, index % 5);
    let column = if place < row { place } else { place + 1 };
    (row, column)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_names_follow_rows_and_columns() {
        let axes = ["fx", "fy", "fz", "tx", "ty", "tz"];
        assert_eq!(EFFECT.parameters.len(), 30);
        for (i, parameter) in EFFECT.parameters.iter().enumerate() {
            let (row, column) = row_and_column(i);
            let expected = format!("{}_from_{}", axes[row], axes[column]);
            assert_eq!(parameter.name, expected);
        }
    }

    #[test]
    fn a_force_leaks_into_a_torque() {
        let mut coupling = [[0.0; 6]; 6];
        coupling[4][0] = 0.5; // ty_from_fx
        let sensor = Crosstalk::<f64>::new(&coupling).unwrap();
        let got = sensor
            .apply(&Wrench::of(&[10.0, 0.0, 0.0, 0.0, 1.0, 0.0]))
            .get();
        assert_eq!(got, [10.0, 0.0, 0.0, 0.0, 6.0, 0.0]);
    }
}
