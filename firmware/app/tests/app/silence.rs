//! A robot that stops sending.

use crate::bench::{Bench, CYCLE_US, counts, flying};
use softdock_control::modes::{Command, FaultCode, Mode};

#[test]
fn silence_shows_after_three_cycles() {
    let mut bench = Bench::new(&flying(), false);
    assert!(!bench.status().connected);
    bench.cycle();
    let heard_us = bench.next_at_us - CYCLE_US;
    bench.run_to(heard_us + 3 * CYCLE_US - 1);
    assert!(bench.status().connected);
    bench.run_to(heard_us + 3 * CYCLE_US);
    assert!(!bench.status().connected);
    bench.run_to(heard_us + 1000 * CYCLE_US);
    assert!(!bench.status().connected);
    bench.lose(1000);
    bench.cycle();
    assert!(bench.status().connected);
}

#[test]
fn nothing_is_sent_into_silence_and_the_loop_does_not_go_on_after_it() {
    let mut bench = Bench::cruising(&flying());
    let sent = bench.world().answers.len();
    bench.lose(99);
    bench.run_to(bench.next_at_us - 1);
    assert_eq!(bench.world().answers.len(), sent);
    assert_eq!(counts(&bench.cycle()), [0; 6]);
    bench.assert_fault(FaultCode::TelegramsLost, 10.0, 99.0);
}

#[test]
fn commands_from_before_a_new_run_are_dropped() {
    let mut bench = Bench::new(&flying(), false);
    for command in [Command::Hold, Command::Arm, Command::Start] {
        bench.shared.commands.try_send(command).unwrap();
    }
    bench.cycles(10);
    assert_eq!(bench.status().mode, Mode::Idle);
    // Within a run, commands are executed one by one.
    for command in [Command::Hold, Command::Arm, Command::Start] {
        bench.shared.commands.try_send(command).unwrap();
    }
    for mode in [Mode::Hold, Mode::Armed, Mode::Running, Mode::Running] {
        bench.cycle();
        assert_eq!(bench.status().mode, mode);
    }
}
