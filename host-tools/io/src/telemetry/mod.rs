//! The recorder's side of the telemetry: from datagrams to recordings.
//!
//! - [`Listener`] takes datagrams from a socket as they come,
//! - `window` puts those of a boot in order and counts those that are missing,
//! - `assembly` makes messages of them,
//! - `budget` bounds what is written and warns of a full disk,
//! - `stream` writes the cycles of a boot into recordings, `part` is one of them, and `piece` its file,
//! - [`Recorder`] keeps the streams apart. It knows no socket and no clock,
//! - [`Viewer`] shows what comes and keeps nothing,
//! - [`Pieces`] writes what did not come over a network within the same bounds.
//!
//! Nothing that was received is thrown away within the [`Bounds`]: a board that boots again, a second board,
//! and settings that change in mid-run each get a file of their own, and so does what is too long for one.

mod assembly;
mod budget;
mod listener;
mod names;
mod part;
mod piece;
mod pieces;
mod recorder;
mod stream;
mod viewer;
mod window;

pub use budget::Bounds;
pub use listener::{Listener, Received};
pub use names::sort_pieces;
pub use part::{METADATA, PartSummary};
pub use pieces::{Pieces, Time};
pub use recorder::{Progress, Recorder, Summary};
pub use viewer::{Seen, Viewer};
