//! A board that is there, commanded over its service and recorded by its telemetry.
//!
//! - [`LiveBoard`] asks the board for its settings and gives it commands,
//! - [`LiveRecorder`] records what it sends.

mod board;
mod recorder;

pub use board::LiveBoard;
pub use recorder::LiveRecorder;
