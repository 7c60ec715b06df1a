//! Datagrams that `softdock record` may receive from the network.

use super::Script;
use softdock_app::image::{IMAGE_MAX_BYTES, Image};
use softdock_app::record::CycleRecord;
use softdock_app::settings::BoardSettings;
use softdock_app::telemetry::{Announcement, Datagram, MessagePart, Stream};
use softdock_io::recording::Recording;
use softdock_io::telemetry::{Bounds, Recorder};
use std::net::SocketAddr;

/// Small limits, which a few datagrams reach.
const BOUNDS: Bounds = Bounds {
    begun: 3,
    file_bytes: 1 << 20,
    file_cycles: 5,
    total_bytes: 1 << 20,
};

/// Boards that announce themselves and run, controlled by the bytes; datagrams that were changed, with a new checksum; and
/// arbitrary bytes. All recorded files are complete.
pub(super) fn recorder(input: &[u8]) {
    let folder = tempfile::tempdir().unwrap();
    let mut recorder = Recorder::within(&folder.path().join("run.mcap"), BOUNDS);
    let mut boards: Vec<Stream> = (0..4).map(Stream::new).collect();
    let mut script = Script(input);
    while let Some(event) = script.byte() {
        let board = &mut boards[usize::from(event) % 4];
        let datagrams = match event / 4 % 4 {
            0 => announcement(board, &mut script),
            1 => record(board, &mut script),
            2 => {
                recorder.give_up_missing().unwrap();
                continue;
            }
            _ => vec![Datagram::from_slice(script.piece().unwrap_or_default()).unwrap()],
        };
        let from = SocketAddr::from(([192, 168, 1, event], 49_152));
        for mut datagram in datagrams {
            spoil(&mut datagram, event, &mut script);
            // The error that ends a recording: there was nothing to record, or too much.
            if recorder.accept(&datagram, from).is_err() {
                break;
            }
        }
    }
    let (summary, _) = recorder.finish();
    for part in &summary.recordings {
        let recording = Recording::open(&part.path).unwrap();
        assert_eq!(recording.cut, None);
        assert_eq!(recording.cycles.len() as u64, part.cycles);
    }
    assert!(summary.recordings.len() <= 3 * (1 + input.len() / 5));
}

fn announcement(board: &mut Stream, script: &mut Script<'_>) -> Vec<Datagram> {
    let mut settings = BoardSettings::default();
    settings.control.body_k.mass_kg += f64::from(script.byte().unwrap_or_default());
    let image = Image {
        sequence: 0,
        settings,
    };
    let mut block = [0; IMAGE_MAX_BYTES];
    let length = image.encode(&mut block).unwrap();
    let announcement = Announcement {
        image: &block[..length],
        identity: "softdock of a fuzzer",
    };
    let parts = board.announcement(&announcement).unwrap();
    parts.map(written).collect()
}

fn record(board: &mut Stream, script: &mut Script<'_>) -> Vec<Datagram> {
    let mut record = CycleRecord::default();
    record.trace.cycle = u64::from_le_bytes(script.bytes());
    record.trace.time_s = script.number(0.004);
    let parts = board.record(&record).unwrap();
    parts.map(written).collect()
}

fn written(part: MessagePart<'_>) -> Datagram {
    let mut datagram = Datagram::new();
    part.write(&mut datagram);
    datagram
}

/// Changes some datagrams: other numbers and another payload, with a valid checksum.
fn spoil(datagram: &mut Datagram, event: u8, script: &mut Script<'_>) {
    if event < 128 {
        return;
    }
    let Ok(part) = MessagePart::read(datagram) else {
        return;
    };
    let mut payload = part.payload.to_vec();
    if let Some(byte) = payload.get_mut(usize::from(script.byte().unwrap_or_default())) {
        *byte = script.byte().unwrap_or_default();
    }
    let [part_number, parts, sequence] = script.bytes();
    *datagram = written(MessagePart {
        part: part_number % 8,
        parts: parts % 8,
        sequence: part.sequence.wrapping_add(u32::from(sequence)),
        payload: &payload,
        ..part
    });
}
