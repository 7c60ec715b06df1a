//! Requests and answers as frames.

use crate::can::{Frame, Id};

/// What the driver asks the sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Request {
    Gauges,
    /// Row of the calibration matrix, 0 to 5.
    MatrixRow(u8),
    SerialNumber,
    CountsPerUnit,
    UnitCodes,
    Reset,
    FirmwareVersion,
}

/// What the sensor answers, one frame at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Answer {
    /// First frame of a reading: status and gauges 0, 2, 4.
    EvenGauges {
        status: u16,
        gauges: [i16; 3],
    },
    /// Second frame of a reading: gauges 1, 3, 5.
    OddGauges([i16; 3]),
    /// Part 0, 1 or 2 of a matrix row: two columns.
    MatrixPart {
        part: u8,
        columns: [f32; 2],
    },
    /// ASCII digits.
    SerialNumber([u8; 8]),
    /// Counts per unit of force and of torque.
    CountsPerUnit {
        force: u32,
        torque: u32,
    },
    /// Codes of the units.
    UnitCodes {
        force: u8,
        torque: u8,
    },
    FirmwareVersion {
        major: u8,
        minor: u8,
        build: u16,
    },
}

const GAUGES: u8 = 0x0;
const ODD_GAUGES: u8 = 0x1;
const MATRIX: u8 = 0x2;
const MATRIX_END: u8 = 0x4;
const SERIAL_NUMBER: u8 = 0x5;
const COUNTS_PER_UNIT: u8 = 0x7;
const UNIT_CODES: u8 = 0x8;
const RESET: u8 = 0xC;
const FIRMWARE_VERSION: u8 = 0xF;

/// Largest base of the identifiers: seven bits, because the opcode takes the lower four of eleven.
pub(super) const MAX_BASE_ID: u8 = 0x7F;

/// Frame with an opcode; `None` if the base is too large.
fn frame(base_id: u8, opcode: u8, data: &[u8]) -> Option<Frame> {
    let id = Id::Standard(u16::from(base_id) << 4 | u16::from(opcode));
    Frame::new(id, data).ok()
}

/// Opcode of a data frame that belongs to a sensor with this base.
fn opcode(base_id: u8, frame: &Frame) -> Option<u8> {
    match frame.id() {
        Id::Standard(id) if !frame.is_remote() && id >> 4 == base_id.into() => {
            Some((id & 0xF) as u8)
        }
        _ => None,
    }
}

impl Request {
    /// The frame to send; `None` if the base is too large.
    pub(super) fn encode(self, base_id: u8) -> Option<Frame> {
        match self {
            Self::Gauges => frame(base_id, GAUGES, &[]),
            Self::MatrixRow(row) => frame(base_id, MATRIX, &[row]),
            Self::SerialNumber => frame(base_id, SERIAL_NUMBER, &[]),
            Self::CountsPerUnit => frame(base_id, COUNTS_PER_UNIT, &[]),
            Self::UnitCodes => frame(base_id, UNIT_CODES, &[]),
            Self::Reset => frame(base_id, RESET, &[]),
            Self::FirmwareVersion => frame(base_id, FIRMWARE_VERSION, &[]),
        }
    }

    /// The request in a frame; `None` if it is none.
    pub(super) fn decode(base_id: u8, frame: &Frame) -> Option<Self> {
        match (opcode(base_id, frame)?, frame.data()) {
            (GAUGES, []) => Some(Self::Gauges),
            (MATRIX, [row @ 0..=5]) => Some(Self::MatrixRow(*row)),
            (SERIAL_NUMBER, []) => Some(Self::SerialNumber),
            (COUNTS_PER_UNIT, []) => Some(Self::CountsPerUnit),
            (UNIT_CODES, []) => Some(Self::UnitCodes),
            (RESET, []) => Some(Self::Reset),
            (FIRMWARE_VERSION, []) => Some(Self::FirmwareVersion),
            _ => None,
        }
    }
}

impl Answer {
    /// The answer in a frame; `None` if it is none.
    pub(super) fn decode(base_id: u8, frame: &Frame) -> Option<Self> {
        Some(match (opcode(base_id, frame)?, frame.data()) {
            (GAUGES, &[s1, s0, a1, a0, b1, b0, c1, c0]) => Self::EvenGauges {
                status: u16::from_be_bytes([s1, s0]),
                gauges: [[a1, a0], [b1, b0], [c1, c0]].map(i16::from_be_bytes),
            },
            (ODD_GAUGES, &[a1, a0, b1, b0, c1, c0]) => {
                Self::OddGauges([[a1, a0], [b1, b0], [c1, c0]].map(i16::from_be_bytes))
            }
            (op @ MATRIX..=MATRIX_END, &[a3, a2, a1, a0, b3, b2, b1, b0]) => Self::MatrixPart {
                part: op - MATRIX,
                columns: [[a3, a2, a1, a0], [b3, b2, b1, b0]].map(f32::from_be_bytes),
            },
            (SERIAL_NUMBER, data) => Self::SerialNumber(data.try_into().ok()?),
            (COUNTS_PER_UNIT, &[f3, f2, f1, f0, t3, t2, t1, t0]) => Self::CountsPerUnit {
                force: u32::from_be_bytes([f3, f2, f1, f0]),
                torque: u32::from_be_bytes([t3, t2, t1, t0]),
            },
            (UNIT_CODES, &[force, torque, ..]) => Self::UnitCodes { force, torque },
            (FIRMWARE_VERSION, &[major, minor, b1, b0, ..]) => Self::FirmwareVersion {
                major,
                minor,
                build: u16::from_be_bytes([b1, b0]),
            },
            _ => return None,
        })
    }

    /// The frame that the sensor sends; `None` if the base is too large.
    pub(super) fn encode(self, base_id: u8) -> Option<Frame> {
        match self {
            Self::EvenGauges { status, gauges } => {
                let [[a1, a0], [b1, b0], [c1, c0]] = gauges.map(i16::to_be_bytes);
                let [s1, s0] = status.to_be_bytes();
                frame(base_id, GAUGES, &[s1, s0, a1, a0, b1, b0, c1, c0])
            }
            Self::OddGauges(gauges) => frame(
                base_id,
                ODD_GAUGES,
                gauges.map(i16::to_be_bytes).as_flattened(),
            ),
            Self::MatrixPart { part, columns } => frame(
                base_id,
                MATRIX + part.min(MATRIX_END - MATRIX),
                columns.map(f32::to_be_bytes).as_flattened(),
            ),
            Self::SerialNumber(digits) => frame(base_id, SERIAL_NUMBER, &digits),
            Self::CountsPerUnit { force, torque } => frame(
                base_id,
                COUNTS_PER_UNIT,
                [force, torque].map(u32::to_be_bytes).as_flattened(),
            ),
            Self::UnitCodes { force, torque } => frame(base_id, UNIT_CODES, &[force, torque]),
            Self::FirmwareVersion {
                major,
                minor,
                build,
            } => {
                let [b1, b0] = build.to_be_bytes();
                frame(base_id, FIRMWARE_VERSION, &[major, minor, b1, b0])
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames recorded from a sensor with base 0x7F.
    const RECORDED: u8 = 0x7F;

    fn recorded(id: u16, data: &[u8]) -> Option<Answer> {
        let frame = Frame::new(Id::Standard(id), data).unwrap();
        Answer::decode(RECORDED, &frame)
    }

    #[test]
    fn decodes_recorded_gauges() {
        assert_eq!(
            recorded(0x7F0, &[0x40, 0x00, 0x00, 0x12, 0xFE, 0x3A, 0xE6, 0xA8]),
            Some(Answer::EvenGauges {
                status: 0x4000,
                gauges: [18, -454, -6488]
            })
        );
        assert_eq!(
            recorded(0x7F1, &[0x04, 0xFA, 0xFA, 0x93, 0x01, 0x43]),
            Some(Answer::OddGauges([1274, -1389, 323]))
        );
    }

    #[test]
    fn decodes_recorded_matrix_row() {
        for (id, data, expected) in [
            (
                0x7F2,
                [0x3F, 0x40, 0x25, 0x6A, 0xC1, 0xDA, 0xD5, 0xF4],
                [0.750_57, -27.354_47],
            ),
            (
                0x7F3,
                [0x3F, 0xF8, 0x5F, 0x58, 0xC1, 0xCC, 0xED, 0x0E],
                [1.940_41, -25.615_75],
            ),
            (
                0x7F4,
                [0x3F, 0x9F, 0xF9, 0xFC, 0xC1, 0xDD, 0x29, 0xAD],
                [1.249_82, -27.645_35],
            ),
        ] {
            let Some(Answer::MatrixPart { part, columns }) = recorded(id, &data) else {
                panic!("not a matrix part: {id:#x}");
            };
            assert_eq!(u16::from(part), id - 0x7F2);
            for (column, expected) in columns.into_iter().zip(expected) {
                assert!((f64::from(column) - expected).abs() < 5e-6);
            }
        }
    }

    #[test]
    fn other_lengths_bases_and_remote_frames_are_not_answers() {
        for opcode in 0..16 {
            for len in 0..=8 {
                let decoded = recorded(0x7F0 | opcode, &[0; 8][..len]).is_some();
                let expected = matches!(
                    (opcode, len),
                    (0, 8) | (1, 6) | (2..=4, 8) | (5, 8) | (7, 8) | (8, 2..) | (0xF, 4..)
                );
                assert_eq!(decoded, expected, "opcode {opcode:#x} length {len}");
            }
        }
        let other_base = Frame::new(Id::Standard(0x200), &[0; 8]).unwrap();
        let extended = Frame::new(Id::Extended(0x7F0), &[0; 8]).unwrap();
        let remote = Frame::new_remote(Id::Standard(0x7F0), 8).unwrap();
        for frame in [other_base, extended, remote] {
            assert_eq!(Answer::decode(RECORDED, &frame), None);
        }
    }

    #[test]
    fn requests_round_trip() {
        let requests = (0..=5).map(Request::MatrixRow).chain([
            Request::Gauges,
            Request::SerialNumber,
            Request::CountsPerUnit,
            Request::UnitCodes,
            Request::Reset,
            Request::FirmwareVersion,
        ]);
        for request in requests {
            let frame = request.encode(0x20).unwrap();
            assert_eq!(Request::decode(0x20, &frame), Some(request));
            assert_eq!(Request::decode(0x21, &frame), None);
        }
        assert_eq!(
            Request::Gauges.encode(0x20),
            Frame::new(Id::Standard(0x200), &[]).ok()
        );
        assert_eq!(Request::Gauges.encode(MAX_BASE_ID + 1), None);
    }
}
