//! Which sender is the robot, and which datagrams are telegrams: other computers, malformed and oversize datagrams.

use crate::bench::{Bench, CYCLE_US, FIRST_TELEGRAM_US, counts, flying, robot, stranger};
use crate::sensor::Behaviour;
use crate::world::{Event, Sent};
use softdock_app::robot::TELEGRAM_BYTES;
use softdock_control::io::Sequence;
use softdock_control::modes::{FaultCode, Mode};
use softdock_control::settings::CorrectionMode;
use std::net::SocketAddr;

/// Another program on the robot's computer.
fn other_port() -> SocketAddr {
    SocketAddr::new(robot().ip(), robot().port() + 1)
}

/// A run of 60 cycles; `foreign` sends datagrams in the middle of each.
fn run_with(foreign: Option<SocketAddr>) -> Bench {
    let mut bench = Bench::new(&flying(), true);
    bench.cycle();
    for _ in 1..60 {
        if let Some(from) = foreign {
            // From the robot, this telegram would begin a new run.
            let telegram = bench.telegram_at(5);
            let at_us = bench.next_at_us - CYCLE_US / 2;
            for bytes in [telegram, b"<Rob>".to_vec(), Vec::new()] {
                bench.world().schedule(at_us, Event::Datagram(bytes, from));
            }
        }
        bench.cycle();
    }
    bench
}

#[test]
fn strangers_get_no_answer_and_change_nothing() {
    let alone = run_with(None);
    for from in [stranger(), other_port()] {
        let bench = run_with(Some(from));
        assert_eq!(bench.world().answers, alone.world().answers);
        assert_eq!(bench.world().records, alone.world().records);
        let expected = softdock_app::shared::LinkCounters {
            foreign: 3 * 59,
            ..alone.status().link
        };
        assert_eq!(bench.status().link, expected);
    }
    assert_eq!(alone.status().mode, Mode::Running);
}

#[test]
fn only_the_configured_address_is_the_robot() {
    let mut settings = flying();
    settings.rsi.robot_ip = "192.168.1.10".parse().unwrap();
    let mut bench = Bench::new(&settings, false);
    let telegram = bench.telegram();
    assert_eq!(bench.datagram(&telegram, stranger()), None);
    assert_eq!(bench.status().link.foreign, 1);
    assert!(!bench.status().connected);
    // The settings do not fix the port.
    let telegram = bench.telegram();
    assert!(bench.datagram(&telegram, other_port()).is_some());
    // However long the robot is silent, no other sender replaces it.
    bench.lose(1000);
    let telegram = bench.telegram();
    assert_eq!(bench.datagram(&telegram, stranger()), None);
}

#[test]
fn another_sender_becomes_the_robot_after_a_silence_only() {
    let mut bench = Bench::cruising(&flying());
    // 100 cycles are 0.4 s; the next sender comes 0.4 s after the last telegram.
    bench.lose(99);
    let telegram = bench.telegram();
    assert_eq!(bench.datagram(&telegram, stranger()), None);
    // Its time stamp is the one that the robot would send next.
    let ipoc = bench.last_record().inputs.robot.counter + 4;
    let telegram = bench.telegram_at(ipoc);
    let answer = bench.datagram(&telegram, stranger()).unwrap();
    assert_eq!(answer.to, stranger());
    let answer = bench.parse(&answer);
    assert_eq!((answer.ipoc, counts(&answer)), (ipoc, [0; 6]));
    bench.assert_fault(FaultCode::RobotRestarted, 0.0, 0.0);
    let telegram = bench.telegram();
    assert_eq!(bench.datagram(&telegram, robot()), None);
}

/// A telegram whose pose is damaged and whose time stamp is whole.
fn damaged(bench: &Bench) -> Vec<u8> {
    let text = String::from_utf8(bench.telegram()).unwrap();
    text.replace("X=\"1000", "X=\"1O00").into_bytes()
}

#[test]
fn a_malformed_telegram_rests() {
    let mut bench = Bench::cruising(&flying());
    let cycles = bench.status().link.cycles;
    let (ipoc, bytes) = (bench.says.ipoc, damaged(&bench));
    let answer = bench.datagram(&bytes, robot()).unwrap();
    let answer = bench.parse(&answer);
    assert_eq!((answer.ipoc, counts(&answer)), (ipoc, [0; 6]));
    let link = bench.status().link;
    assert_eq!((link.malformed, link.cycles), (1, cycles));
    bench.cycle();
    assert_eq!(bench.last_record().inputs.robot.sequence, Sequence::Gap(1));
    assert_eq!(bench.status().mode, Mode::Running);
}

#[test]
fn a_malformed_telegram_holds_the_absolute_offset() {
    let mut settings = flying();
    settings.control.robot.correction_mode = CorrectionMode::Absolute;
    let mut bench = Bench::cruising(&settings);
    let offset = counts(&bench.cycle());
    assert_ne!(offset, [0; 6]);
    let bytes = damaged(&bench);
    let answer = bench.datagram(&bytes, robot()).unwrap();
    assert_eq!(counts(&bench.parse(&answer)), offset);
}

#[test]
fn what_cannot_be_answered_is_not() {
    let mut bench = Bench::cruising(&flying());
    let whole = bench.telegram();
    let without_end = &whole[..whole.len() - 10];
    let two_stamps = [whole.as_slice(), whole.as_slice()].concat();
    for bytes in [&b""[..], b"hello", &[0xff; 100], without_end, &two_stamps] {
        assert_eq!(bench.datagram(bytes, robot()), None);
    }
    assert_eq!(bench.status().link.malformed, 5);
    // A malformed telegram does not make its sender the robot.
    let mut bench = Bench::new(&flying(), false);
    let bytes = damaged(&bench);
    assert_eq!(bench.datagram(&bytes, stranger()), None);
    bench.cycle();
    assert_eq!(bench.status().link.foreign, 0);
}

/// The duplicate of a telegram gets the same answer, even after a malformed telegram in between.
#[test]
fn a_malformed_telegram_leaves_the_last_answer_alone() {
    let mut bench = Bench::cruising(&flying());
    let telegram = bench.telegram();
    let first = bench.datagram(&telegram, robot()).unwrap();
    let bytes = damaged(&bench);
    assert!(bench.datagram(&bytes, robot()).is_some());
    let again = bench.datagram(&telegram, robot()).unwrap();
    assert_eq!(again.bytes, first.bytes);
}

/// A robot that sends nothing but malformed telegrams is not silent.
#[test]
fn a_malformed_telegram_keeps_the_connection() {
    let mut bench = Bench::new(&flying(), false);
    bench.cycle();
    for _ in 0..200 {
        let bytes = damaged(&bench);
        assert!(bench.datagram(&bytes, robot()).is_some());
        assert!(bench.status().connected);
    }
    let telegram = bench.telegram();
    assert_eq!(bench.datagram(&telegram, stranger()), None);
}

#[test]
fn a_request_to_stop_does_not_flicker() {
    let mut settings = flying();
    settings.control.limits.torque_n_m = 20.0;
    let mut bench = Bench::cruising(&settings);
    bench.world().sensor.gauges[3] = 31_000;
    assert!(bench.cycle().stop);
    let bytes = damaged(&bench);
    let answer = bench.datagram(&bytes, robot()).unwrap();
    assert!(bench.parse(&answer).stop);
}

/// A telegram with a comment that makes it `length` bytes long; the time stamp stands at the end
/// or before the comment.
fn padded(bench: &Bench, length: usize, stamp_last: bool) -> Vec<u8> {
    let text = String::from_utf8(bench.telegram()).unwrap();
    let filler = "<F/>".repeat(length);
    let mark = if stamp_last { "<IPOC>" } else { "</Rob>" };
    let (head, tail) = text.split_at(text.find(mark).unwrap());
    let room = length - text.len();
    let spaces = " ".repeat(room % 4);
    format!("{head}{}{spaces}{tail}", &filler[..room - room % 4]).into_bytes()
}

#[test]
fn a_telegram_may_fill_the_buffer_and_no_more() {
    let mut bench = Bench::new(&flying(), false);
    bench.cycle();
    let bytes = padded(&bench, TELEGRAM_BYTES, true);
    assert_eq!(bytes.len(), TELEGRAM_BYTES);
    assert!(bench.datagram(&bytes, robot()).is_some());
    assert_eq!(bench.status().link.cycles, 2);
    for length in [TELEGRAM_BYTES + 1, 9000] {
        let bytes = padded(&bench, length, false);
        let answer: Option<Sent> = bench.datagram(&bytes, robot());
        let answer = bench.parse(&answer.unwrap());
        assert_eq!((answer.ipoc, counts(&answer)), (bench.last_ipoc(), [0; 6]));
        // Now the cut takes the time stamp.
        let bytes = padded(&bench, length + 20, true);
        assert_eq!(bench.datagram(&bytes, robot()), None);
    }
    let link = bench.status().link;
    assert_eq!((link.malformed, link.cycles), (4, 2));
}

/// An answer without a sensor and at the very first telegram.
#[test]
fn the_first_telegram_is_answered_without_a_sensor() {
    let mut bench = Bench::switched_on(&flying(), false);
    bench.world().sensor.behaviour = Behaviour::Silent;
    bench.run_to(FIRST_TELEGRAM_US - 1);
    assert_eq!(counts(&bench.cycle()), [0; 6]);
}
