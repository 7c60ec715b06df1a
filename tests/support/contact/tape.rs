//! A board's telemetry recorded in files as by `softdock record`. Each file must be complete, and its cycles are recomputed
//! bit for bit.

use softdock_app::image::{IMAGE_MAX_BYTES, Image};
use softdock_app::record::CycleRecord;
use softdock_app::settings::BoardSettings;
use softdock_app::telemetry::{Announcement, Datagram, MessagePart, Stream};
use softdock_io::recording::Recording;
use softdock_io::replay::Replay;
use softdock_io::telemetry::{Bounds, Recorder};
use std::net::SocketAddr;
use tempfile::TempDir;

/// Largest number of cycles in a file: a minute and a half.
const PIECE: u64 = 22_500;

pub(super) struct Tape {
    settings: BoardSettings,
    stream: Stream,
    boots: u32,
    piece: u64,
    begun: Option<(Recorder, TempDir)>,
    /// Cycles of the current file.
    cycles: u64,
    replay: Replay,
    /// Number of checked files, and their bytes.
    pub(super) pieces: u64,
    pub(super) bytes: u64,
}

impl Tape {
    /// For a board that starts. A file has at most `piece` cycles.
    pub(super) fn new(settings: &BoardSettings, piece: u64) -> Self {
        Self {
            settings: settings.clone(),
            stream: Stream::new(1),
            boots: 1,
            piece: piece.min(PIECE),
            begun: None,
            cycles: 0,
            replay: Replay::default(),
            pieces: 0,
            bytes: 0,
        }
    }

    /// The board restarts.
    pub(super) fn boot(&mut self) {
        self.end();
        self.boots += 1;
        self.stream = Stream::new(self.boots);
        self.replay = Replay::default();
    }

    pub(super) fn take(&mut self, record: &CycleRecord) {
        if self.begun.is_none() {
            self.begin();
        }
        let told: Vec<Datagram> = self.stream.record(record).unwrap().map(written).collect();
        self.hear(&told);
        self.cycles += 1;
        if self.cycles == self.piece {
            self.end();
        }
    }

    fn begin(&mut self) {
        let folder = tempfile::tempdir().unwrap();
        let recorder = Recorder::within(&folder.path().join("run.mcap"), Bounds::default());
        self.begun = Some((recorder, folder));
        let image = Image {
            sequence: 0,
            settings: self.settings.clone(),
        };
        let mut block = [0; IMAGE_MAX_BYTES];
        let length = image.encode(&mut block).unwrap();
        let announcement = Announcement {
            image: &block[..length],
            identity: "softdock of a day",
        };
        let parts = self.stream.announcement(&announcement).unwrap();
        let told: Vec<Datagram> = parts.map(written).collect();
        self.hear(&told);
    }

    fn hear(&mut self, told: &[Datagram]) {
        let from = SocketAddr::from(([192, 168, 1, 20], 49_152));
        let (recorder, _) = self.begun.as_mut().unwrap();
        for datagram in told {
            recorder.accept(datagram, from).unwrap();
        }
    }

    /// Ends the file and checks it.
    pub(super) fn end(&mut self) {
        let Some((recorder, folder)) = self.begun.take() else {
            return;
        };
        let (summary, outcome) = recorder.finish();
        outcome.unwrap();
        assert_eq!(summary.recordings.len(), 1);
        let path = &summary.recordings[0].path;
        let recording = Recording::open(path).unwrap();
        assert_eq!(recording.cut, None);
        assert_eq!(recording.cycles.len() as u64, self.cycles);
        let report = self.replay.take(&recording).unwrap();
        assert!(report.identical, "{report}");
        self.pieces += 1;
        self.bytes += std::fs::metadata(path).unwrap().len();
        self.cycles = 0;
        drop(folder);
    }
}

fn written(part: MessagePart<'_>) -> Datagram {
    let mut datagram = Datagram::new();
    part.write(&mut datagram);
    datagram
}
