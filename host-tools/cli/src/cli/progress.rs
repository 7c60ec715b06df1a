//! A bar on standard error while something runs; nothing where nobody watches.

use indicatif::{ProgressBar, ProgressStyle};
use softdock_io::say;
use std::time::Duration;

/// Resolution of the bar.
const STEPS: f64 = 1000.0;

/// An animated line for work whose end is unknown.
pub(super) fn spinner() -> ProgressBar {
    let bar = ProgressBar::new_spinner();
    // The template is a constant that parses; if it did not, the default spinner would do.
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}") {
        bar.set_style(style);
    }
    bar
}

/// A bar up to a known count, with the share done and the estimated time left.
pub(super) fn counter(length: u64, what: &str) -> ProgressBar {
    let bar = ProgressBar::new(length);
    // The template is a constant that parses; if it did not, the default bar would do.
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

    /// A bar for steps of unknown duration: it shows the elapsed time in place of the time left.
    pub(super) fn of_steps() -> Self {
        let bar = counter(STEPS as u64, "");
        // The template is a constant that parses; if it did not, that of `counter` would do.
        if let Ok(style) =
            ProgressStyle::with_template("{bar:30} {percent:>3} %, {elapsed} so far: {msg}")
        {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_secs(1));
        Self(bar)
    }

    /// Shows the share that is done and the present step. The bar never goes back, although a later stage may give a smaller
    /// share.
    pub(super) fn show(&self, share: f64, what: &str) {
        let now = (share * STEPS) as u64;
        self.0.set_position(now.max(self.0.position()));
        self.0.set_message(what.to_owned());
    }

    /// Prints a line above the bar.
    pub(super) fn say(&self, line: &str) {
        self.0.suspend(|| say!("{line}"));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
