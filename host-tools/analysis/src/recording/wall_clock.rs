//! What time it was. A recording's own clock begins when the board boots; a metadata record says which instant of the
//! world one of its cycles was, as far as the computer knows that records it. (A run in virtual time has no such instant.)

use super::RecordingWriter;
use std::collections::BTreeMap;
use std::io::Write;
use std::time::{SystemTime, UNIX_EPOCH};

/// Name of the metadata record.
pub const WALL_CLOCK: &str = "softdock.wall_clock";

impl<W: Write> RecordingWriter<W> {
    /// Notes that the cycle of this time came `now`: the instant of any other is
    /// `unix_s + (its time − at_time_s)`. To be called before the first cycle is pushed.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn note_wall_clock(&mut self, time_s: f64, now: SystemTime) -> anyhow::Result<()> {
        // A clock before 1970 is one that nobody has set.
        let Ok(unix) = now.duration_since(UNIX_EPOCH) else {
            return Ok(());
        };
        let entries = [
            ("unix_s", format!("{:.6}", unix.as_secs_f64())),
            ("at_time_s", format!("{time_s:?}")),
        ];
        let entries = entries.map(|(name, text)| (name.to_owned(), text));
        self.note(WALL_CLOCK, BTreeMap::from(entries))
    }
}
