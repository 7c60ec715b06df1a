//! Notes on a recording beside the numbers.

use super::contact::Contacts;
use softdock_io::recording::Recording;
use softdock_physics::model::prediction::signals::{Signals, Step};

/// Notes on what is special about the recording.
pub(super) fn of_recording(
    recording: &Recording,
    signals: &Signals<'_>,
    contacts: &Contacts,
) -> Vec<String> {
    let mut notes = Vec::new();
    let end_s = signals.cycles.last().map_or(0.0, |c| c.trace.time_s);
    if let Some(why) = &recording.cut {
        notes.push(format!(
            "The recording was cut off ({why}); what is here, up to {end_s:.3} s, is compared."
        ));
    }
    notes.extend(recording.rounding());
    let holes = signals
        .steps
        .iter()
        .skip(1)
        .filter(|s| **s == Step::Hole)
        .count();
    if holes > 0 {
        notes.push(format!(
            "Cycles are missing in {holes} place(s); nothing is predicted there until the past \
             no longer counts."
        ));
    }
    if contacts.looked_for && contacts.list.is_empty() {
        let (threshold_n, peak_n) = (contacts.threshold_n, contacts.peak_n);
        notes.push(format!(
            "No contact was found: the force stays at or below {peak_n:.3} N, and a contact begins \
             at {threshold_n:.3} N, which is well above its noise."
        ));
    }
    notes
}
