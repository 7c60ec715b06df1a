//! Limits of what a recorder writes: size of a file, number of files, total size.

use super::names::Names;
use anyhow::{Result, ensure};
use std::path::{Path, PathBuf};

/// Free disk space below which the operator is warned, bytes: enough for about two hours of 4 ms cycles, and for half an
/// hour.
const LOW_SPACE: [u64; 2] = [4 << 30, 1 << 30];

/// Limits of what is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// Number of files that may be begun for a boot of a board or for changed settings; cycles of further ones are dropped.
    /// The limit is needed because anybody who can send to the recorder can forge both.
    pub begun: u32,
    /// Size at which a file is ended and the next one begun, bytes.
    pub file_bytes: u64,
    /// Number of cycles at which a file is ended and the next one begun.
    pub file_cycles: u64,
    /// Total size of all files at which the recording ends, bytes.
    pub total_bytes: u64,
}

impl Default for Bounds {
    /// Files of about half an hour at 4 ms, two days in all.
    fn default() -> Self {
        Self {
            begun: 64,
            file_bytes: 1 << 30,
            file_cycles: u64::MAX,
            total_bytes: 100 << 30,
        }
    }
}

/// Use of the limits so far.
pub(super) struct Budget {
    names: Names,
    bounds: Bounds,
    begun: u32,
    /// Bytes written to all files.
    written: u64,
    /// Index in [`LOW_SPACE`] of the next warning.
    warned: usize,
    pub(super) warnings: Vec<String>,
}

impl Budget {
    pub(super) fn new(path: &Path, bounds: Bounds) -> Self {
        Self {
            names: Names::new(path),
            bounds,
            begun: 0,
            written: 0,
            warned: 0,
            warnings: Vec::new(),
        }
    }

    /// Path of a file for a new boot or for changed settings; None if there are too many.
    pub(super) fn begin_file(&mut self) -> Option<PathBuf> {
        if self.begun >= self.bounds.begun {
            return None;
        }
        self.begun += 1;
        Some(self.names.next_path())
    }

    /// Path of the file that follows a full one.
    pub(super) fn next_file(&mut self) -> PathBuf {
        self.names.next_path()
    }

    /// Whether a file of this size is to be ended.
    pub(super) fn is_full(&self, bytes: u64, cycles: u64) -> bool {
        bytes >= self.bounds.file_bytes || cycles >= self.bounds.file_cycles
    }

    /// Counts bytes that were written to a file, and warns of a full disk.
    ///
    /// # Errors
    /// The total size is used up.
    pub(super) fn count(&mut self, bytes: u64, path: &Path) -> Result<()> {
        self.written += bytes;
        let most = self.bounds.total_bytes;
        ensure!(
            self.written < most,
            "{:.1} GB are recorded, which is all that was allowed; --max-gb allows more",
            most as f64 * 1e-9
        );
        let folder = path
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new("."));
        // Where the system does not report the free space, there is no warning.
        if let Ok(free) = fs4::available_space(folder) {
            self.warn_of(free, folder);
        }
        Ok(())
    }

    /// Counts the last bytes of a file that was ended, without checks.
    pub(super) fn count_last(&mut self, bytes: u64) {
        self.written += bytes;
    }

    fn warn_of(&mut self, free: u64, folder: &Path) {
        let low = LOW_SPACE.get(self.warned);
        if low.is_some_and(|low| free < *low) {
            self.warned += 1;
            self.warnings.push(format!(
                "WARNING: only {:.1} GB are free in {}; an hour of 4 ms cycles takes up to 0.7 GB",
                free as f64 * 1e-9,
                folder.display()
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_person_is_warned_twice_before_the_disk_is_full() {
        let mut budget = Budget::new("run.mcap".as_ref(), Bounds::default());
        for (free_gb, warnings) in [(100, 0), (3, 1), (3, 1), (2, 1), (0, 2), (0, 2), (50, 2)] {
            budget.warn_of(free_gb << 30, ".".as_ref());
            assert_eq!(budget.warnings.len(), warnings, "{free_gb} GB");
        }
        assert!(budget.warnings[0].contains("only 3.2 GB"));
    }

    #[test]
    fn boots_and_bytes_are_bounded() {
        let bounds = Bounds {
            begun: 2,
            total_bytes: 1000,
            ..Bounds::default()
        };
        let path = Path::new("run.mcap");
        let mut budget = Budget::new(path, bounds);
        assert!(budget.begin_file().is_some() && budget.begin_file().is_some());
        assert_eq!(budget.begin_file(), None);
        assert!(budget.count(999, path).is_ok());
        let error = budget.count(1, path).unwrap_err().to_string();
        assert!(error.contains("--max-gb"), "{error}");
    }
}
