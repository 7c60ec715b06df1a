//! The objects of a SubDevice (ETG.1000.6, 5.6.7; the sensor's: 0x2000 on).

use super::description::Description;
use softdock_link::ethercat::Product;
use std::collections::BTreeMap;

/// Abort codes (ETG.1000.6, table 41).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Abort {
    Unsupported = 0x0601_0000,
    ReadOnly = 0x0601_0002,
    NoObject = 0x0602_0000,
    Length = 0x0607_0010,
    NoSubIndex = 0x0609_0011,
}

/// The sensor's control words, the only objects that can be written.
const CONTROL: u16 = 0x7010;

/// Objects by index and sub-index.
#[derive(Clone, Debug)]
pub(super) struct Dictionary(BTreeMap<(u16, u8), Vec<u8>>);

impl Dictionary {
    pub(super) fn new(about: &Description) -> Self {
        let mut objects = Self(BTreeMap::new());
        objects.set(0x1000, 0, &0_u32.to_le_bytes());
        objects.set(0x1008, 0, about.name.as_bytes());
        objects.array(
            0x1018,
            &[about.vendor, about.product, about.revision, about.serial],
        );
        objects.bytes(0x1C00, &[1, 2, 3, 4]);
        objects.array(0x1601, &about.outputs);
        objects.array(0x1A00, &about.inputs);
        objects.bytes(0x1C10, &[]);
        objects.bytes(0x1C11, &[]);
        objects.assign(0x1C12, 0x1601);
        objects.assign(0x1C13, 0x1A00);
        objects.array(CONTROL, &[0, 0]);
        objects.version(0x2090, [1, 0, 0]);
        for product in Product::ALL {
            if product.code() == about.product {
                objects.calibration(product, about);
            }
        }
        objects
    }

    fn set(&mut self, index: u16, sub_index: u8, value: &[u8]) {
        self.0.insert((index, sub_index), value.to_vec());
    }

    fn array(&mut self, index: u16, values: &[u32]) {
        self.set(index, 0, &[values.len() as u8]);
        for (n, value) in (1..).zip(values) {
            self.set(index, n, &value.to_le_bytes());
        }
    }

    fn bytes(&mut self, index: u16, values: &[u8]) {
        self.set(index, 0, &[values.len() as u8]);
        for (n, value) in (1..).zip(values) {
            self.set(index, n, &[*value]);
        }
    }

    fn assign(&mut self, index: u16, pdo: u16) {
        self.set(index, 0, &[1]);
        self.set(index, 1, &pdo.to_le_bytes());
    }

    fn version(&mut self, index: u16, [major, minor, revision]: [u16; 3]) {
        self.set(index, 0, &[3]);
        for (n, value) in (1..).zip([major, minor, revision]) {
            self.set(index, n, &value.to_le_bytes());
        }
    }

    fn calibration(&mut self, product: Product, about: &Description) {
        let object = product.calibration();
        let (force_unit, torque_unit) = about.units;
        let (force, torque) = about.counts_per_unit;
        self.set(object.index, 0, &[object.counts_per_torque]);
        self.set(object.index, 1, b"FT00000\0");
        self.set(object.index, object.force_unit, &[force_unit]);
        self.set(object.index, object.torque_unit, &[torque_unit]);
        self.set(object.index, object.counts_per_force, &force.to_le_bytes());
        self.set(
            object.index,
            object.counts_per_torque,
            &torque.to_le_bytes(),
        );
    }

    /// Removes an object.
    pub(super) fn remove(&mut self, index: u16) {
        self.0.retain(|(known, _), _| *known != index);
    }

    /// The value of an object.
    pub(super) fn read(&self, index: u16, sub_index: u8) -> Result<&[u8], Abort> {
        let found = self.0.get(&(index, sub_index));
        found.map(Vec::as_slice).ok_or_else(|| self.missing(index))
    }

    /// Changes an object.
    pub(super) fn write(&mut self, index: u16, sub_index: u8, value: &[u8]) -> Result<(), Abort> {
        let missing = self.missing(index);
        let place = self.0.get_mut(&(index, sub_index)).ok_or(missing)?;
        if index != CONTROL || sub_index == 0 {
            return Err(Abort::ReadOnly);
        }
        if value.len() != place.len() {
            return Err(Abort::Length);
        }
        place.copy_from_slice(value);
        Ok(())
    }

    fn missing(&self, index: u16) -> Abort {
        match self.0.keys().any(|(known, _)| *known == index) {
            true => Abort::NoSubIndex,
            false => Abort::NoObject,
        }
    }
}
