//! The file, and the firmware that made it.

use super::Check;
use softdock_app::settings::BoardSettings;
use softdock_control::io::Sequence;
use softdock_io::identity;
use softdock_io::recording::Recording;

pub(super) fn checks(recording: &Recording) -> Vec<Check> {
    vec![
        whole(recording),
        holes(recording),
        firmware(recording),
        settings(recording),
        faults(recording),
    ]
}

fn whole(recording: &Recording) -> Check {
    let (name, count) = ("recording", recording.cycles.len());
    match (&recording.cut, count) {
        (_, 0) => Check::bad(name, "it holds no cycle; record again"),
        (Some(cut), _) => Check::warning(name, format!("{cut}; {count} cycles are whole")),
        (None, _) => Check::good(name, format!("{count} cycles, whole")),
    }
}

/// Cycles that the board ran and the file does not have: the network lost them.
fn holes(recording: &Recording) -> Check {
    let name = "host recorder";
    let numbers = recording.cycles.windows(2).filter(|pair| {
        let follows = pair[1].trace.cycle == pair[0].trace.cycle.wrapping_add(1);
        !follows && pair[1].inputs.robot.sequence != Sequence::NewRun
    });
    match numbers.count() {
        0 => Check::good(name, "no cycle is missing"),
        n => Check::warning(
            name,
            format!(
                "cycles are missing in {n} places; record on a wired network without other traffic"
            ),
        ),
    }
}

fn firmware(recording: &Recording) -> Check {
    let (name, made_by) = ("firmware", &recording.header.identity);
    if made_by.is_empty() {
        Check::warning(name, "the recording does not say which firmware made it")
    } else if made_by.starts_with("imported from") {
        Check::warning(name, format!("{made_by}: nothing is known of a firmware"))
    } else {
        made_by_firmware(made_by)
    }
}

/// A firmware by its version and git state; the board may be named behind them.
pub(super) fn made_by_firmware(made_by: &str) -> Check {
    let (name, own) = ("firmware", identity::text());
    if made_by.contains("dirty") {
        Check::warning(
            name,
            format!("{made_by}: built from changed sources, which nobody can build again"),
        )
    } else if made_by.starts_with(&own) {
        Check::good(name, made_by)
    } else {
        Check::warning(
            name,
            format!("{made_by}, and this program is {own}: flash the board with the same version"),
        )
    }
}

fn settings(recording: &Recording) -> Check {
    let name = "recorded settings";
    if recording.header.settings_toml.trim().is_empty() {
        return Check::warning(name, "the recording holds no settings");
    }
    match recording.header.control_settings() {
        Err(error) => Check::bad(
            name,
            format!("this program does not know them: {error:#}; use the version of the firmware"),
        ),
        Ok(settings) => match settings.validate() {
            Ok(()) => Check::good(name, "complete and in their ranges"),
            Err(error) => Check::bad(name, error.to_string()),
        },
    }
}

fn faults(recording: &Recording) -> Check {
    let name = "faults";
    let last = recording.cycles.iter().rev().find_map(|c| c.trace.fault);
    match last {
        None => Check::good(name, "none was latched"),
        Some(fault) => Check::bad(
            name,
            format!(
                "one was latched: {}: expected {}, received {}",
                fault.code, fault.expected, fault.received
            ),
        ),
    }
}

pub(super) fn same_settings(recording: &Recording, board: &BoardSettings) -> Check {
    let name = "uploaded settings";
    match recording.header.control_settings() {
        Err(_) => Check::warning(name, "the recording holds no settings to compare with"),
        Ok(control) if control == board.control => {
            Check::good(name, "the board ran with the settings of the file")
        }
        Ok(_) => Check::warning(
            name,
            "the board ran with other settings than those of the file; upload it",
        ),
    }
}
