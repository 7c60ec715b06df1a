//! From a wrench to the integer counts of six strain gauges: `g = round(M⁻¹ D W)` clamped to
//! 16 bit, D = diag(counts per newton, counts per newton metre); the inverse of
//! `W_i = Σ_j M_ij g_j / D_ii` (ATI 9610-05-1030, calibration matrix of a NETCANOEM sensor).
//!
//! It is no effect, but how the sensor reads.

use nalgebra::{Matrix6, Vector6};
use softdock_control::frames::Wrench;
use softdock_control::range::{SettingsError, in_range};

/// Why gauges cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub(super) enum GaugeError {
    /// A scale is out of range.
    #[error("{0}")]
    OutOfRange(SettingsError),
    /// The calibration matrix has no inverse.
    #[error(
        "calibration: the matrix has no inverse (determinant {determinant}), six independent rows are needed"
    )]
    Singular {
        /// Its determinant.
        determinant: f64,
    },
}

/// Six gauges that see a wrench through a coupled calibration matrix.
#[derive(Clone, Copy, Debug)]
pub(super) struct GaugeQuantisation {
    counts_from_wrench: Matrix6<f64>,
}

impl GaugeQuantisation {
    /// `calibration`: rows Fx Fy Fz Tx Ty Tz, columns gauges 0 to 5; its inverse is taken once,
    /// here.
    pub(super) fn new(
        calibration: &[[f64; 6]; 6],
        counts_per_newton: f64,
        counts_per_newton_metre: f64,
    ) -> Result<Self, GaugeError> {
        let scale = |name, value| in_range(name, value, 1e-3, 1e9).map_err(GaugeError::OutOfRange);
        scale("counts_per_newton", counts_per_newton)?;
        scale("counts_per_newton_metre", counts_per_newton_metre)?;
        let (force, torque) = (counts_per_newton, counts_per_newton_metre);
        let matrix = Matrix6::<f64>::from_row_iterator(calibration.iter().flatten().copied());
        let inverse = matrix
            .try_inverse()
            .filter(|m| m.iter().all(|x| x.is_finite()));
        let determinant = matrix.determinant();
        let inverse = inverse.ok_or(GaugeError::Singular { determinant })?;
        let scale = Vector6::new(force, force, force, torque, torque, torque);
        let counts_from_wrench = inverse * Matrix6::from_diagonal(&scale);
        Ok(Self { counts_from_wrench })
    }

    /// Counts of gauges 0 to 5, rounded, saturated to 16 bit.
    pub(super) fn counts(&self, wrench: &Wrench<f64>) -> [i16; 6] {
        let (f, t) = (&wrench.force, &wrench.torque);
        let gauges = self.counts_from_wrench * Vector6::new(f.x, f.y, f.z, t.x, t.y, t.z);
        // A float to integer cast saturates, and turns NaN into 0.
        <[f64; 6]>::from(gauges).map(|g| g.round() as i16)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diagonal_gauges_round_and_saturate() {
        let mut calibration = [[0.0; 6]; 6];
        for (i, row) in calibration.iter_mut().enumerate() {
            row[i] = 2.0; // two calibrated counts per gauge count
        }
        let wrench = [1.26, -1.24, 1e5, 0.1, -1e4, 0.0];
        let expected = [6, -6, i16::MAX, 5, i16::MIN, 0]; // times 10/2 and 100/2
        let gauges = GaugeQuantisation::new(&calibration, 10.0, 100.0).unwrap();
        assert_eq!(gauges.counts(&Wrench::of(&wrench)), expected);
    }

    #[test]
    fn a_singular_matrix_is_refused() {
        let error = GaugeQuantisation::new(&[[1.0; 6]; 6], 1.0, 1.0).unwrap_err();
        assert_eq!(error, GaugeError::Singular { determinant: 0.0 });
        assert!(GaugeQuantisation::new(&[[f64::NAN; 6]; 6], 1.0, 1.0).is_err());
    }
}
