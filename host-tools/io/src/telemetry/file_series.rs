//! Writes the recording of one source into files of limited size.

use super::budget::{Bounds, Budget};
use super::recording_file::RecordingFile;
use super::stream_file::METADATA;
use crate::recording::{Header, TruthRecord};
use anyhow::{Context, Result};
use softdock_app::record::CycleRecord;
use std::path::{Path, PathBuf};

/// Relation of the recording to real time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Time {
    /// Cycles are recorded as they happen: each file gets the time of day.
    Real,
    /// This program computes the cycles: they have no time of day.
    Virtual,
}

/// Consecutive files: each is complete, and all are replayed together in their order.
pub struct FileSeries {
    budget: Budget,
    time: Time,
    header: Header,
    open: Option<RecordingFile>,
    /// Number of the next cycle if none is lost.
    next: Option<u64>,
    /// Number of the open file's first cycle.
    first: u64,
    /// Cycles that were lost within the open file, or since the file before.
    lost: u64,
    paths: Vec<PathBuf>,
}

impl FileSeries {
    /// Writes into `path`; further files have a number before the ending.
    pub fn new(path: &Path, bounds: Bounds, time: Time) -> Self {
        Self {
            budget: Budget::new(path, bounds),
            time,
            header: Header::default(),
            open: None,
            next: None,
            first: 0,
            lost: 0,
            paths: Vec::new(),
        }
    }

    /// Ends the present file and begins one with another header, for a board that starts over.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn begin(&mut self, header: Header) -> Result<()> {
        self.finish()?;
        self.next = None;
        self.header = header;
        self.next_file()
    }

    /// Writes a cycle. `truth`, that of the simulated rig, is given for every cycle or for none.
    ///
    /// # Errors
    /// A file cannot be written, or the total size is used up.
    pub fn push(&mut self, record: &CycleRecord, truth: Option<&TruthRecord>) -> Result<()> {
        let full = |file: &RecordingFile| file.is_full(&self.budget);
        if self.open.as_ref().is_none_or(full) {
            self.finish()?;
            self.next_file()?;
        }
        let cycle = record.trace.cycle;
        // The first number may be anything.
        let expected = self.next.replace(cycle.saturating_add(1));
        let missing = expected.map_or(0, |expected| cycle.saturating_sub(expected));
        self.lost = self.lost.saturating_add(missing);
        let file = self.open.as_mut().context("no file of the recording")?;
        if file.cycles() == 0 && self.time == Time::Real {
            file.note_wall_clock(record)?;
            self.first = cycle;
        }
        file.push(record, truth, &mut self.budget)
    }

    /// Ends the present file. In real time its metadata gets the number of lost cycles, also if that is zero, as that of a
    /// recording over the network.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(&mut self) -> Result<()> {
        let Some(mut file) = self.open.take() else {
            return Ok(());
        };
        let lost = std::mem::take(&mut self.lost);
        if self.time == Time::Real {
            let numbers = [
                ("first_cycle", self.first),
                ("cycles", file.cycles()),
                ("lost_cycles", lost),
            ];
            let entries = numbers.map(|(key, number)| (key.to_owned(), number.to_string()));
            file.note(METADATA, entries.into())?;
        }
        file.finish(&mut self.budget)
    }

    /// Paths of the files so far.
    pub fn paths(&self) -> &[PathBuf] {
        &self.paths
    }

    /// Takes the warnings for the operator since the last call.
    pub fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.budget.warnings)
    }

    fn next_file(&mut self) -> Result<()> {
        let path = self.budget.next_file();
        let file = RecordingFile::create(&path, &self.header)?;
        self.open = Some(match self.time {
            Time::Real => file,
            Time::Virtual => file.simulated(),
        });
        self.paths.push(path);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Recording, WALL_CLOCK};

    fn cycle(number: u64) -> CycleRecord {
        let mut record = CycleRecord::default();
        record.trace.cycle = number;
        record
    }

    fn bounds(file_cycles: u64) -> Bounds {
        Bounds {
            file_cycles,
            ..Bounds::default()
        }
    }

    #[test]
    fn each_file_is_whole_and_none_is_too_long() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.mcap");
        let mut series = FileSeries::new(&path, bounds(100), Time::Virtual);
        let truth = TruthRecord::default();
        for n in 0..250 {
            series.push(&cycle(n), Some(&truth)).unwrap();
        }
        series.finish().unwrap();
        let mut next = 0;
        for (path, cycles) in series.paths().iter().zip([100, 100, 50]) {
            let file = Recording::open(path).unwrap();
            assert_eq!((file.cut, file.truth.len()), (None, cycles));
            for record in file.cycles {
                assert_eq!(record.trace.cycle, next);
                next += 1;
            }
        }
        assert_eq!((next, series.paths().len()), (250, 3));
    }

    /// The first chunk that goes beyond the size ends a file.
    #[test]
    fn a_file_that_has_its_size_is_ended() {
        let folder = tempfile::tempdir().unwrap();
        let mut of_size = bounds(u64::MAX);
        of_size.file_bytes = 1;
        let mut series = FileSeries::new(&folder.path().join("run.mcap"), of_size, Time::Virtual);
        for n in 0..200 {
            series.push(&cycle(n), None).unwrap();
        }
        series.finish().unwrap();
        let cycles = |path: &PathBuf| Recording::open(path).unwrap().cycles.len();
        let lengths: Vec<usize> = series.paths().iter().map(cycles).collect();
        assert_eq!(lengths.iter().sum::<usize>(), 200);
        assert!(lengths.len() >= 3, "{lengths:?}");
    }

    /// A board that starts over has other settings, and each file of a live recording has a time of day.
    #[test]
    fn a_board_that_starts_over_gets_a_file_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.mcap");
        let mut series = FileSeries::new(&path, bounds(100), Time::Real);
        for settings in ["a = 1", "a = 2"] {
            let header = Header {
                settings_toml: settings.to_owned(),
                ..Header::default()
            };
            series.begin(header).unwrap();
            series.push(&cycle(0), None).unwrap();
        }
        series.finish().unwrap();
        for (path, settings) in series.paths().iter().zip(["a = 1", "a = 2"]) {
            let bytes = std::fs::read(path).unwrap();
            let recording = Recording::open(path).unwrap();
            assert_eq!(recording.header.settings_toml, settings);
            let name = WALL_CLOCK.as_bytes();
            assert!(bytes.windows(name.len()).any(|window| window == name));
        }
    }

    /// A disk that stalls loses cycles: the file that lacks them reports them, and the next one reports none.
    #[test]
    fn a_file_says_how_many_cycles_it_lacks() {
        let folder = tempfile::tempdir().unwrap();
        let mut series = FileSeries::new(&folder.path().join("run.mcap"), bounds(5), Time::Real);
        for n in [0, 1, 5, 6, 9, 10, 11] {
            series.push(&cycle(n), None).unwrap();
        }
        series.finish().unwrap();
        let [first, second] = series.paths() else {
            panic!("{:?}", series.paths());
        };
        let has = |path: &Path, part: &[u8]| {
            let bytes = std::fs::read(path).unwrap();
            bytes.windows(part.len()).any(|window| window == part)
        };
        assert!(has(first, METADATA.as_bytes()) && has(first, b"lost_cycles\x01\0\0\x005"));
        assert!(
            has(second, b"lost_cycles\x01\0\0\x000") && has(second, b"first_cycle\x02\0\0\x0010")
        );
    }

    /// Files that end before their size is checked.
    #[test]
    fn many_small_files_have_no_more_than_is_allowed() {
        let folder = tempfile::tempdir().unwrap();
        let few = Bounds {
            total_bytes: 100_000,
            ..bounds(10)
        };
        let mut series = FileSeries::new(&folder.path().join("run.mcap"), few, Time::Virtual);
        let error = (0..1000).find_map(|n| series.push(&cycle(n), None).err());
        assert!(error.unwrap().to_string().contains("--max-gb"));
    }

    #[test]
    fn no_more_is_written_than_is_allowed() {
        let folder = tempfile::tempdir().unwrap();
        let few = Bounds {
            total_bytes: 1,
            ..bounds(100)
        };
        let mut series = FileSeries::new(&folder.path().join("run.mcap"), few, Time::Virtual);
        let error = (0..200).find_map(|n| series.push(&cycle(n), None).err());
        assert!(error.unwrap().to_string().contains("--max-gb"));
        drop(series);
        let whole = Recording::open(&folder.path().join("run.mcap")).unwrap();
        assert_eq!(whole.cut, None);
    }
}
