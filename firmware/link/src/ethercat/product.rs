//! The products: identity, location of the calibration, and units.

use crate::can::ati::{ForceUnit, TorqueUnit};
use crate::sensor::SensorFault;

/// Vendor number of ATI Industrial Automation.
pub const ATI_VENDOR: u32 = 0x0000_0732;

/// Most counts per unit that are accepted: an Axia80 has 1,000,000 per N and per N·m. With more, a count of 32 bits would end at
/// 21 N.
pub const MAX_COUNTS_PER_UNIT: i32 = 100_000_000;

/// A sensor with an EtherCAT interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Product {
    /// The older EtherCAT F/T (net box in the sensor).
    EtherCatFt,
    /// Axia80.
    Axia80,
}

/// The object of the calibration and its entries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CalibrationObject {
    /// Index of the object.
    pub index: u16,
    /// Sub-index of the code of the force unit, `u8`.
    pub force_unit: u8,
    /// Sub-index of the code of the torque unit, `u8`.
    pub torque_unit: u8,
    /// Sub-index of the counts per unit of force, `i32`.
    pub counts_per_force: u8,
    /// Sub-index of the counts per unit of torque, `i32`.
    pub counts_per_torque: u8,
}

/// Scale that converts counts into N and N·m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Counts per N.
    pub counts_per_newton: f64,
    /// Counts per N·m.
    pub counts_per_newton_metre: f64,
}

impl Product {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::EtherCatFt, Self::Axia80];

    /// Product code of the identity (object 0x1018:2, and the SII's word 0x0A).
    pub const fn code(self) -> u32 {
        match self {
            Self::EtherCatFt => 0x2648_3052,
            Self::Axia80 => 0x2648_3053,
        }
    }

    /// The product of an identity.
    ///
    /// # Errors
    /// [`SensorFault::Vendor`], [`SensorFault::Product`]: another device is on the cable.
    pub fn identify(vendor: u32, code: u32) -> Result<Self, SensorFault> {
        if vendor != ATI_VENDOR {
            return Err(SensorFault::Vendor { received: vendor });
        }
        let known = Self::ALL.into_iter().find(|product| product.code() == code);
        known.ok_or(SensorFault::Product { received: code })
    }

    /// Location of the calibration. For the EtherCAT F/T the sub-indices follow from the layout that jsd reads by complete
    /// access: four texts and 36 numbers of the matrix come first.
    pub const fn calibration(self) -> CalibrationObject {
        match self {
            Self::EtherCatFt => CalibrationObject {
                index: 0x2040,
                force_unit: 0x29,
                torque_unit: 0x2A,
                counts_per_force: 0x31,
                counts_per_torque: 0x32,
            },
            Self::Axia80 => CalibrationObject {
                index: 0x2021,
                force_unit: 0x2F,
                torque_unit: 0x30,
                counts_per_force: 0x37,
                counts_per_torque: 0x38,
            },
        }
    }

    /// The code for lbf and lbf·in. The documents disagree on the first code: 0 in the Axia manual, 1 in jsd.
    const fn first_unit(self) -> u8 {
        match self {
            Self::EtherCatFt => 1,
            Self::Axia80 => 0,
        }
    }

    /// The code for N, and that for N·m.
    pub const fn newton_codes(self) -> (u8, u8) {
        let before = self.first_unit().wrapping_sub(1);
        (
            before.wrapping_add(ForceUnit::Newton as u8),
            before.wrapping_add(TorqueUnit::NewtonMetre as u8),
        )
    }

    /// The scale that follows from the SubDevice's set-up.
    ///
    /// # Errors
    /// A unit on which the documents do not agree, or counts per unit that no sensor has.
    pub fn scale(
        self,
        (force_unit, torque_unit): (u8, u8),
        (force, torque): (i32, i32),
    ) -> Result<Scale, SensorFault> {
        let believed = 1..=MAX_COUNTS_PER_UNIT;
        if !believed.contains(&force) || !believed.contains(&torque) {
            let (force, torque) = (force.cast_unsigned(), torque.cast_unsigned());
            return Err(SensorFault::CountsPerUnit { force, torque });
        }
        // The sixth code is kgf·m in one document and kN·m in another, gf in one and nothing in another.
        let number = |code: u8| {
            let number = code.wrapping_sub(self.first_unit()).wrapping_add(1);
            (1..=5).contains(&number).then_some(number)
        };
        let force_n = number(force_unit).and_then(|number| ForceUnit::from_code(number).ok());
        let torque_n_m = number(torque_unit).and_then(|number| TorqueUnit::from_code(number).ok());
        let force_n = force_n.ok_or(SensorFault::ForceUnit { code: force_unit })?;
        let torque_n_m = torque_n_m.ok_or(SensorFault::TorqueUnit { code: torque_unit })?;
        Ok(Scale {
            counts_per_newton: f64::from(force) / force_n.newtons(),
            counts_per_newton_metre: f64::from(torque) / torque_n_m.newton_metres(),
        })
    }
}

impl Scale {
    /// Force X, Y, Z (N) and torque X, Y, Z (N·m).
    pub fn wrench(&self, counts: [i32; 6]) -> [f64; 6] {
        let [force_x, force_y, force_z, torque_x, torque_y, torque_z] = counts.map(f64::from);
        [
            force_x / self.counts_per_newton,
            force_y / self.counts_per_newton,
            force_z / self.counts_per_newton,
            torque_x / self.counts_per_newton_metre,
            torque_y / self.counts_per_newton_metre,
            torque_z / self.counts_per_newton_metre,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn newtons_have_other_codes_in_each_product() {
        assert_eq!(Product::EtherCatFt.newton_codes(), (2, 3));
        assert_eq!(Product::Axia80.newton_codes(), (1, 2));
        for product in Product::ALL {
            let scale = product.scale(product.newton_codes(), (1_000_000, 50_000));
            let expected = Scale {
                counts_per_newton: 1e6,
                counts_per_newton_metre: 5e4,
            };
            assert_eq!(scale, Ok(expected));
        }
        let pounds = Product::Axia80
            .scale((0, 0), (1_000_000, 1_000_000))
            .unwrap();
        assert!((pounds.counts_per_newton - 224_808.94).abs() < 0.1);
        assert!((pounds.counts_per_newton_metre - 8_850_745.8).abs() < 1.0);
    }

    #[test]
    fn a_unit_on_which_documents_differ_is_refused() {
        for (product, code) in [
            (Product::EtherCatFt, 0),
            (Product::EtherCatFt, 6),
            (Product::Axia80, 5),
            (Product::Axia80, 255),
        ] {
            let (force, torque) = product.newton_codes();
            assert_eq!(
                product.scale((code, torque), (1, 1)),
                Err(SensorFault::ForceUnit { code })
            );
            assert_eq!(
                product.scale((force, code), (1, 1)),
                Err(SensorFault::TorqueUnit { code })
            );
        }
    }

    #[test]
    fn absurd_counts_per_unit_are_refused() {
        let product = Product::Axia80;
        for absurd in [0, -1, i32::MIN, MAX_COUNTS_PER_UNIT + 1] {
            for counts in [(absurd, 1_000_000), (1_000_000, absurd)] {
                let scale = product.scale(product.newton_codes(), counts);
                assert!(matches!(scale, Err(SensorFault::CountsPerUnit { .. })));
            }
        }
    }

    #[test]
    fn a_foreign_identity_is_named() {
        assert_eq!(
            Product::identify(2, Product::Axia80.code()),
            Err(SensorFault::Vendor { received: 2 })
        );
        assert_eq!(
            Product::identify(ATI_VENDOR, 7),
            Err(SensorFault::Product { received: 7 })
        );
        for product in Product::ALL {
            assert_eq!(Product::identify(ATI_VENDOR, product.code()), Ok(product));
        }
    }
}
