//! Writes datagrams of any senders into recordings.

use super::budget::{Bounds, Budget};
use super::stream::Stream;
use super::stream_file::FileSummary;
use crate::identity;
use anyhow::{Result, anyhow};
use serde::Serialize;
use softdock_app::record::CycleRecord;
use softdock_app::telemetry::{DatagramError, MessagePart};
use std::net::SocketAddr;
use std::path::Path;

/// Number of boots whose streams are open at a time. One more ends the file of the stream that was silent longest; if that
/// board still sends, it gets a new file.
const STREAMS: usize = 16;

/// Takes the datagrams of one or more boards and writes their cycles.
pub struct Recorder {
    budget: Budget,
    /// Oldest first, each with the number of its last datagram.
    streams: Vec<(u64, Stream)>,
    datagrams: u64,
    /// Files of streams that have ended.
    finished: Vec<FileSummary>,
    /// Datagrams of ended streams that came twice or too late.
    repeated: u64,
    /// Cycles of ended streams for which no file was allowed.
    dropped: u64,
    foreign: u64,
    damaged: u64,
    last_foreign: Option<SocketAddr>,
    notes: Vec<String>,
    refused: Vec<String>,
}

/// State of a recorder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Boots that were heard.
    pub boots: usize,
    /// The firmware that was announced last.
    pub identity: Option<String>,
    /// Cycles that were recorded.
    pub cycles: u64,
    /// Cycles that are missing between those.
    pub lost_cycles: u64,
    /// Datagrams that are not of softdock, and the last one's sender.
    pub foreign: (u64, Option<SocketAddr>),
}

/// Result of a recorder.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Cycles in all files.
    pub cycles: u64,
    /// Cycles that are missing between those.
    pub lost_cycles: u64,
    /// The files.
    pub recordings: Vec<FileSummary>,
    /// Datagrams that are not of softdock.
    pub foreign_datagrams: u64,
    /// Datagrams of softdock that were damaged.
    pub damaged_datagrams: u64,
    /// Datagrams that came twice or too late.
    pub repeated_datagrams: u64,
    /// Cycles for which no file was begun, because there were too many boots or changes of the settings.
    pub dropped_cycles: u64,
    /// Boards that could not be recorded, and why.
    pub refused: Vec<String>,
}

impl Recorder {
    /// Writes into `path`, within the usual bounds; further files get a number before the ending.
    pub fn new(path: &Path) -> Self {
        Self::within(path, Bounds::default())
    }

    /// As [`Self::new`], with these limits.
    pub fn within(path: &Path, bounds: Bounds) -> Self {
        Self {
            budget: Budget::new(path, bounds),
            streams: Vec::new(),
            datagrams: 0,
            finished: Vec::new(),
            repeated: 0,
            dropped: 0,
            foreign: 0,
            damaged: 0,
            last_foreign: None,
            notes: Vec::new(),
            refused: Vec::new(),
        }
    }

    /// Takes a datagram.
    ///
    /// # Errors
    /// A file cannot be written; or the only board that was heard speaks another version, and there
    /// is nothing to record.
    pub fn accept(&mut self, datagram: &[u8], from: SocketAddr) -> Result<()> {
        let part = match MessagePart::read(datagram) {
            Ok(part) => part,
            Err(DatagramError::Foreign) => {
                self.foreign += 1;
                self.last_foreign = Some(from);
                return Ok(());
            }
            Err(error @ DatagramError::Version { .. }) => {
                return self.refuse(&format!("the board at {from}"), &error.to_string());
            }
            Err(_) => {
                self.damaged += 1;
                return Ok(());
            }
        };
        let index = self.stream(part.boot)?;
        let Some((heard, stream)) = self.streams.get_mut(index) else {
            return Ok(());
        };
        self.datagrams += 1;
        *heard = self.datagrams;
        stream.push(&part, &mut self.budget)?;
        self.notes.append(&mut stream.notes);
        let Some(why) = stream.refusal() else {
            return Ok(());
        };
        let who = stream.identity().unwrap_or_default();
        let who = format!("the board at {from} with the firmware `{who}`");
        self.refuse(&who, &why)
    }

    /// Called when nothing has come for a while: gives up the datagrams that are missing.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn give_up_missing(&mut self) -> Result<()> {
        for (_, stream) in &mut self.streams {
            stream.advance(true, &mut self.budget)?;
            self.notes.append(&mut stream.notes);
        }
        Ok(())
    }

    /// Takes the remarks for the operator since the last call.
    pub fn take_notes(&mut self) -> Vec<String> {
        self.notes.append(&mut self.budget.warnings);
        std::mem::take(&mut self.notes)
    }

    /// Numbers of boots, cycles and losses so far.
    pub fn progress(&self) -> Progress {
        let (mut cycles, mut lost_cycles) = (0, 0_u64);
        let open = self.streams.iter().flat_map(|(_, stream)| stream.files());
        for file in self.finished.iter().cloned().chain(open) {
            cycles += file.cycles;
            lost_cycles = file.lost_cycles.saturating_add(lost_cycles);
        }
        let newest = self.streams.iter().rev();
        let newest = newest.filter_map(|(_, stream)| stream.identity()).next();
        Progress {
            boots: self.streams.len(),
            identity: newest.map(str::to_owned),
            cycles,
            lost_cycles,
            foreign: (self.foreign, self.last_foreign),
        }
    }

    /// The cycle that was received last.
    pub fn newest(&self) -> Option<&CycleRecord> {
        let streams = self.streams.iter().rev();
        streams
            .filter_map(|(_, stream)| stream.newest.as_ref())
            .next()
    }

    /// Ends all files. Returns their summary, and the first error.
    pub fn finish(mut self) -> (Summary, Result<()>) {
        let mut outcome = Ok(());
        for (_, stream) in std::mem::take(&mut self.streams) {
            outcome = outcome.and(self.end(stream));
        }
        let sum = |of: fn(&FileSummary) -> u64| {
            let parts = self.finished.iter().map(of);
            parts.fold(0, u64::saturating_add)
        };
        let summary = Summary {
            cycles: sum(|part| part.cycles),
            lost_cycles: sum(|part| part.lost_cycles),
            foreign_datagrams: self.foreign,
            damaged_datagrams: self.damaged,
            repeated_datagrams: self.repeated,
            dropped_cycles: self.dropped,
            refused: self.refused,
            recordings: self.finished,
        };
        (summary, outcome)
    }

    /// Index of the stream of a boot; begins one for a new boot.
    fn stream(&mut self, boot: u32) -> Result<usize> {
        let mut streams = self.streams.iter();
        let place = streams.position(|(_, stream)| stream.boot() == boot);
        if let Some(place) = place {
            return Ok(place);
        }
        if self.streams.len() >= STREAMS {
            let heard = self.streams.iter().map(|(heard, _)| *heard);
            let silent = heard.enumerate().min_by_key(|(_, heard)| *heard);
            let (_, silent) = self.streams.remove(silent.map_or(0, |(place, _)| place));
            self.end(silent)?;
        }
        self.streams.push((self.datagrams, Stream::new(boot)));
        Ok(self.streams.len() - 1)
    }

    fn end(&mut self, stream: Stream) -> Result<()> {
        self.repeated += stream.repeated();
        let (parts, dropped, outcome) = stream.finish(&mut self.budget);
        self.dropped += dropped;
        self.finished.extend(parts);
        outcome
    }

    /// Notes a board that cannot be recorded. An error if no other board can be recorded either.
    fn refuse(&mut self, who: &str, why: &str) -> Result<()> {
        let text = format!(
            "{who} cannot be recorded by this program (`{}`): {why}; use the softdock of the \
             firmware's version, or flash the board with this one's",
            identity::text()
        );
        if self.refused.contains(&text) {
            return Ok(());
        }
        self.refused.push(text.clone());
        let others = |(_, stream): &(u64, Stream)| stream.refusal().is_none();
        if self.finished.is_empty() && !self.streams.iter().any(others) {
            return Err(anyhow!(text));
        }
        self.notes.push(text);
        Ok(())
    }
}
