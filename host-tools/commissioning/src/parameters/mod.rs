//! Commissioning: the host's side of the parameter service.
//!
//! | file | |
//! |---|---|
//! | `client` | requests and answers on a line that may lose and change bytes |
//! | `setting` | settings as a board lists them |
//! | `file` | settings as TOML, with their descriptions, and back |
//! | `change` | new settings for a board: all of them or none |
//! | `operate` | an operator's commands |
//! | `words` | what a board tells by name, in words |
//!
//! The only knowledge of the settings is what the board reports, so that boards with an older or newer firmware are served as
//! well.

mod change;
mod client;
mod file;
mod operate;
mod setting;
mod words;

pub use change::{Difference, differences};
pub use client::{Client, Identity, LinkError};
pub use file::{parse, read, write};
pub use setting::{OwnedValue, Setting, missing};
pub use words::words;
