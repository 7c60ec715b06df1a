//! A bar on standard error while something runs; nothing where nobody watches.

use indicatif::{ProgressBar, ProgressStyle};
use softdock_io::say;
use std::time::Duration;

/// Resolution of the bar.
const STEPS: f64 = 1000.0;

/// A line that changes, for what has no known end.
pub(super) fn spinner() -> ProgressBar {
    let bar = ProgressBar::new_spinner();
    // The template is constant; should it be refused, the plain one does as well.
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}") {
        bar.set_style(style);
    }
    bar
}

/// A bar up to a number that is known, with what is done and the time that is left.
pub(super) fn counter(length: u64, what: &str) -> ProgressBar {
    let bar = ProgressBar::new(length);
    // The template is constant; should it be refused, the plain bar does as well.
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {percent:>3} %, {eta} left {msg}") {
        bar.set_style(style);
    }
    bar.with_message(what.to_owned())
}

/// A bar that goes away when it is dropped.
pub(super) struct Progress(ProgressBar);

impl Progress {
    pub(super) fn new() -> Self {
        Self(counter(STEPS as u64, ""))
    }

    /// Of steps of which nobody knows how long they take: the time that it has taken, in the place of what is left.
    pub(super) fn of_steps() -> Self {
        let bar = counter(STEPS as u64, "");
        // The template is constant; should it be refused, the other one does as well.
        if let Ok(style) =
            ProgressStyle::with_template("{bar:30} {percent:>3} %, {elapsed} so far: {msg}")
        {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_secs(1));
        Self(bar)
    }

    /// Shows the share that is done and what is being done. A bar that was further stays where it is: a later stage
    /// may find that there is less to do.
    pub(super) fn show(&self, share: f64, what: &str) {
        let now = (share * STEPS) as u64;
        self.0.set_position(now.max(self.0.position()));
        self.0.set_message(what.to_owned());
    }

    /// Prints a line that stays.
    pub(super) fn say(&self, line: &str) {
        self.0.suspend(|| say!("{line}"));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
