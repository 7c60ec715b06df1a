//! The recorder's side of the telemetry: from datagrams to recordings.
//!
//! - [`Listener`] takes datagrams from a socket as they come,
//! - `window` puts the datagrams of a boot in order and counts missing ones,
//! - `assembly` assembles them to messages,
//! - `budget` limits what is written and warns of a full disk,
//! - `stream` writes the cycles of a boot into recordings; `stream_file` is one of them, `recording_file` its file,
//! - [`Recorder`] keeps the streams apart and uses neither socket nor clock,
//! - [`Viewer`] passes on what comes without recording it,
//! - [`FileSeries`] writes cycles that did not come over a network, within the same limits.
//!
//! Within the [`Bounds`] no received data is dropped: a board that boots again, a second board, and settings that change in
//! mid-run each get a separate file, and a recording that is too long for one file goes on in another.

mod assembly;
mod budget;
mod file_series;
mod listener;
mod names;
mod recorder;
mod recording_file;
mod stream;
mod stream_file;
mod viewer;
mod window;

pub use budget::Bounds;
pub use file_series::{FileSeries, Time};
pub use listener::{Listener, Received};
pub use names::sort_series;
pub use recorder::{Progress, Recorder, Summary};
pub use stream_file::{FileSummary, METADATA};
pub use viewer::{BoardMessage, Viewer};
