//! Force/torque sensors of ATI on EtherCAT: Axia80 and the older EtherCAT F/T.
//!
//! [`AtiSubDevice`] is a [`SensorDriver`](crate::sensor::SensorDriver) whose frames are either the set-up of the SubDevice or the
//! process data of one exchange. The board handles datagrams, mailboxes and states of the bus (`softdock_app::ethercat`); their
//! meaning is decided here.
//!
//! Sources: SCHUNK/ATI manual 9610-05-EtherCAT Axia-09 (Axia80); nasa-jpl/jsd, `src/jsd_ati_fts.c` (EtherCAT F/T).
//! None of this was verified with a sensor.
//!
//! | file | |
//! |---|---|
//! | `product` | identities, objects of the calibration, units |
//! | `status` | what the status bits mean, per product |
//! | `process_data` | what is exchanged: counts, status, sample counter; bias, filter |
//! | `exchange` | what travels between the bus and the driver |
//! | `in_flight` | which frames of the segment are ours |
//! | `driver` | which exchange gives a reading; when to start the SubDevice anew |

mod driver;
mod exchange;
mod in_flight;
mod process_data;
mod product;
mod status;

pub use driver::{AtiSubDevice, EtherCatConfig};
pub use exchange::{Exchange, Setup, StartUp};
pub use in_flight::{ETHERTYPE, InFlight};
pub use process_data::{Control, INPUT_BYTES, Inputs, OUTPUT_BYTES};
pub use product::{ATI_VENDOR, CalibrationObject, MAX_COUNTS_PER_UNIT, Product, Scale};
pub use status::StatusBit;

/// Working counter of one LRW that one SubDevice has read (1) and written (2): ETG.1000.4, 5.4.1.
pub const WORKING_COUNTER: u16 = 3;
