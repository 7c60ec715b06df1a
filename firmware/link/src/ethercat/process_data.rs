//! Process data: what the SubDevice sends (TxPDO 0x1A00) and receives (RxPDO 0x1601). Numbers are little-endian.

/// Length of TxPDO 0x1A00: 0x6000:1 to 6, counts of force X, Y, Z and torque X, Y, Z, `i32`; 0x6010, status, `u32`;
/// 0x6020, sample counter, `u32`.
pub const INPUT_BYTES: usize = 32;
/// Length of RxPDO 0x1601: 0x7010:1 and 2, control words 1 and 2, `u32`.
pub const OUTPUT_BYTES: usize = 8;

/// What the SubDevice sends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inputs {
    /// Counts of force X, Y, Z and torque X, Y, Z.
    pub counts: [i32; 6],
    /// Status word.
    pub status: u32,
    /// Increases with each sample of the sensor, wrapping.
    pub sample: u32,
}

impl Inputs {
    /// From the bytes of TxPDO 0x1A00.
    pub fn decode(bytes: &[u8; INPUT_BYTES]) -> Self {
        let mut words = [0; INPUT_BYTES / 4];
        let (chunks, _) = bytes.as_chunks::<4>();
        for (word, chunk) in words.iter_mut().zip(chunks) {
            *word = u32::from_le_bytes(*chunk);
        }
        let [counts @ .., status, sample] = words;
        Self {
            counts: counts.map(u32::cast_signed),
            status,
            sample,
        }
    }

    /// The sensor's side, for simulated sensors.
    pub fn encode(&self) -> [u8; INPUT_BYTES] {
        let mut bytes = [0; INPUT_BYTES];
        let words = self.counts.map(i32::cast_unsigned);
        let words = words.iter().chain([&self.status, &self.sample]);
        let (chunks, _) = bytes.as_chunks_mut::<4>();
        for (chunk, word) in chunks.iter_mut().zip(words) {
            *chunk = word.to_le_bytes();
        }
        bytes
    }
}

/// Data that the SubDevice receives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Control {
    /// Switches the sensor's own bias off; it acts when it is switched on.
    pub clear_bias: bool,
    /// Low-pass filter of the sensor: 0 none, 1 to 8 ever lower.
    pub filter: u8,
    /// Calibration of the sensor, 0 to 15.
    pub calibration: u8,
    /// Rate of its samples, 0 to 3; Axia80.
    pub sample_rate: u8,
}

impl Control {
    /// The bytes of RxPDO 0x1601: bits 2 (clear bias), 4 to 7 (filter), 8 to 11 (calibration) and 12 to 15 (sample
    /// rate) of word 1. Bit 0, which sets a bias, is never set: the board has a zero of its own.
    pub fn encode(self) -> [u8; OUTPUT_BYTES] {
        let field = |value: u8, shift: u32| (u64::from(value) & 0xF) << shift;
        let word = u64::from(self.clear_bias) << 2
            | field(self.filter, 4)
            | field(self.calibration, 8)
            | field(self.sample_rate, 12);
        word.to_le_bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_stand_in_their_places() {
        let inputs = Inputs {
            counts: [1, -2, i32::MIN, 4, 5, i32::MAX],
            status: 0x8000_0001,
            sample: 0x0403_0201,
        };
        let bytes = inputs.encode();
        assert_eq!(bytes[4..8], [0xFE, 0xFF, 0xFF, 0xFF]);
        assert_eq!(bytes[24..], [1, 0, 0, 0x80, 1, 2, 3, 4]);
        assert_eq!(Inputs::decode(&bytes), inputs);
    }

    #[test]
    fn outputs_stand_in_their_places() {
        let control = Control {
            clear_bias: true,
            filter: 8,
            calibration: 15,
            sample_rate: 3,
        };
        assert_eq!(control.encode(), [0x84, 0x3F, 0, 0, 0, 0, 0, 0]);
        assert_eq!(Control::default().encode(), [0; OUTPUT_BYTES]);
    }
}
