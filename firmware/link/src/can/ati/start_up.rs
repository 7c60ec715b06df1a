//! Reading the calibration from the sensor, query by query.

use super::calibration::{AtiCalibration, ForceUnit, TorqueUnit};
use super::protocol::{Answer, Request};
use crate::sensor::SensorFault;

/// Identity of a sensor, as far as it reports it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AtiIdentity {
    /// Serial number, ASCII.
    pub serial_number: Option<[u8; 8]>,
    /// Firmware version: major, minor, build.
    pub firmware_version: Option<(u8, u8, u16)>,
}

/// The sensor's scale as on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Scale {
    pub(super) counts_per_force: u32,
    pub(super) counts_per_torque: u32,
    pub(super) force_unit: u8,
    pub(super) torque_unit: u8,
}

/// The queries, in this order.
const QUERIES: [Request; 10] = [
    Request::FirmwareVersion,
    Request::SerialNumber,
    Request::MatrixRow(0),
    Request::MatrixRow(1),
    Request::MatrixRow(2),
    Request::MatrixRow(3),
    Request::MatrixRow(4),
    Request::MatrixRow(5),
    Request::CountsPerUnit,
    Request::UnitCodes,
];

/// Meaning of an answer for the start-up.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "lives for one call; there is no heap to put it on"
)]
pub(super) enum Progress {
    /// Not an answer to the query.
    NotAsked,
    /// A part of the answer; the rest is still to come.
    Partial,
    /// The query is answered, the next one is due.
    Answered,
    /// All queries are answered.
    Complete(AtiCalibration, Scale),
}

/// The query that is due, and the results of the earlier ones.
#[derive(Clone, Debug)]
pub(super) struct StartUp {
    next: usize,
    matrix: [[f64; 6]; 6],
    row_parts: [Option<[f32; 2]>; 3],
    counts_per_unit: [u32; 2],
    pub(super) identity: AtiIdentity,
}

impl StartUp {
    pub(super) fn new() -> Self {
        Self {
            next: 0,
            matrix: [[0.0; 6]; 6],
            row_parts: [None; 3],
            counts_per_unit: [0; 2],
            identity: AtiIdentity::default(),
        }
    }

    /// The query that is due; parts of an earlier answer to it are dropped.
    pub(super) fn query(&mut self) -> Option<Request> {
        self.row_parts = [None; 3];
        QUERIES.get(self.next).copied()
    }

    /// Skips the query that is due if readings do not depend on it; returns whether it was skipped.
    pub(super) fn skip_optional(&mut self) -> bool {
        let optional = self.is_optional();
        self.next += usize::from(optional);
        optional
    }

    /// Whether readings do not depend on the query that is due.
    pub(super) fn is_optional(&self) -> bool {
        matches!(
            QUERIES.get(self.next),
            Some(Request::FirmwareVersion | Request::SerialNumber)
        )
    }

    /// Takes an answer.
    ///
    /// # Errors
    /// The answer is well-formed and cannot be used.
    pub(super) fn accept(&mut self, answer: Answer) -> Result<Progress, SensorFault> {
        let Some(query) = QUERIES.get(self.next) else {
            return Ok(Progress::NotAsked);
        };
        match (query, answer) {
            (Request::MatrixRow(row), Answer::MatrixPart { part, columns }) => {
                return self.accept_matrix_part(*row, part, columns);
            }
            (
                Request::FirmwareVersion,
                Answer::FirmwareVersion {
                    major,
                    minor,
                    build,
                },
            ) => {
                self.identity.firmware_version = Some((major, minor, build));
            }
            (Request::SerialNumber, Answer::SerialNumber(digits)) => {
                self.identity.serial_number = Some(digits);
            }
            (Request::CountsPerUnit, Answer::CountsPerUnit { force, torque }) => {
                if force == 0 || torque == 0 {
                    return Err(SensorFault::CountsPerUnit { force, torque });
                }
                self.counts_per_unit = [force, torque];
            }
            (Request::UnitCodes, Answer::UnitCodes { force, torque }) => {
                return self.complete(force, torque);
            }
            _ => return Ok(Progress::NotAsked),
        }
        self.next += 1;
        Ok(Progress::Answered)
    }

    fn accept_matrix_part(
        &mut self,
        row: u8,
        part: u8,
        columns: [f32; 2],
    ) -> Result<Progress, SensorFault> {
        if !columns.iter().all(|factor| factor.is_finite()) {
            return Err(SensorFault::Matrix { row });
        }
        if let Some(slot) = self.row_parts.get_mut(usize::from(part)) {
            *slot = Some(columns);
        }
        let [Some([a, b]), Some([c, d]), Some([e, f])] = self.row_parts else {
            return Ok(Progress::Partial);
        };
        if let Some(slot) = self.matrix.get_mut(usize::from(row)) {
            *slot = [a, b, c, d, e, f].map(f64::from);
        }
        self.next += 1;
        Ok(Progress::Answered)
    }

    fn complete(&self, force_unit: u8, torque_unit: u8) -> Result<Progress, SensorFault> {
        let [counts_per_force, counts_per_torque] = self.counts_per_unit;
        let scale = Scale {
            counts_per_force,
            counts_per_torque,
            force_unit,
            torque_unit,
        };
        let newtons = ForceUnit::from_code(force_unit)?.newtons();
        let newton_metres = TorqueUnit::from_code(torque_unit)?.newton_metres();
        let calibration = AtiCalibration {
            matrix: self.matrix,
            counts_per_force: f64::from(counts_per_force) / newtons,
            counts_per_torque: f64::from(counts_per_torque) / newton_metres,
        };
        Ok(Progress::Complete(calibration, scale))
    }
}
