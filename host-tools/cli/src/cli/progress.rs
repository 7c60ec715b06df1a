//! A bar on standard error while a fit runs; nothing where nobody watches.

use indicatif::{ProgressBar, ProgressStyle};

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

/// A bar that goes away when it is dropped.
pub(super) struct Progress(ProgressBar);

impl Progress {
    pub(super) fn new() -> Self {
        let bar = ProgressBar::new(STEPS as u64);
        // The template is constant; should it be refused, the plain bar does as well.
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {msg}") {
            bar.set_style(style);
        }
        Self(bar)
    }

    /// Shows the share that is done and what is being done.
    pub(super) fn show(&self, share: f64, what: &str) {
        self.0.set_position((share * STEPS) as u64);
        self.0.set_message(what.to_owned());
    }

    /// Prints a line that stays.
    pub(super) fn say(&self, line: &str) {
        self.0.suspend(|| eprintln!("{line}"));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
