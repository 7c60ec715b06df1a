//! The board itself.

use super::super::{Check, recording};
use super::Answers;
use crate::parameters::words;
use softdock_app::image::schema;
use softdock_control::modes::FaultCode;
use softdock_io::identity;
use softdock_link::service::{FlashSlot, Origin, PROTOCOL};

/// Words in a line of the log that indicate trouble.
const TROUBLE: [&str; 7] = [
    "fault",
    "refused",
    "DEFAULT",
    "Failed",
    "Resynchronising",
    "started over after",
    "robot silent",
];
/// Lines of trouble that are shown.
const SHOWN: usize = 3;

pub(super) fn checks(port: &str, answers: &Answers) -> Vec<Check> {
    let uptime_s = answers.status.uptime_ms / 1000;
    vec![
        Check::good("board", format!("on {port}, up for {uptime_s} s")),
        recording::made_by_firmware(&answers.identity.text),
        protocol(answers),
        line(answers),
        origin(answers),
        mode(answers),
        fault(answers),
    ]
}

fn protocol(answers: &Answers) -> Check {
    let (name, board, own) = ("protocol", answers.identity.schema, schema());
    // A board that speaks another version of the protocol was not asked further.
    if answers.settings.is_none() {
        return Check::warning(
            name,
            format!(
                "the board's settings have the form {board:08x}, those of this program {own:08x}, so they \
                 were not checked: use the softdock of the same version as the firmware"
            ),
        );
    }
    if answers.health.is_none() || answers.slots.is_none() {
        return Check::warning(
            name,
            "the firmware is too old to tell how robot, sensor and flash are: flash a newer one",
        );
    }
    Check::good(name, format!("version {PROTOCOL}, settings {own:08x}"))
}

fn line(answers: &Answers) -> Check {
    let (name, counters) = ("serial line", &answers.counters[1]);
    let words = format!(
        "{} frames, {} damaged",
        counters.frames, counters.damaged_frames
    );
    match counters.damaged_frames {
        0 => Check::good(name, words),
        _ => Check::warning(name, format!("{words} since boot; look at the cable")),
    }
}

fn origin(answers: &Answers) -> Check {
    let name = "origin of settings";
    match &answers.status.origin {
        Origin::Flash { sequence } if identity::is_without_flash(&answers.identity.text) => {
            Check::good(name, format!("set {sequence}, in memory"))
        }
        Origin::Flash { sequence } => Check::good(name, format!("set {sequence} from flash")),
        Origin::Trial { sequence, left_s } => Check::warning(
            name,
            format!(
                "set {sequence} is on trial for another {left_s} s, then the board goes back to those before \
                 (`softdock params upload` confirms by itself; `softdock params rollback` ends it now)"
            ),
        ),
        Origin::Defaults { reason } => Check::bad(
            name,
            format!(
                "the firmware's defaults, with which the board cannot be armed: {reason}; `softdock params \
                 upload BOARD.toml`"
            ),
        ),
    }
}

fn mode(answers: &Answers) -> Check {
    let (name, status) = ("mode", &answers.status);
    if status.moves {
        return Check::warning(
            name,
            format!(
                "{}: the robot moves or may begin to; `softdock params mode hold` or `stop`",
                status.mode
            ),
        );
    }
    if status.draft {
        return Check::warning(
            name,
            format!(
                "{}, and somebody's change of the settings was not finished: upload it again",
                status.mode
            ),
        );
    }
    Check::good(name, status.mode.as_str())
}

fn fault(answers: &Answers) -> Check {
    let name = "faults";
    match &answers.status.fault {
        None => Check::good(name, "none is latched"),
        Some((word, expected, received)) => Check::bad(
            name,
            format!(
                "one is latched: {}: expected {expected}, received {received}; remove its cause, then \
                 `softdock params mode reset`",
                words::<FaultCode>(word)
            ),
        ),
    }
}

pub(super) fn flash(answers: &Answers) -> Check {
    let name = "flash";
    let Some(slots) = &answers.slots else {
        return Check::warning(name, "the firmware does not tell what is in its slots");
    };
    if identity::is_without_flash(&answers.identity.text) {
        return Check::good(
            name,
            "none: changed settings end with the board; `softdock board --flash FILE` keeps them",
        );
    }
    let words: Vec<String> = ["A", "B"].iter().zip(slots).map(slot).collect();
    let words = words.join(", ");
    let kept = |slot: &FlashSlot| matches!(slot, FlashSlot::Kept { .. });
    let damaged = |slot: &FlashSlot| matches!(slot, FlashSlot::Unusable { .. });
    if slots.iter().any(damaged) {
        return Check::warning(
            name,
            format!("{words}; the next upload writes over a slot that is not in use"),
        );
    }
    match slots.iter().any(kept) {
        true => Check::good(name, words),
        false => Check::warning(
            name,
            format!(
                "{words}: nothing outlives a loss of power; `softdock params upload BOARD.toml`"
            ),
        ),
    }
}

fn slot((name, slot): (&&str, &FlashSlot)) -> String {
    match slot {
        FlashSlot::Empty => format!("slot {name} is free"),
        FlashSlot::Kept { sequence } => format!("slot {name} holds set {sequence}"),
        FlashSlot::NotConfirmed => format!("slot {name} holds a set that is not confirmed"),
        FlashSlot::Unusable { reason } => format!("slot {name} cannot be used: {reason}"),
    }
}

pub(super) fn log(answers: &Answers) -> Check {
    let name = "log";
    let tells = |text: &str| TROUBLE.iter().any(|word| text.contains(word));
    let trouble: Vec<String> = answers
        .log
        .iter()
        .filter(|line| tells(&line.text))
        .map(|line| format!("{:.3} s: {}", line.at_ms as f64 * 1e-3, line.text))
        .collect();
    let lines = answers.log.len();
    if trouble.is_empty() {
        return Check::good(name, format!("nothing wrong in its last {lines} lines"));
    }
    let last = &trouble[trouble.len().saturating_sub(SHOWN)..];
    Check::warning(
        name,
        format!(
            "{} of its last {lines} lines tell of trouble (`softdock params status` shows all): {}",
            trouble.len(),
            last.join("; ")
        ),
    )
}
