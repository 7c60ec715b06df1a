//! Is everything ready for a test? One line for each thing that could be wrong, with what to do.
//!
//! - `recording` looks at the file and at the firmware that made it,
//! - `robot` at the robot's link,
//! - `sensor` at the sensor's samples,
//! - `settings` at the settings of a board,
//! - `live` at a board that answers,
//! - `self_test` has a new board show what it can do.

mod live;
mod recording;
mod robot;
mod self_test;
mod sensor;
mod settings;

pub use self_test::{Onlooker, self_test};

use serde::Serialize;
use softdock_app::settings::BoardSettings;
use softdock_io::recording::Recording;
use softdock_report::{Cell, Column, Mark, Table};

/// How a check ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// As it should be.
    Good,
    /// A test may run, but should be looked at.
    Warning,
    /// No test should run.
    Bad,
}

/// Result of one check.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Check {
    /// What was looked at.
    pub name: &'static str,
    /// How it is.
    pub state: State,
    /// What was found, and what to do if it is not good.
    pub message: String,
}

impl Check {
    fn new(name: &'static str, state: State, message: impl Into<String>) -> Self {
        Self {
            name,
            state,
            message: message.into(),
        }
    }

    fn good(name: &'static str, message: impl Into<String>) -> Self {
        Self::new(name, State::Good, message)
    }

    fn warning(name: &'static str, message: impl Into<String>) -> Self {
        Self::new(name, State::Warning, message)
    }

    fn bad(name: &'static str, message: impl Into<String>) -> Self {
        Self::new(name, State::Bad, message)
    }
}

/// Checks a recording, with the settings in it.
pub fn of_recording(recording: &Recording) -> Vec<Check> {
    let mut checks = recording::checks(recording);
    let settings = recording.header.control_settings().ok();
    checks.extend(robot::checks(recording, settings.as_ref()));
    checks.extend(sensor::checks(recording, settings.as_ref()));
    checks
}

/// Checks settings alone.
pub fn of_settings(board: &BoardSettings) -> Vec<Check> {
    let mut checks = settings::checks(board);
    checks.push(settings::recorder(&board.network.recorder));
    checks
}

/// Checks the board on a port (as [`Port::open`] takes it) and the settings that it runs with; these
/// come with the checks if the board tells them in a form that this program knows. A board that does
/// not answer is a bad check. `progress` is told the share that is done.
///
/// [`Port::open`]: softdock_io::port::Port::open
pub fn of_port(
    name: &str,
    baud_rate: u32,
    progress: impl FnMut(f64),
) -> (Vec<Check>, Option<BoardSettings>) {
    live::of_port(name, baud_rate, progress)
}

/// Whether a board runs with these settings.
pub fn runs_with(running: &BoardSettings, board: &BoardSettings) -> Check {
    let name = "running settings";
    match running == board {
        true => Check::good(name, "the board runs with the settings of the file"),
        false => Check::warning(
            name,
            "the board runs with other settings than those of the file; `softdock params diff` shows them, \
             `softdock params upload` makes them the board's",
        ),
    }
}

/// Whether a recording was made with these settings.
pub fn same_settings(recording: &Recording, board: &BoardSettings) -> Check {
    recording::same_settings(recording, board)
}

/// The worst state.
pub fn worst(checks: &[Check]) -> State {
    let any = |state: State| checks.iter().any(|c| c.state == state);
    if any(State::Bad) {
        State::Bad
    } else if any(State::Warning) {
        State::Warning
    } else {
        State::Good
    }
}

/// The checks as a table.
pub fn table(checks: &[Check]) -> Table {
    let mut table = Table::new(vec![
        Column::text("Check"),
        Column::text("State"),
        Column::text("Found"),
    ]);
    for check in checks {
        let (mark, word) = match check.state {
            State::Good => (Mark::Good, "good"),
            State::Warning => (Mark::Neutral, "warning"),
            State::Bad => (Mark::Bad, "bad"),
        };
        table.push(vec![
            Cell::text(check.name),
            Cell::text(word).marked(mark),
            Cell::text(&check.message),
        ]);
    }
    table
}
