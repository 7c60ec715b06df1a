//! The last lines of the board's log.

use core::fmt::{Arguments, Write};
use heapless::{Deque, String, Vec};
use softdock_link::service::{LINE_BYTES, LINES_MAX, LogLine};

/// Lines that are kept.
const KEPT: usize = 16;

/// A log; when full, the oldest line is dropped.
#[derive(Debug, Default)]
pub struct Log {
    lines: Deque<LogLine, KEPT>,
    next: u32,
}

impl Log {
    /// An empty log.
    pub const fn new() -> Self {
        Self {
            lines: Deque::new(),
            next: 0,
        }
    }

    /// Adds a line; a longer text is cut off.
    pub fn add(&mut self, at_us: u64, text: Arguments<'_>) {
        let mut line = Cut(String::new());
        let _ = line.write_fmt(text);
        if self.lines.is_full() {
            self.lines.pop_front();
        }
        let _ = self.lines.push_back(LogLine {
            number: self.next,
            at_ms: at_us / 1000,
            text: line.0,
        });
        self.next = self.next.wrapping_add(1);
    }

    /// Lines from this number on, as many as an answer takes.
    pub fn from(&self, number: u32) -> Vec<LogLine, LINES_MAX> {
        self.lines
            .iter()
            .filter(|line| line.number >= number)
            .take(LINES_MAX)
            .cloned()
            .collect()
    }
}

/// A text that is cut off at its capacity.
struct Cut(String<LINE_BYTES>);

impl Write for Cut {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        text.chars()
            .try_for_each(|character| self.0.push(character))
            .map_err(|_| core::fmt::Error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_lines_are_kept_and_long_ones_cut_off() {
        let mut log = Log::new();
        for n in 0..20 {
            log.add(n * 1_000, format_args!("line {n}"));
        }
        log.add(0, format_args!("{:300}", ""));
        let lines = log.from(0);
        assert_eq!((lines.len(), lines[0].number), (LINES_MAX, 5));
        assert_eq!((lines[0].text.as_str(), lines[0].at_ms), ("line 5", 5));
        let last = log.from(20);
        assert_eq!((last.len(), last[0].text.len()), (1, LINE_BYTES));
        assert!(log.from(21).is_empty());
    }
}
