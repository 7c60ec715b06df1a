//! What the bits of the status word mean; each product has its own.

use super::Product;
use crate::sensor::ReadingFlags;

/// A bit of the status word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StatusBit {
    /// Its number, 0 to 31.
    pub bit: u8,
    /// What it says.
    pub meaning: &'static str,
    /// What of a reading it spoils.
    effect: Effect,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Effect {
    /// A fault that may pass.
    Fault,
    /// The readings are not to be used.
    Critical,
    /// The load is beyond what the sensor measures.
    Saturated,
}

use Effect::{Critical, Fault, Saturated};

const fn bit(bit: u8, effect: Effect, meaning: &'static str) -> StatusBit {
    StatusBit {
        bit,
        meaning,
        effect,
    }
}

/// SCHUNK/ATI manual 9610-05-EtherCAT Axia-09, status code; bits 26 to 31 are critical.
const AXIA80: &[StatusBit] = &[
    bit(0, Fault, "temperature out of range"),
    bit(1, Fault, "supply out of range"),
    bit(2, Fault, "broken gauge"),
    bit(3, Fault, "busy"),
    bit(5, Fault, "hardware or stack error"),
    bit(26, Saturated, "gauge near its range"),
    bit(27, Saturated, "gauge out of range"),
    bit(28, Critical, "simulated error"),
    bit(29, Critical, "checksum of the calibration"),
    bit(30, Saturated, "force or torque out of range"),
    bit(31, Critical, "error"),
];

/// nasa-jpl/jsd, `jsd_ati_fts_parse_status_code`.
const ETHERCAT_FT: &[StatusBit] = &[
    bit(0, Fault, "monitor condition tripped"),
    bit(1, Fault, "supply out of range"),
    bit(3, Critical, "bridge voltage out of range"),
    bit(4, Critical, "bridge current out of range"),
    bit(5, Critical, "digital potentiometer"),
    bit(6, Critical, "EEPROM"),
    bit(7, Critical, "converter"),
    bit(28, Critical, "simulated error"),
    bit(29, Critical, "checksum of the calibration"),
    bit(30, Saturated, "saturated"),
    bit(31, Critical, "fault"),
];

impl Product {
    /// The bits that the product's documents name. Another bit that is set is a fault as well.
    pub const fn status_bits(self) -> &'static [StatusBit] {
        match self {
            Self::EtherCatFt => ETHERCAT_FT,
            Self::Axia80 => AXIA80,
        }
    }

    /// What a status word says of its reading.
    pub fn flags(self, status: u32) -> ReadingFlags {
        let any = |wanted: &[Effect]| {
            self.status_bits()
                .iter()
                .any(|known| wanted.contains(&known.effect) && status & known.mask() != 0)
        };
        ReadingFlags {
            saturated: any(&[Saturated]),
            fault: status != 0,
            critical: any(&[Saturated, Critical]),
        }
    }
}

impl StatusBit {
    /// The bit in its place.
    pub const fn mask(&self) -> u32 {
        1 << self.bit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_bit_means_different_things() {
        let flags = |product: Product, bit: u8| {
            let flags = product.flags(1_u32 << bit);
            assert!(flags.fault);
            (flags.saturated, flags.critical)
        };
        assert_eq!(flags(Product::Axia80, 5), (false, false));
        assert_eq!(flags(Product::EtherCatFt, 5), (false, true));
        assert_eq!(flags(Product::Axia80, 27), (true, true));
        assert_eq!(flags(Product::EtherCatFt, 27), (false, false));
        for product in Product::ALL {
            assert_eq!(flags(product, 30), (true, true));
            assert_eq!(flags(product, 31), (false, true));
            assert_eq!(product.flags(0), ReadingFlags::default());
        }
    }

    #[test]
    fn each_bit_stands_once_and_in_order() {
        for product in Product::ALL {
            let bits = product.status_bits();
            assert!(bits.windows(2).all(|pair| pair[0].bit < pair[1].bit));
            assert!(bits.iter().all(|bit| bit.bit < 32));
        }
    }
}
