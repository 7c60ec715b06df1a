//! Commissioning: the host's side of the parameter service.
//!
//! | file | |
//! |---|---|
//! | `port` | a serial device, a pseudo-terminal or a TCP port, locked for this program |
//! | `lock` | one program at a time, where the system does not see to it |
//! | `client` | requests and answers on a line that may lose and change bytes |
//! | `setting` | settings as a board lists them |
//! | `file` | settings as TOML, with their descriptions, and back |
//! | `change` | new settings for a board: all of them or none |
//! | `operate` | an operator's commands |
//!
//! All that is known of the settings is what the board tells, so a board with an older or newer
//! firmware is served as well.

mod change;
mod client;
mod file;
mod lock;
mod operate;
mod port;
mod setting;

pub use change::{Difference, differences};
pub use client::{Client, Identity, LinkError};
pub use file::{parse, read, write};
pub use port::{BAUD_RATE, Found, Port, found, only_board};
pub use setting::{OwnedValue, Setting, missing};
