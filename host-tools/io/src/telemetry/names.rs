//! Paths of the files of one recording.

use std::path::{Path, PathBuf};

/// Generates the paths: the one that was asked for, then with `-2`, `-3`, .. before its ending.
#[derive(Debug)]
pub(super) struct Names {
    first: PathBuf,
    given: u32,
}

impl Names {
    /// Begins with the path of the first file.
    pub(super) fn new(first: &Path) -> Self {
        Self {
            first: first.to_path_buf(),
            given: 0,
        }
    }

    /// The next path. The first file may exist. Numbers whose file exists are skipped, so that files of an earlier recording
    /// are not overwritten.
    pub(super) fn next_path(&mut self) -> PathBuf {
        loop {
            self.given += 1;
            let path = match self.given {
                1 => return self.first.clone(),
                number => self.numbered(number),
            };
            if !path.exists() {
                return path;
            }
        }
    }

    fn numbered(&self, number: u32) -> PathBuf {
        let mut name = self.first.file_stem().unwrap_or_default().to_os_string();
        name.push(format!("-{number}"));
        if let Some(ending) = self.first.extension() {
            name.push(".");
            name.push(ending);
        }
        self.first.with_file_name(name)
    }
}

/// Sorts the files of each recording by their number, the order in which they were written: a shell gives `run-10.mcap`
/// before `run-2.mcap`.
pub fn sort_series(paths: &mut [PathBuf]) {
    paths.sort_by_cached_key(|path| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let number = stem.rsplit_once('-');
        let number = number.and_then(|(name, number)| Some((name, number.parse::<u32>().ok()?)));
        let (name, number) = number.unwrap_or((&stem, 1));
        (path.with_file_name(name), number)
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_sorted_by_their_numbers() {
        let sorted = ["a/run.mcap", "a/run-2.mcap", "a/run-10.mcap", "b-c.mcap"].map(PathBuf::from);
        let mut given = [2, 3, 1, 0].map(|k| sorted[k].clone());
        sort_series(&mut given);
        assert_eq!(given, sorted);
    }

    #[test]
    fn what_exists_is_passed_over() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("run.mcap"), "").unwrap();
        std::fs::write(path("run-3.mcap"), "").unwrap();
        let mut names = Names::new(&path("run.mcap"));
        for expected in ["run.mcap", "run-2.mcap", "run-4.mcap"] {
            assert_eq!(names.next_path(), path(expected));
        }
        assert_eq!(Names::new("run".as_ref()).numbered(2), Path::new("run-2"));
    }
}
