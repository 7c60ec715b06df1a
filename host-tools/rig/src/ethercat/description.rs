//! What a SubDevice says about itself.

use softdock_link::ethercat::{ATI_VENDOR, Product};

/// What a SubDevice says about itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Description {
    /// Name.
    pub name: &'static str,
    /// Vendor number.
    pub vendor: u32,
    /// Product code.
    pub product: u32,
    /// Revision.
    pub revision: u32,
    /// Serial number.
    pub serial: u32,
    /// Mapping of the TxPDO: index, sub-index and bits of each entry.
    pub inputs: Vec<u32>,
    /// Mapping of the RxPDO.
    pub outputs: Vec<u32>,
    /// Codes of the units of force and torque.
    pub units: (u8, u8),
    /// Counts per unit of force and torque.
    pub counts_per_unit: (i32, i32),
}

impl Description {
    /// A sensor in N and N·m with 1,000,000 counts per unit.
    pub fn of(product: Product) -> Self {
        let force = (1..=6).map(|sub_index| 0x6000_0020 | sub_index << 8);
        Self {
            name: match product {
                Product::EtherCatFt => "ATI EtherCAT F/T",
                Product::Axia80 => "ATI Axia F/T Sensor",
            },
            vendor: ATI_VENDOR,
            product: product.code(),
            revision: 0x0001_0111,
            serial: 1,
            inputs: force.chain([0x6010_0020, 0x6020_0020]).collect(),
            outputs: vec![0x7010_0120, 0x7010_0220],
            units: product.newton_codes(),
            counts_per_unit: (1_000_000, 1_000_000),
        }
    }
}
