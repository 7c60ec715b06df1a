//! What a recorder hears besides the board that it can record.

use super::board::{Bench, Board, IDENTITY, address, rewritten, settings};
use proptest::prelude::*;
use softdock_app::telemetry::{Datagram, MAGIC, MessagePart, VERSION};

/// The same datagrams with other schemas.
fn of_another_version(datagrams: &[Datagram]) -> Vec<Datagram> {
    let changed = |datagram: &Datagram| {
        let part = MessagePart::read(datagram).unwrap();
        rewritten(&MessagePart {
            schema: !part.schema,
            ..part
        })
    };
    datagrams.iter().map(changed).collect()
}

/// The error of the first datagram that has one.
fn refusal(bench: &mut Bench, datagrams: &[Datagram]) -> Option<String> {
    let mut outcomes = datagrams
        .iter()
        .map(|d| bench.recorder.accept(d, address()));
    let error = outcomes.find_map(Result::err)?;
    Some(error.to_string())
}

#[test]
fn foreign_and_damaged_datagrams_are_ignored_and_counted() {
    let (mut board, mut bench) = (Board::boot(7), Bench::new());
    bench.hears(&board.announces(settings(100.0)));
    for cycle in 0..30 {
        let mut damaged = board.runs([cycle]).remove(0);
        bench.hears(std::slice::from_ref(&damaged));
        damaged[100] ^= 4;
        bench.hears(&[
            damaged,
            Datagram::from_slice(b"<Rob>").unwrap(),
            Datagram::new(),
        ]);
    }
    let (summary, recordings) = bench.finish();
    assert_eq!(recordings[0].cycles.len(), 30);
    assert_eq!(
        (summary.foreign_datagrams, summary.damaged_datagrams),
        (60, 30)
    );
    assert_eq!(summary.lost_cycles, 0);
}

#[test]
fn records_of_another_version_are_an_error_that_names_the_firmware() {
    let (mut board, mut bench) = (Board::boot(7), Bench::new());
    let cycles = of_another_version(&board.runs(0..10));
    assert_eq!(refusal(&mut bench, &cycles), None, "who it is comes later");
    let announcement = of_another_version(&board.announces(settings(100.0)));
    let error = refusal(&mut bench, &announcement).unwrap();
    assert!(
        error.contains(IDENTITY) && error.contains("schema"),
        "{error}"
    );
    assert!(
        error.contains("use the softdock of the firmware's version"),
        "{error}"
    );
    assert!(!bench.path("run.mcap").exists());
}

#[test]
fn settings_of_another_version_are_an_error_that_names_the_firmware() {
    let (mut board, mut bench) = (Board::boot(7), Bench::new());
    let announcement = board.announces_block(b"SDK1 and something else");
    let error = refusal(&mut bench, &announcement).unwrap();
    assert!(
        error.contains(IDENTITY) && error.contains("settings"),
        "{error}"
    );
}

#[test]
fn another_layout_is_an_error_that_names_both() {
    let mut bench = Bench::new();
    let datagram = [MAGIC.as_slice(), &[VERSION + 1], &[0; 50]].concat();
    let error = refusal(&mut bench, &[Datagram::from_slice(&datagram).unwrap()]).unwrap();
    assert!(
        error.contains("telemetry of version 2; expected is version 1"),
        "{error}"
    );
}

/// One bad board does not end the recording of a good one.
#[test]
fn a_board_that_cannot_be_recorded_does_not_disturb_another() {
    let (mut board, mut bench) = (Board::boot(7), Bench::new());
    bench.hears(&board.announces(settings(100.0)));
    let mut old = Board::boot(8);
    for cycle in 0..10 {
        bench.hears(&board.runs([cycle]));
        bench.hears(&of_another_version(&old.announces(settings(100.0))));
        bench.hears(&of_another_version(&old.runs([cycle])));
    }
    let (summary, recordings) = bench.finish();
    assert_eq!((recordings.len(), summary.cycles), (1, 10));
    assert_eq!(summary.refused.len(), 1);
}

proptest! {
    #[test]
    fn any_payload_is_survived(
        parts in prop::collection::vec(
            (any::<[u8; 3]>(), any::<u8>(), prop::collection::vec(any::<u8>(), 0..300)),
            0..60,
        ),
    ) {
        let (mut board, mut bench) = (Board::boot(7), Bench::new());
        let genuine = board.runs([0]).remove(0);
        let genuine = MessagePart::read(&genuine).unwrap();
        for ([boot, part, count], sequence, payload) in parts {
            let part = MessagePart {
                part,
                parts: count,
                boot: u32::from(boot % 4),
                sequence: u32::from(sequence),
                payload: &payload,
                ..genuine
            };
            let _ = bench.recorder.accept(&rewritten(&part), address());
        }
        let (_, outcome) = bench.recorder.finish();
        prop_assert!(outcome.is_ok());
    }
}
