//! One file of a recording: the cycles of one boot with one set of settings.

use super::budget::Budget;
use super::recording_file::RecordingFile;
use crate::recording::Header;
use anyhow::Result;
use serde::Serialize;
use softdock_app::record::CycleRecord;
use softdock_link::service::Machine;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Name of the metadata record on losses.
pub const METADATA: &str = "softdock.telemetry";

/// Losses of a stream so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Losses {
    /// Records that the board dropped for lack of room.
    pub(super) on_board: u64,
    /// Datagrams that never came.
    pub(super) datagrams: u64,
    /// Records of which some parts came, but not all.
    pub(super) torn: u64,
}

/// Result of a file. The recording's metadata contains it under [`METADATA`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FileSummary {
    /// The file.
    pub path: PathBuf,
    /// Identification of the boot of the board, hexadecimal.
    pub boot: String,
    /// Firmware of the board; empty if it was never announced.
    pub identity: String,
    /// Whether the board's settings are in the file.
    pub settings: bool,
    /// Whether it continues the file before: a replay needs both, in order.
    pub continues: bool,
    /// Number of the first recorded cycle since boot; a replay needs 0.
    pub first_cycle: Option<u64>,
    /// Cycles that were recorded.
    pub cycles: u64,
    /// Cycles that are missing between the first and the last.
    pub lost_cycles: u64,
    /// Records that the board dropped for lack of room, among the lost cycles or after them.
    pub lost_on_board: u64,
    /// Datagrams that the network or this computer lost.
    pub lost_datagrams: u64,
    /// Records of which some parts came, but not all.
    pub torn_records: u64,
    /// The last report of the board on itself: stack, times of its answers, noise of its inputs.
    pub machine: Option<Machine>,
}

/// A file that is being written.
pub(super) struct StreamFile {
    file: RecordingFile,
    summary: FileSummary,
    last_cycle: Option<u64>,
    /// Losses of the stream before this file.
    before: Losses,
}

impl StreamFile {
    pub(super) fn create(
        path: &Path,
        boot: u32,
        header: Option<&Header>,
        continues: bool,
        before: Losses,
    ) -> Result<Self> {
        let known = header.cloned().unwrap_or_default();
        Ok(Self {
            file: RecordingFile::create(path, &known)?,
            summary: FileSummary {
                path: path.to_path_buf(),
                boot: format!("{boot:08x}"),
                identity: known.identity,
                settings: header.is_some(),
                continues,
                first_cycle: None,
                cycles: 0,
                lost_cycles: 0,
                lost_on_board: 0,
                lost_datagrams: 0,
                torn_records: 0,
                machine: None,
            },
            last_cycle: None,
            before,
        })
    }

    pub(super) fn note_machine(&mut self, machine: Machine) {
        self.summary.machine = Some(machine);
    }

    /// Whether the file has reached its limit, so that another one has to follow.
    pub(super) fn is_full(&self, budget: &Budget) -> bool {
        self.file.is_full(budget)
    }

    /// Writes a cycle.
    pub(super) fn push(&mut self, record: &CycleRecord, budget: &mut Budget) -> Result<()> {
        let cycle = record.trace.cycle;
        if self.last_cycle.is_none() {
            self.file.note_wall_clock(record)?;
        }
        self.file.push(record, None, budget)?;
        let missing = self
            .last_cycle
            .map_or(0, |last| cycle.saturating_sub(last.saturating_add(1)));
        self.summary.first_cycle.get_or_insert(cycle);
        // The number comes from the network and may be anything.
        self.summary.lost_cycles = self.summary.lost_cycles.saturating_add(missing);
        self.last_cycle = Some(cycle);
        Ok(())
    }

    /// Summary of the file so far; `now` are the losses of the stream.
    pub(super) fn summary(&self, now: Losses) -> FileSummary {
        FileSummary {
            cycles: self.file.cycles(),
            lost_on_board: now.on_board - self.before.on_board,
            lost_datagrams: now.datagrams - self.before.datagrams,
            torn_records: now.torn - self.before.torn,
            ..self.summary.clone()
        }
    }

    /// Writes the summary into the file and ends it.
    pub(super) fn finish(mut self, now: Losses, budget: &mut Budget) -> Result<FileSummary> {
        let summary = self.summary(now);
        self.file.note(METADATA, summary.metadata())?;
        self.file.finish(budget)?;
        Ok(summary)
    }
}

impl FileSummary {
    fn metadata(&self) -> BTreeMap<String, String> {
        let first_cycle = self.first_cycle.unwrap_or_default();
        let numbers = [
            ("first_cycle", first_cycle),
            ("cycles", self.cycles),
            ("lost_cycles", self.lost_cycles),
            ("lost_on_board", self.lost_on_board),
            ("lost_datagrams", self.lost_datagrams),
            ("torn_records", self.torn_records),
        ];
        let machine = self.machine.as_ref();
        let machine = machine.and_then(|machine| serde_json::to_string(machine).ok());
        let recorder = [
            ("recorder", crate::identity::text()),
            ("boot", self.boot.clone()),
            ("continues", self.continues.to_string()),
            ("machine", machine.unwrap_or_default()),
        ];
        numbers
            .map(|(key, number)| (key.to_owned(), number.to_string()))
            .into_iter()
            .chain(recorder.map(|(key, text)| (key.to_owned(), text)))
            .collect()
    }
}

impl std::fmt::Display for FileSummary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {} cycles", self.path.display(), self.cycles)?;
        let around = self.lost_on_board + self.lost_datagrams + self.torn_records;
        match self.lost_cycles {
            0 if around == 0 => write!(f, ", none lost")?,
            0 => write!(
                f,
                ", none lost in between; besides or after them {} had no room on the board, {} \
                 datagrams were lost on the way",
                self.lost_on_board, self.lost_datagrams
            )?,
            lost => write!(
                f,
                ", {lost} LOST in between ({} had no room on the board, {} datagrams were lost \
                 on the way, {} records came in part)",
                self.lost_on_board, self.lost_datagrams, self.torn_records
            )?,
        }
        if !self.settings {
            write!(f, "; WITHOUT the board's settings, which never came")?;
        }
        match self.first_cycle {
            Some(first) if self.continues => write!(
                f,
                "; goes on from the file before with cycle {first}: replay them together"
            ),
            Some(first) if first > 0 => write!(
                f,
                "; begins with cycle {first}: to be replayed, a recording must begin before the \
                 robot does"
            ),
            _ => Ok(()),
        }
    }
}
