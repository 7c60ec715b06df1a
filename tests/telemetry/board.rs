//! A board's datagrams without a board, and the recordings that come of them.

use softdock_app::image::{IMAGE_MAX_BYTES, Image};
use softdock_app::record::CycleRecord;
use softdock_app::settings::BoardSettings;
use softdock_app::telemetry::{Announcement, Datagram, MessagePart, Stream};
use softdock_io::recording::Recording;
use softdock_io::telemetry::{Bounds, Recorder, Summary};
use std::net::SocketAddr;
use std::path::PathBuf;
use tempfile::TempDir;

pub(crate) const IDENTITY: &str = "softdock 9.8.7 (test)";

pub(crate) fn address() -> SocketAddr {
    "192.168.1.20:49152".parse().unwrap()
}

pub(crate) fn record(cycle: u64) -> CycleRecord {
    let mut record = CycleRecord::default();
    record.trace.cycle = cycle;
    record.trace.time_s = cycle as f64 * 0.004;
    record.trace.wrench_at_m[0] = (cycle as f64).sin();
    record
}

pub(crate) fn settings(mass_kg: f64) -> BoardSettings {
    let mut settings = BoardSettings::default();
    settings.control.body_k.mass_kg = mass_kg;
    settings
}

/// The datagrams of one boot.
pub(crate) struct Board {
    pub(crate) stream: Stream,
}

impl Board {
    pub(crate) fn boot(boot: u32) -> Self {
        Self {
            stream: Stream::new(boot),
        }
    }

    pub(crate) fn announces(&mut self, settings: BoardSettings) -> Vec<Datagram> {
        let mut image = [0; IMAGE_MAX_BYTES];
        let sequence = 0;
        let block = Image { sequence, settings };
        let length = block.encode(&mut image).unwrap();
        self.announces_block(&image[..length])
    }

    pub(crate) fn announces_block(&mut self, image: &[u8]) -> Vec<Datagram> {
        let identity = IDENTITY;
        let announcement = Announcement { image, identity };
        written(self.stream.announcement(&announcement).unwrap())
    }

    pub(crate) fn runs(&mut self, cycles: impl IntoIterator<Item = u64>) -> Vec<Datagram> {
        let cycles = cycles.into_iter();
        cycles
            .flat_map(|cycle| written(self.stream.record(&record(cycle)).unwrap()))
            .collect()
    }
}

fn written<'a>(parts: impl Iterator<Item = MessagePart<'a>>) -> Vec<Datagram> {
    parts.map(|part| rewritten(&part)).collect()
}

pub(crate) fn rewritten(part: &MessagePart<'_>) -> Datagram {
    let mut datagram = Datagram::new();
    part.write(&mut datagram);
    datagram
}

/// A recorder and the folder that it writes into.
pub(crate) struct Bench {
    pub(crate) recorder: Recorder,
    folder: TempDir,
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self::within(Bounds::default())
    }

    pub(crate) fn within(bounds: Bounds) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let recorder = Recorder::within(&folder.path().join("run.mcap"), bounds);
        Self { recorder, folder }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn hears(&mut self, datagrams: &[Datagram]) {
        for datagram in datagrams {
            self.recorder.accept(datagram, address()).unwrap();
        }
    }

    /// Ends the recording: what is said about it, and the files.
    pub(crate) fn finish(self) -> (Summary, Vec<Recording>) {
        let (summary, outcome) = self.recorder.finish();
        outcome.unwrap();
        let parts = summary.recordings.iter();
        let recordings = parts.map(|part| Recording::open(&part.path).unwrap());
        let recordings: Vec<Recording> = recordings.collect();
        for (part, recording) in summary.recordings.iter().zip(&recordings) {
            assert_eq!(recording.cut, None);
            assert_eq!(recording.cycles.len() as u64, part.cycles);
        }
        (summary, recordings)
    }
}

/// The numbers of a recording's cycles.
pub(crate) fn cycles(recording: &Recording) -> Vec<u64> {
    let cycles = recording.cycles.iter();
    cycles.map(|record| record.trace.cycle).collect()
}
