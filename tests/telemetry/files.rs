//! What gets into which file.

use super::board::{Bench, Board, IDENTITY, address, cycles, record, settings};
use softdock_io::telemetry::{Bounds, METADATA};
use std::collections::BTreeMap;

#[test]
fn a_recording_holds_every_cycle_with_settings_and_identity() {
    let (mut board, mut bench) = (Board::boot(7), Bench::new());
    bench.hears(&board.announces(settings(123.0)));
    for second in 0..3 {
        bench.hears(&board.runs(second * 250..(second + 1) * 250));
        bench.hears(&board.announces(settings(123.0)));
    }
    let (summary, recordings) = bench.finish();
    let [recording] = recordings.as_slice() else {
        panic!("one file is expected: {summary:?}");
    };
    assert_eq!(recording.cycles, (0..750).map(record).collect::<Vec<_>>());
    assert_eq!(recording.header.identity, IDENTITY);
    assert_eq!(recording.header.scenario_toml, None);
    let control = recording.header.control_settings().unwrap();
    assert_eq!(control, settings(123.0).control);
    let [part] = summary.recordings.as_slice() else {
        panic!("one summary is expected");
    };
    assert!(part.settings && part.lost_cycles == 0);
    assert_eq!(
        (part.boot.as_str(), part.first_cycle),
        ("00000007", Some(0))
    );
    assert_eq!(
        part.lost_datagrams + part.lost_on_board + part.torn_records,
        0
    );
}

#[test]
fn cycles_before_the_settings_are_kept() {
    let (mut board, mut bench) = (Board::boot(7), Bench::new());
    // The announcement at boot was lost.
    board.announces(settings(123.0));
    bench.hears(&board.runs(40..290));
    assert!(!bench.path("run.mcap").exists());
    bench.hears(&board.announces(settings(123.0)));
    bench.hears(&board.runs(290..300));
    let (summary, recordings) = bench.finish();
    assert_eq!(cycles(&recordings[0]), (40..300).collect::<Vec<_>>());
    assert!(recordings[0].header.control_settings().is_ok());
    assert_eq!(summary.recordings[0].first_cycle, Some(40));
    let said = summary.recordings[0].to_string();
    assert!(
        said.contains("begins with cycle 40: to be replayed"),
        "{said}"
    );
}

#[test]
fn without_settings_the_cycles_are_written_nevertheless() {
    let (mut board, mut bench) = (Board::boot(7), Bench::new());
    bench.hears(&board.runs(0..6000));
    assert!(bench.path("run.mcap").exists(), "waiting has a bound");
    let (summary, recordings) = bench.finish();
    assert_eq!(cycles(&recordings[0]), (0..6000).collect::<Vec<_>>());
    assert!(recordings[0].header.control_settings().is_err());
    assert!(!summary.recordings[0].settings);
}

#[test]
fn a_board_that_boots_again_gets_a_file_of_its_own() {
    let mut bench = Bench::new();
    let mut first = Board::boot(1);
    bench.hears(&first.announces(settings(100.0)));
    bench.hears(&first.runs(0..100));
    let mut second = Board::boot(2);
    bench.hears(&second.announces(settings(200.0)));
    bench.hears(&second.runs(0..50));
    let notes = bench.recorder.take_notes();
    assert!(
        notes[1].contains("boot 00000002") && notes[1].contains("run-2.mcap"),
        "{notes:?}"
    );
    let (_, recordings) = bench.finish();
    let lengths: Vec<usize> = recordings.iter().map(|r| r.cycles.len()).collect();
    assert_eq!(lengths, [100, 50]);
    for (recording, mass_kg) in recordings.iter().zip([100.0, 200.0]) {
        let control = recording.header.control_settings().unwrap();
        assert_eq!(control, settings(mass_kg).control);
    }
}

#[test]
fn two_boards_at_a_time_are_kept_apart() {
    let mut bench = Bench::new();
    let mut boards = [Board::boot(1), Board::boot(2)];
    for (board, mass_kg) in boards.iter_mut().zip([100.0, 200.0]) {
        bench.hears(&board.announces(settings(mass_kg)));
    }
    for cycle in 0..200 {
        for board in &mut boards {
            bench.hears(&board.runs([cycle]));
        }
    }
    let (_, recordings) = bench.finish();
    assert_eq!(recordings.len(), 2);
    for recording in &recordings {
        assert_eq!(cycles(recording), (0..200).collect::<Vec<_>>());
    }
}

/// A board with a broken supply.
#[test]
fn more_boots_than_are_kept_apart_lose_nothing() {
    let mut bench = Bench::new();
    for boot in 0..40 {
        let mut board = Board::boot(boot);
        bench.hears(&board.announces(settings(100.0)));
        bench.hears(&board.runs(0..3));
    }
    let (summary, recordings) = bench.finish();
    assert_eq!((recordings.len(), summary.cycles), (40, 120));
}

#[test]
fn other_settings_in_mid_run_begin_a_file() {
    let (mut board, mut bench) = (Board::boot(7), Bench::new());
    bench.hears(&board.announces(settings(100.0)));
    bench.hears(&board.runs(0..10));
    bench.hears(&board.announces(settings(200.0)));
    bench.hears(&board.runs(10..30));
    let (_, recordings) = bench.finish();
    let lengths: Vec<usize> = recordings.iter().map(|r| r.cycles.len()).collect();
    assert_eq!(lengths, [10, 20]);
    let control = recordings[1].header.control_settings().unwrap();
    assert_eq!(control, settings(200.0).control);
}

/// A run that is too long for one file: each piece is whole, has the settings, and begins where the one before ended.
#[test]
fn a_long_run_becomes_several_files() {
    let bounds = Bounds {
        file_cycles: 100,
        ..Bounds::default()
    };
    let (mut board, mut bench) = (Board::boot(7), Bench::within(bounds));
    bench.hears(&board.announces(settings(100.0)));
    bench.hears(&board.runs(0..300));
    let (summary, recordings) = bench.finish();
    let found: Vec<u64> = recordings.iter().flat_map(cycles).collect();
    assert_eq!(found, (0..300).collect::<Vec<_>>());
    assert_eq!(recordings.len(), 3);
    assert!(recordings.iter().all(|piece| piece.cut.is_none()));
    assert!(
        recordings
            .iter()
            .all(|piece| piece.header.control_settings().is_ok())
    );
    let continues: Vec<bool> = summary
        .recordings
        .iter()
        .map(|part| part.continues)
        .collect();
    assert_eq!(continues, [false, true, true]);
    let said = summary.recordings[1].to_string();
    assert!(
        said.contains("goes on from the file before with cycle 100"),
        "{said}"
    );
}

/// By its size a file is ended at the next look, a quarter of a second later at most.
#[test]
fn a_file_that_is_large_enough_is_ended() {
    let bounds = Bounds {
        file_bytes: 1,
        ..Bounds::default()
    };
    let (mut board, mut bench) = (Board::boot(7), Bench::within(bounds));
    bench.hears(&board.announces(settings(100.0)));
    bench.hears(&board.runs(0..192));
    let (_, recordings) = bench.finish();
    let lengths: Vec<usize> = recordings.iter().map(|piece| piece.cycles.len()).collect();
    assert_eq!(lengths, [64, 64, 64]);
}

/// Whoever can send to the recorder can make boots up; they get no more files than are allowed, and a board that
/// was there before goes on with its own.
#[test]
fn boots_that_are_made_up_fill_no_disk() {
    let bounds = Bounds {
        begun: 20,
        file_cycles: 50,
        ..Bounds::default()
    };
    let mut bench = Bench::within(bounds);
    let mut board = Board::boot(1);
    bench.hears(&board.announces(settings(100.0)));
    bench.hears(&board.runs(0..50));
    for boot in 2..200 {
        bench.hears(&Board::boot(boot).runs(0..1));
        bench.hears(&board.runs([u64::from(boot) + 48]));
    }
    let (summary, recordings) = bench.finish();
    let of_the_board = recordings
        .iter()
        .filter(|piece| piece.header.control_settings().is_ok());
    let kept: usize = of_the_board.clone().map(|piece| piece.cycles.len()).sum();
    assert_eq!((kept, of_the_board.count()), (248, 5));
    assert_eq!(recordings.len(), 5 + 19);
    assert_eq!(summary.dropped_cycles, 198 - 19);
}

/// Likewise settings that are announced in turn.
#[test]
fn settings_that_are_made_up_fill_no_disk() {
    let bounds = Bounds {
        begun: 20,
        ..Bounds::default()
    };
    let (mut board, mut bench) = (Board::boot(1), Bench::within(bounds));
    for turn in 0..100 {
        bench.hears(&board.announces(settings(100.0 + f64::from(turn % 2))));
        bench.hears(&board.runs([u64::try_from(turn).unwrap()]));
    }
    let (summary, recordings) = bench.finish();
    assert_eq!(recordings.len(), 20);
    let kept: usize = recordings.iter().map(|piece| piece.cycles.len()).sum();
    assert_eq!(summary.dropped_cycles, 100 - kept as u64);
}

#[test]
fn a_recording_ends_when_all_that_is_allowed_is_written() {
    let bounds = Bounds {
        total_bytes: 1,
        ..Bounds::default()
    };
    let (mut board, mut bench) = (Board::boot(7), Bench::within(bounds));
    bench.hears(&board.announces(settings(100.0)));
    bench.hears(&board.runs(0..63));
    let datagrams = board.runs(63..64);
    let outcomes = datagrams
        .iter()
        .map(|datagram| bench.recorder.accept(datagram, address()));
    let error = outcomes
        .into_iter()
        .find_map(Result::err)
        .unwrap()
        .to_string();
    assert!(error.contains("--max-gb allows more"), "{error}");
    let (_, recordings) = bench.finish();
    assert_eq!(recordings[0].cycles.len(), 64, "what was recorded is whole");
}

/// What was lost stands in the file too.
#[test]
fn the_metadata_tell_what_was_lost() {
    let (mut board, mut bench) = (Board::boot(0xab), Bench::new());
    bench.hears(&board.announces(settings(100.0)));
    bench.hears(&board.runs(5..15));
    board.runs(15..18);
    bench.hears(&board.runs(18..20));
    let path = bench.path("run.mcap");
    bench.recorder.finish().1.unwrap();
    let bytes = std::fs::read(path).unwrap();
    let records = mcap::read::LinearReader::new(&bytes).unwrap();
    let found = records.filter_map(|record| match record.unwrap() {
        mcap::records::Record::Metadata(metadata) => Some(metadata),
        _ => None,
    });
    let found: Vec<_> = found.filter(|metadata| metadata.name == METADATA).collect();
    let mut entries: BTreeMap<String, String> = found[0].metadata.clone();
    assert_eq!(
        entries.remove("recorder"),
        Some(softdock_io::identity::text())
    );
    let expected = [
        ("boot", "000000ab"),
        ("continues", "false"),
        ("cycles", "12"),
        ("first_cycle", "5"),
        ("lost_cycles", "3"),
        ("lost_datagrams", "3"),
        ("lost_on_board", "0"),
        // It has said nothing of itself.
        ("machine", ""),
        ("torn_records", "0"),
    ];
    assert_eq!(entries, expected.map(|(k, v)| (k.into(), v.into())).into());
}
