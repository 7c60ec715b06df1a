//! Every sequence of events from every mode, against the table of docs/modes.md.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a helper of a test fails the test"
)]

mod event;
mod rig;
mod table;

use event::Event;
use rig::{Rig, Row};
use std::thread;
use table::Table;

/// Tries all sequences of up to `depth` more events, and returns their number.
fn explore(rig: &Rig, table: &Table, path: &mut Vec<Event>, depth: usize) -> u64 {
    if depth == 0 {
        return 1;
    }
    let before = rig.row();
    let mut tried = 1;
    for event in Event::all() {
        let mut next = rig.clone();
        path.push(event);
        event.happen(&mut next);
        let (found, expected) = (next.row(), table.next(before, event));
        // A stop in the two zero cycles of a start, or at the turning points of a jog, is complete at once.
        let at_rest = (expected, found) == (Row::Stopping, Row::Hold);
        assert!(
            found == expected || at_rest,
            "{before:?} goes to {found:?}, not to {expected:?}, after {path:?}"
        );
        assert!(
            !next.moved || before.moves() || found.moves(),
            "the robot moved in {before:?}, after {path:?}"
        );
        tried += explore(&next, table, path, depth - 1);
        path.pop();
    }
    tried
}

/// Starts from every row of the table, in parallel.
fn explore_all(depth: usize) -> u64 {
    let table = Table::read();
    thread::scope(|scope| {
        let table = &table;
        let workers = Row::ALL.map(|row| {
            scope.spawn(move || explore(&Rig::in_row(row), table, &mut Vec::new(), depth))
        });
        workers.map(|worker| worker.join().unwrap()).iter().sum()
    })
}

#[test]
fn every_sequence_of_three_events_follows_the_table() {
    let events = Event::all().count() as u64;
    let sequences: u64 = (0..=3).map(|length| events.pow(length)).sum();
    assert_eq!(explore_all(3), 8 * sequences);
}

#[test]
#[ignore = "long: every sequence of four events from every mode"]
fn every_sequence_of_four_events_follows_the_table() {
    let tried = explore_all(4);
    println!("{tried} sequences");
}
