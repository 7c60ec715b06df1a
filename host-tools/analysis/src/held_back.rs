//! Parts of a recording.

use softdock_io::recording::Recording;
use std::ops::Range;

/// Share of a log that is held back where no unseen log is given.
const HELD_BACK: f64 = 0.4;

/// The beginning of a recording to fit on, and its end to judge on.
pub(crate) fn held_back(recording: &Recording) -> (Recording, Recording) {
    let count = recording.cycles.len();
    let at = count - (count as f64 * HELD_BACK) as usize;
    (part(recording, 0..at), part(recording, at..count))
}

/// Some of its rows.
pub(crate) fn part(recording: &Recording, range: Range<usize>) -> Recording {
    Recording {
        header: recording.header.clone(),
        cycles: recording.cycles[range].to_vec(),
        cut: recording.cut.clone(),
        ..Recording::default()
    }
}
