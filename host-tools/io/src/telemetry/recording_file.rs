//! One file of a recording that may have several.

use super::budget::Budget;
use crate::recording::{Header, RecordingWriter, TruthRecord};
use anyhow::Result;
use softdock_app::record::CycleRecord;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Cycles between two checks of the file's size: a quarter of a second, as its chunks.
const LOOK_CYCLES: u64 = 64;

/// A file that is being written.
pub(super) struct RecordingFile {
    writer: RecordingWriter,
    path: PathBuf,
    cycles: u64,
    /// Size at the last check.
    bytes: u64,
}

impl RecordingFile {
    pub(super) fn create(path: &Path, header: &Header) -> Result<Self> {
        Ok(Self {
            writer: RecordingWriter::create(path, header)?,
            path: path.to_path_buf(),
            cycles: 0,
            bytes: 0,
        })
    }

    /// Marks a run that this program computes: see [`RecordingWriter::simulated`].
    pub(super) fn simulated(self) -> Self {
        let writer = self.writer.simulated();
        Self { writer, ..self }
    }

    /// Number of cycles in the file.
    pub(super) fn cycles(&self) -> u64 {
        self.cycles
    }

    /// Whether the file has reached its limit, so that another one has to follow.
    pub(super) fn is_full(&self, budget: &Budget) -> bool {
        budget.is_full(self.bytes, self.cycles)
    }

    /// Notes the present time of day for the first cycle. To be called before that is pushed.
    pub(super) fn note_wall_clock(&mut self, first: &CycleRecord) -> Result<()> {
        self.writer
            .note_wall_clock(first.trace.time_s, SystemTime::now())
    }

    /// Writes a cycle.
    pub(super) fn push(
        &mut self,
        record: &CycleRecord,
        truth: Option<&TruthRecord>,
        budget: &mut Budget,
    ) -> Result<()> {
        self.writer.push(record, truth)?;
        self.cycles += 1;
        if self.cycles == 1 {
            // Earlier files may have ended between two checks: check the total size.
            return budget.count(0, &self.path);
        }
        if !self.cycles.is_multiple_of(LOOK_CYCLES) {
            return Ok(());
        }
        let bytes = std::fs::metadata(&self.path)?.len();
        let written = bytes.saturating_sub(self.bytes);
        self.bytes = bytes;
        budget.count(written, &self.path)
    }

    /// Adds metadata.
    pub(super) fn note(&mut self, name: &str, entries: BTreeMap<String, String>) -> Result<()> {
        self.writer.note(name, entries)
    }

    /// Ends the file without a check of the limits: what exceeds them is reported with the next file.
    pub(super) fn finish(self, budget: &mut Budget) -> Result<()> {
        self.writer.finish()?;
        let bytes = std::fs::metadata(&self.path)?.len();
        budget.count_last(bytes.saturating_sub(self.bytes));
        Ok(())
    }
}
