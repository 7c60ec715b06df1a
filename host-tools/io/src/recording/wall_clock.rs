//! What time it was. A recording's own clock begins when the board boots; a metadata record says which instant of the
//! world one of its cycles was, as far as the computer knows that records it, and the messages carry that time for viewers.
//! (A run in virtual time has no such instant.)

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

/// Which instant of the world a cycle was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WallClock {
    /// The instant, s since 1970, UTC.
    pub unix_s: f64,
    /// Time of the cycle, s.
    pub at_time_s: f64,
}

impl WallClock {
    /// The instant of the cycle of another time, ns since 1970; none before that. The clock is taken to the microsecond:
    /// in seconds, f64 has no more digits, and cycles would lie unequally far apart.
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

    /// From a metadata record; none if it holds no such instant.
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
        self.note_clock(WallClock {
            unix_s: unix.as_secs_f64(),
            at_time_s: time_s,
        })
    }
}
