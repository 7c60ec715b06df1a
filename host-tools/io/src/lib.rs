//! What the programs of the host read and write.
//!
//! | module | |
//! |---|---|
//! | `recording`, `telemetry`, `replay` | cycles on disk and over the network, recomputed bit for bit |
//! | `data_table` | tables that other programs read: CSV and Parquet |
//! | `input`, `output` | files that people write, files that are there whole or not at all |
//! | `standard_error` | what is said beside a result |
//! | `address` | addresses as people write them |
//! | `port` | a serial device, a pseudo-terminal or a TCP port, locked for this program |
//! | `identity` | who wrote it |
//! | `shell` | words of commands that a person copies |

pub mod address;
pub mod data_table;
pub mod identity;
pub mod input;
pub mod output;
pub mod port;
pub mod recording;
pub mod replay;
pub mod shell;
mod standard_error;
pub mod telemetry;

pub use standard_error::to_standard_error;
