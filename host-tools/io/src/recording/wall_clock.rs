//! Wall clock of a recording. Its own clock begins when the board boots. A metadata record gives the time of day of one
//! cycle, as far as the recording computer knows it, and the messages carry that time for viewers. (A run in virtual time has
//! none.)

use super::RecordingWriter;
use super::file_format::NS_PER_S;
use mcap::records::Metadata;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::Write;
use std::time::{SystemTime, UNIX_EPOCH};

/// Name of the metadata record.
pub const WALL_CLOCK: &str = "softdock.wall_clock";

const UNIX_S: &str = "unix_s";
const AT_TIME_S: &str = "at_time_s";

/// Assignment of a time of day to a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WallClock {
    /// The instant, s since 1970, UTC.
    pub unix_s: f64,
    /// Time of the cycle, s.
    pub at_time_s: f64,
}

impl WallClock {
    /// Time of day of the cycle at `time_s`, ns since 1970; None before 1970. The clock is rounded to microseconds: an f64 in
    /// seconds has no more digits, and cycles would be unequally spaced.
    pub fn unix_ns(&self, time_s: f64) -> Option<u64> {
        let clock = ((self.unix_s * 1e6).round() as i64).checked_mul(1000)?;
        let since = ((time_s - self.at_time_s) * NS_PER_S).round() as i64;
        u64::try_from(clock.checked_add(since)?).ok()
    }

    pub(super) fn metadata(&self) -> Metadata {
        let entries = [
            (UNIX_S, format!("{:.6}", self.unix_s)),
            (AT_TIME_S, format!("{:?}", self.at_time_s)),
        ];
        let entry = |(name, text): (&str, String)| (name.to_owned(), text);
        Metadata {
            name: WALL_CLOCK.to_owned(),
            metadata: entries.map(entry).into(),
        }
    }

    /// Reads a metadata record; None if an entry is missing or no finite number.
    pub(super) fn from_entries(entries: &BTreeMap<String, String>) -> Option<Self> {
        let number = |name| {
            let number: f64 = entries.get(name)?.parse().ok()?;
            number.is_finite().then_some(number)
        };
        Some(Self {
            unix_s: number(UNIX_S)?,
            at_time_s: number(AT_TIME_S)?,
        })
    }
}

impl<W: Write> RecordingWriter<W> {
    /// Notes that the time of day of the cycle at `time_s` is `now`: that of any other cycle is `unix_s + (its time −
    /// at_time_s)`. To be called before the first cycle is pushed.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn note_wall_clock(&mut self, time_s: f64, now: SystemTime) -> anyhow::Result<()> {
        // A clock before 1970 was never set.
        let Ok(unix) = now.duration_since(UNIX_EPOCH) else {
            return Ok(());
        };
        self.note_clock(WallClock {
            unix_s: unix.as_secs_f64(),
            at_time_s: time_s,
        })
    }
}
