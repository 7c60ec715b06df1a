//! Each cycle is recorded exactly once.

use crate::bench::{Bench, CYCLE_US, flying, robot, stranger};
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

/// Statistics of the answers, on a board that cannot count its processor's cycles.
#[test]
fn answers_are_measured_against_the_cycle_of_the_robot() {
    let mut bench = Bench::new(&flying(), false);
    bench.cycles(300);
    let machine = bench.shared.machine();
    assert_eq!(machine.answers.histogram.iter().sum::<u32>(), 300);
    assert!(u64::from(machine.answers.longest_us) < CYCLE_US);
    assert_eq!(machine.answers.late_answers(), 0);
    assert!((machine.inputs.cycle_us - CYCLE_US as f32).abs() < 1.0);
    assert_eq!(machine.work, None);
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
