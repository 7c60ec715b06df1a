//! Meaning of the bits of the status word; each product has its own.

use super::Product;

/// A bit of the status word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StatusBit {
    /// Its number, 0 to 31.
    pub bit: u8,
    /// What it says.
    pub meaning: &'static str,
    /// The load exceeds the range of the sensor.
    saturates: bool,
}

const fn fault(bit: u8, meaning: &'static str) -> StatusBit {
    StatusBit {
        bit,
        meaning,
        saturates: false,
    }
}

const fn saturated(bit: u8, meaning: &'static str) -> StatusBit {
    StatusBit {
        saturates: true,
        ..fault(bit, meaning)
    }
}

/// SCHUNK/ATI manual 9610-05-EtherCAT Axia-09, status code.
const AXIA80: &[StatusBit] = &[
    fault(0, "temperature out of range"),
    fault(1, "supply out of range"),
    fault(2, "broken gauge"),
    fault(3, "busy"),
    fault(5, "hardware or stack error"),
    saturated(26, "gauge near its range"),
    saturated(27, "gauge out of range"),
    fault(28, "simulated error"),
    fault(29, "checksum of the calibration"),
    saturated(30, "force or torque out of range"),
    fault(31, "error"),
];

/// nasa-jpl/jsd, `jsd_ati_fts_parse_status_code`.
const ETHERCAT_FT: &[StatusBit] = &[
    fault(0, "monitor condition tripped"),
    fault(1, "supply out of range"),
    fault(3, "bridge voltage out of range"),
    fault(4, "bridge current out of range"),
    fault(5, "digital potentiometer"),
    fault(6, "EEPROM"),
    fault(7, "converter"),
    fault(28, "simulated error"),
    fault(29, "checksum of the calibration"),
    saturated(30, "saturated"),
    fault(31, "fault"),
];

impl Product {
    /// The bits that the product's documents name. Another bit that is set is a fault as well.
    pub const fn status_bits(self) -> &'static [StatusBit] {
        match self {
            Self::EtherCatFt => ETHERCAT_FT,
            Self::Axia80 => AXIA80,
        }
    }

    /// Whether a status word shows that the load exceeds the range of the sensor.
    pub fn saturates(self, status: u32) -> bool {
        let bits = self.status_bits().iter();
        bits.filter(|bit| bit.saturates)
            .any(|bit| status & bit.mask() != 0)
    }
}

impl StatusBit {
    /// The bit as a mask.
    pub const fn mask(&self) -> u32 {
        1 << self.bit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_bit_means_different_things() {
        let saturates = |product: Product, bit: u8| product.saturates(1_u32 << bit);
        assert!(saturates(Product::Axia80, 27) && !saturates(Product::EtherCatFt, 27));
        for product in Product::ALL {
            assert!(saturates(product, 30) && !saturates(product, 31) && !product.saturates(0));
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
