//! Words that several sections share.

use softdock_analysis::diagnose::Diagnosis;
use softdock_physics::model::{Axis, Channel};

/// Name of a channel in running text: `executed velocity`.
pub(super) fn channel(channel: Channel) -> String {
    channel.name().replace('_', " ")
}

/// An axis of a channel, as `wrench ry`.
pub(super) fn signal(channel: Channel, axis: Axis) -> String {
    format!("{} {axis}", self::channel(channel))
}

/// Name of the data on which the effects were judged besides the data of the fit.
pub(super) fn unseen(diagnosis: &Diagnosis) -> &'static str {
    match (diagnosis.unseen, diagnosis.of_all_logs.is_some()) {
        _ if diagnosis.in_sample => "the data of the fit",
        (true, true) => "the data of the test",
        (true, false) => "unseen data",
        (false, true) => "the end of the log",
        (false, false) => "the end of the log, held back from the fit",
    }
}

/// A hypothesis: `reversal_pause + guide_friction`.
pub(super) fn hypothesis(effects: &[String]) -> String {
    effects.join(" + ")
}

/// `1 parameter`, `2 parameters`.
pub(super) fn count(number: usize, one: &str) -> String {
    if number == 1 {
        format!("1 {one}")
    } else {
        format!("{number} {one}s")
    }
}
