//! Units, calibration matrix, and strain gauges into a wrench.

use crate::sensor::SensorFault;

/// Standard gravity (m/s²), exact by definition (3rd CGPM, 1901).
const STANDARD_GRAVITY: f64 = 9.806_65;
/// Pound (kg), exact by definition (international yard and pound agreement, 1959).
const POUND_KG: f64 = 0.453_592_37;
/// Inch (m), exact by definition (same agreement).
const INCH_M: f64 = 0.0254;
/// Pound-force (N).
const POUND_FORCE_N: f64 = POUND_KG * STANDARD_GRAVITY;

/// A unit of the sensor: each with the code on the wire, which is its discriminant, and its size. A code that the manual does
/// not have is a fault: a guess would scale every value.
macro_rules! unit {
    (
        $(#[$about:meta])*
        $unit:ident, $size:ident in $si:literal:
        $($symbol:literal $name:ident = $code:literal is $value:expr,)+
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $unit {
            $(#[doc = $symbol] $name = $code,)+
        }

        impl $unit {
            /// The unit with a code of the wire.
            ///
            /// # Errors
            #[doc = concat!("[`SensorFault::", stringify!($unit), "`] for a code that the manual does not have.")]
            pub fn from_code(code: u8) -> Result<Self, SensorFault> {
                match code {
                    $($code => Ok(Self::$name),)+
                    _ => Err(SensorFault::$unit { code }),
                }
            }

            #[doc = concat!("One unit in ", $si, ".")]
            pub fn $size(self) -> f64 {
                match self {
                    $(Self::$name => $value,)+
                }
            }
        }
    };
}

unit! {
    /// Unit of the sensor's forces.
    ForceUnit, newtons in "N":
    "lbf" PoundForce = 1 is POUND_FORCE_N,
    "N" Newton = 2 is 1.0,
    "klbf" KilopoundForce = 3 is 1e3 * POUND_FORCE_N,
    "kN" Kilonewton = 4 is 1e3,
    "kgf" KilogramForce = 5 is STANDARD_GRAVITY,
    "gf" GramForce = 6 is 1e-3 * STANDARD_GRAVITY,
}

unit! {
    /// Unit of the sensor's torques.
    TorqueUnit, newton_metres in "N·m":
    "lbf·in" PoundForceInch = 1 is POUND_FORCE_N * INCH_M,
    "lbf·ft" PoundForceFoot = 2 is POUND_FORCE_N * 12.0 * INCH_M,
    "N·m" NewtonMetre = 3 is 1.0,
    "N·mm" NewtonMillimetre = 4 is 1e-3,
    "kgf·cm" KilogramForceCentimetre = 5 is STANDARD_GRAVITY * 1e-2,
    "kN·m" KilonewtonMetre = 6 is 1e3,
}

/// Calibration that converts strain gauge counts into a wrench.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtiCalibration {
    /// Rows: force X, Y, Z, torque X, Y, Z. Columns: gauges 0 to 5.
    pub matrix: [[f64; 6]; 6],
    /// Counts per N.
    pub counts_per_force: f64,
    /// Counts per N·m.
    pub counts_per_torque: f64,
}

impl AtiCalibration {
    /// Force X, Y, Z (N) and torque X, Y, Z (N·m) in the sensor frame, with the bias of the gauges still in it.
    pub fn wrench(&self, gauges: &[i16; 6]) -> [f64; 6] {
        let [force_x, force_y, force_z, torque_x, torque_y, torque_z] = self.matrix.map(|row| {
            row.iter()
                .zip(gauges)
                .map(|(factor, gauge)| factor * f64::from(*gauge))
                .sum::<f64>()
        });
        [
            force_x / self.counts_per_force,
            force_y / self.counts_per_force,
            force_z / self.counts_per_force,
            torque_x / self.counts_per_torque,
            torque_y / self.counts_per_torque,
            torque_z / self.counts_per_torque,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_have_their_textbook_size() {
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
        close(ForceUnit::PoundForce.newtons(), 4.448_222);
        close(ForceUnit::KilopoundForce.newtons(), 4_448.222);
        close(ForceUnit::GramForce.newtons(), 0.009_806_65);
        close(TorqueUnit::PoundForceInch.newton_metres(), 0.112_984_8);
        close(TorqueUnit::PoundForceFoot.newton_metres(), 1.355_818);
        close(
            TorqueUnit::KilogramForceCentimetre.newton_metres(),
            0.098_066_5,
        );
    }

    #[test]
    fn codes_are_those_of_the_manual() {
        for code in 0..=u8::MAX {
            let known = (1..=6).contains(&code);
            let force = ForceUnit::from_code(code);
            let torque = TorqueUnit::from_code(code);
            if known {
                assert_eq!(force.map(|unit| unit as u8), Ok(code));
                assert_eq!(torque.map(|unit| unit as u8), Ok(code));
            } else {
                assert_eq!(force, Err(SensorFault::ForceUnit { code }));
                assert_eq!(torque, Err(SensorFault::TorqueUnit { code }));
            }
        }
    }

    #[test]
    fn wrench_is_matrix_times_gauges_per_count() {
        let mut matrix = [[0.0; 6]; 6];
        for (row, factors) in matrix.iter_mut().enumerate() {
            factors[row] = 1.0;
            factors[(row + 1) % 6] = 0.5;
        }
        let calibration = AtiCalibration {
            matrix,
            counts_per_force: 10.0,
            counts_per_torque: 100.0,
        };
        assert_eq!(
            calibration.wrench(&[10, 20, 30, 40, 50, i16::MIN]),
            [2.0, 3.5, 5.0, 0.65, -163.34, -327.63]
        );
    }
}
