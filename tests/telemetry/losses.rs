//! What is lost is counted, and nothing else is.

use super::board::{Bench, Board, cycles, settings};
use proptest::prelude::*;

#[test]
fn what_the_board_had_no_room_for_is_told_apart_from_the_network() {
    let (mut board, mut bench) = (Board::boot(7), Bench::new());
    // A recorder that is started later does not count what was lost before.
    board.stream.set_lost(1000);
    bench.hears(&board.announces(settings(100.0)));
    bench.hears(&board.runs(2000..2010));
    board.stream.set_lost(1005);
    bench.hears(&board.runs(2015..2020));
    board.runs([2020]);
    bench.hears(&board.runs([2021]));
    let (summary, _) = bench.finish();
    let part = &summary.recordings[0];
    assert_eq!((part.cycles, part.lost_cycles), (16, 6));
    assert_eq!((part.lost_on_board, part.lost_datagrams), (5, 1));
}

/// The last records are missing: the announcement after them shows it.
#[test]
fn a_loss_at_the_end_shows() {
    let (mut board, mut bench) = (Board::boot(7), Bench::new());
    bench.hears(&board.announces(settings(100.0)));
    bench.hears(&board.runs(0..10));
    board.runs(10..14);
    bench.hears(&board.announces(settings(100.0)));
    let (summary, _) = bench.finish();
    let part = &summary.recordings[0];
    assert_eq!((part.lost_cycles, part.lost_datagrams), (0, 4));
    let said = part.to_string();
    assert!(
        said.contains("after them 0 had no room on the board, 4 datagrams"),
        "{said}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Datagrams are dropped, repeated and come late; what is recorded is in order, and the
    /// numbers add up.
    #[test]
    fn dropped_cycles_are_counted(fates in prop::collection::vec((0..12_u8, 0..40_usize), 2..400)) {
        let (mut board, mut bench) = (Board::boot(7), Bench::new());
        bench.hears(&board.announces(settings(100.0)));
        let (mut sent, mut kept) = (Vec::new(), Vec::new());
        for (cycle, (fate, later)) in (0..).zip(&fates) {
            let datagram = board.runs([cycle]).remove(0);
            let place = cycle as usize;
            match fate {
                0 => continue,
                1 => sent.extend([(place, datagram.clone()), (place + later, datagram)]),
                2 => sent.push((place + later, datagram)),
                _ => sent.push((place, datagram)),
            }
            kept.push(cycle);
        }
        prop_assume!(!kept.is_empty());
        let repeated = (sent.len() - kept.len()) as u64;
        sent.sort_by_key(|(place, _)| *place);
        let sent: Vec<_> = sent.into_iter().map(|(_, datagram)| datagram).collect();
        bench.hears(&sent);
        let (summary, recordings) = bench.finish();
        prop_assert_eq!(cycles(&recordings[0]), kept.clone());
        let part = &summary.recordings[0];
        let (first, last) = (kept[0], kept[kept.len() - 1]);
        prop_assert_eq!(part.lost_cycles, last - first + 1 - kept.len() as u64);
        prop_assert_eq!(part.lost_datagrams, last + 1 - kept.len() as u64);
        prop_assert_eq!(summary.repeated_datagrams, repeated);
        prop_assert_eq!(part.torn_records, 0);
    }
}
