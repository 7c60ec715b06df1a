//! A simulated EtherCAT sensor: an ATI Axia80 or EtherCAT F/T as its documents describe it, from the frame on the cable
//! to the counts, with everything that may go wrong.
//!
//! | file | |
//! |---|---|
//! | `datagram` | the datagrams of a frame |
//! | `segment` | SubDevices on a cable; what happens to frames |
//! | `controller` | registers, memory, FMMUs and SyncManagers of a SubDevice |
//! | `states` | state machine of a SubDevice |
//! | `sii` | its EEPROM |
//! | `mailbox` | its mailbox: SDOs of CoE |
//! | `dictionary` | its objects |
//! | `sensor` | what it measures |
//! | `subdevice` | all of it together |
//! | `wire` | frames in datagrams of UDP, in real time |
//!
//! Sources: ETG.1000.4 (data link), ETG.1000.6 (application layer), ETG.2010 (SII); for the sensor those of
//! `softdock_link::ethercat`. It is made after documents: its agreement with a real sensor is not known.

mod controller;
mod datagram;
mod description;
mod dictionary;
mod mailbox;
mod segment;
mod sensor;
mod sii;
mod states;
mod subdevice;
pub mod wire;

pub use description::Description;
pub use segment::{Cable, Segment};
pub use sensor::Measurement;
pub use states::AlState;
pub use subdevice::SubDevice;
