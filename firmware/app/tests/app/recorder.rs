//! Each cycle is recorded once, whatever happens around it.

use crate::bench::{Bench, flying, robot, stranger};
use crate::world::Event;

#[test]
fn each_cycle_is_recorded_once() {
    let mut bench = Bench::new(&flying(), true);
    for round in 0..40 {
        let telegram = bench.telegram();
        bench.cycle();
        match round % 4 {
            0 => drop(bench.datagram(&telegram, robot())),
            1 => drop(bench.datagram(b"<Rob>", robot())),
            2 => drop(bench.datagram(&telegram, stranger())),
            _ => bench.lose(2),
        }
    }
    let world = bench.world();
    let cycles: Vec<u64> = world.records.iter().map(|r| r.trace.cycle).collect();
    assert_eq!(cycles, (0..40).collect::<Vec<u64>>());
    let ipocs = world.records.windows(2).map(|pair| {
        let [a, b] = pair else { panic!() };
        a.inputs.robot.counter < b.inputs.robot.counter
    });
    assert!(ipocs.min().unwrap());
}

/// The socket closes between a telegram and its answer.
#[test]
fn the_last_cycle_is_recorded_too() {
    let mut bench = Bench::new(&flying(), false);
    bench.cycles(3);
    bench.world().schedule(bench.next_at_us + 100, Event::Close);
    let telegram = bench.telegram();
    assert_eq!(bench.datagram(&telegram, robot()), None);
    assert!(bench.tasks.iter().all(|task| task.has_ended()));
    assert_eq!(bench.world().records.len(), 4);
    assert_eq!(bench.status().link.cycles, 4);
}
