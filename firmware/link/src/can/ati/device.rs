//! The sensor's side, for simulated sensors.

use heapless::Vec;

use super::calibration::{AtiCalibration, ForceUnit, TorqueUnit};
use super::protocol::{Answer, MAX_BASE_ID, Request};
use crate::can::Frame;
use crate::decimal::Decimal;

/// A sensor that answers requests as ATI's manual says.
#[derive(Clone, Debug)]
pub struct AtiDevice {
    base_id: u8,
    matrix: [[f32; 6]; 6],
    counts_per_force: u32,
    counts_per_torque: u32,
    force_unit: ForceUnit,
    torque_unit: TorqueUnit,
}

/// Why a sensor cannot have these settings.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum AtiDeviceError {
    /// More than seven bits.
    #[error("identifier base {received:#x} has more than 7 bits")]
    BaseId {
        /// The base.
        received: u8,
    },
    /// The counts per unit on the wire are a whole number from 1 to 2^32 - 1.
    #[error("{received} counts per unit: expected a number from 1 to {max}", max = u32::MAX)]
    CountsPerUnit {
        /// Counts per unit of force or torque, in the sensor's own unit.
        received: f64,
    },
    /// The matrix is finite in single precision.
    #[error("row {row} of the calibration matrix is not finite in single precision")]
    Matrix {
        /// Row of the matrix.
        row: u8,
    },
}

impl AtiDevice {
    /// Serial number of every simulated sensor.
    const SERIAL_NUMBER: [u8; 8] = *b"FT000001";

    /// A sensor whose registers hold `calibration` in the given units. On the wire the matrix has single precision
    /// and the counts per unit are rounded to whole numbers.
    ///
    /// # Errors
    /// [`AtiDeviceError`] if the wire format cannot hold the values.
    pub fn new(
        base_id: u8,
        calibration: &AtiCalibration,
        force_unit: ForceUnit,
        torque_unit: TorqueUnit,
    ) -> Result<Self, AtiDeviceError> {
        if base_id > MAX_BASE_ID {
            return Err(AtiDeviceError::BaseId { received: base_id });
        }
        let matrix = calibration
            .matrix
            .map(|row| row.map(|factor| factor as f32));
        for (row, factors) in (0..).zip(&matrix) {
            if !factors.iter().all(|factor| factor.is_finite()) {
                return Err(AtiDeviceError::Matrix { row });
            }
        }
        Ok(Self {
            base_id,
            matrix,
            counts_per_force: whole(calibration.counts_per_force * force_unit.newtons())?,
            counts_per_torque: whole(calibration.counts_per_torque * torque_unit.newton_metres())?,
            force_unit,
            torque_unit,
        })
    }

    /// The frames with which the sensor answers `request`, in order, while its gauges and its status word are as
    /// given; none if the frame is not a request to this sensor.
    pub fn answer(&mut self, request: &Frame, gauges: [i16; 6], status: u16) -> Vec<Frame, 3> {
        let answers: [Option<Answer>; 3] = match Request::decode(self.base_id, request) {
            Some(Request::Gauges) => {
                let [gauge_0, gauge_1, gauge_2, gauge_3, gauge_4, gauge_5] = gauges;
                let even = Answer::EvenGauges {
                    status,
                    gauges: [gauge_0, gauge_2, gauge_4],
                };
                let odd = Answer::OddGauges([gauge_1, gauge_3, gauge_5]);
                [Some(even), Some(odd), None]
            }
            Some(Request::MatrixRow(row)) => self.matrix_row(row),
            Some(Request::SerialNumber) => only(Answer::SerialNumber(Self::SERIAL_NUMBER)),
            Some(Request::CountsPerUnit) => only(Answer::CountsPerUnit {
                force: self.counts_per_force,
                torque: self.counts_per_torque,
            }),
            Some(Request::UnitCodes) => only(Answer::UnitCodes {
                force: self.force_unit as u8,
                torque: self.torque_unit as u8,
            }),
            Some(Request::FirmwareVersion) => only(Answer::FirmwareVersion {
                major: 1,
                minor: 0,
                build: 1,
            }),
            Some(Request::Reset) | None => [None; 3],
        };
        answers
            .into_iter()
            .flatten()
            .filter_map(|answer| answer.encode(self.base_id))
            .collect()
    }

    fn matrix_row(&self, row: u8) -> [Option<Answer>; 3] {
        let [a, b, c, d, e, f] = self
            .matrix
            .get(usize::from(row))
            .copied()
            .unwrap_or_default();
        let part = |part, columns| Some(Answer::MatrixPart { part, columns });
        [part(0, [a, b]), part(1, [c, d]), part(2, [e, f])]
    }
}

fn only(answer: Answer) -> [Option<Answer>; 3] {
    [Some(answer), None, None]
}

/// Counts per unit as the wire holds them.
fn whole(received: f64) -> Result<u32, AtiDeviceError> {
    Decimal::from_f64(received, 0)
        .ok()
        .and_then(|decimal| u32::try_from(decimal.counts).ok())
        .filter(|counts| *counts > 0)
        .ok_or(AtiDeviceError::CountsPerUnit { received })
}
