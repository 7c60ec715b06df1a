//! KUKA Robot Sensor Interface: the XML telegrams that robot and controller exchange over UDP.
//!
//! The robot sends one `<Rob>` per sensor cycle and rejects every answer that does not carry the same `IPOC` or that
//! arrives after the next interpolation. Which elements a telegram has, and what they are called, follows the Ethernet
//! configuration file on the robot controller; only `IPOC` is always there. [`Tags`] holds the names.
//!
//! Units on this interface are millimetres and degrees (KUKA's X, Y, Z, A, B, C; A about Z, then B about Y, then C
//! about X).
//!
//! Sources: the configuration examples and drivers in `ros-industrial/kuka_experimental`, `kroshu/kuka_drivers`,
//! `fzi-forschungszentrum-informatik/kuka_rsi_driver`, and the documentation of `RSIPI`.
//!
//! | file | |
//! |---|---|
//! | `tags` | configurable element names |
//! | `telegram` | what the two telegrams carry |
//! | `scan` | XML into events, without allocation |
//! | `fields` | element content into numbers |
//! | `rob`, `sen` | reading and writing the robot's telegram and our answer |
//! | `correction` | what was meant into digits of the wire, without drift |
//! | `sequence` | what the next `IPOC` says about loss and restarts |

mod correction;
mod error;
mod fields;
mod rob;
mod scan;
mod sen;
mod sequence;
mod tags;
mod telegram;
mod writer;

pub use correction::{Corrections, Counts};
pub use error::{Field, RsiError};
pub use rob::{parse_rob, salvage_ipoc, write_rob};
pub use sen::{SEN_MAX_BYTES, parse_sen, write_sen, write_sen_with_message};
pub use sequence::{Sequence, SequenceTracker};
pub use tags::{Name, TagError, Tags};
pub use telegram::{RobTelegram, SenTelegram, poscorr_clamps};

/// Largest |B| up to which the robot is turned, rad (80°): near 90° A and C are not defined, and a small rotation takes
/// a large step of both.
pub const LARGEST_B_RAD: f64 = 1.4;
