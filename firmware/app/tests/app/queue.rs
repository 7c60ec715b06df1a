//! Several datagrams that wait at the same time.

use crate::bench::{Bench, CRUISE_COUNTS, CYCLE_US, counts, flying, robot, stranger};
use crate::world::Event;
use softdock_control::io::Sequence;

const CYCLE_MS: u64 = CYCLE_US / 1000;

#[test]
fn the_newest_of_two_is_answered() {
    let mut bench = Bench::cruising(&flying());
    let ipoc = bench.says.ipoc;
    let (older, newer) = (bench.telegram(), bench.telegram_at(ipoc + CYCLE_MS));
    let answers = bench.datagrams(&[(&older, robot()), (&newer, robot())]);
    assert_eq!(answers.len(), 1);
    let answer = bench.parse(&answers[0]);
    assert_eq!(answer.ipoc, ipoc + CYCLE_MS);
    assert!((counts(&answer)[0] - CRUISE_COUNTS).abs() <= 1);
    assert_eq!(bench.last_record().inputs.robot.sequence, Sequence::Gap(1));
    let link = bench.status().link;
    assert_eq!((link.overtaken, link.lost), (1, 1));
}

/// The order in which the robot sent them counts, not the order of arrival.
#[test]
fn one_that_was_overtaken_on_its_way_does_not_displace_the_newer_one() {
    let mut bench = Bench::cruising(&flying());
    let ipoc = bench.says.ipoc;
    let (older, newer) = (bench.telegram(), bench.telegram_at(ipoc + CYCLE_MS));
    let answers = bench.datagrams(&[(&newer, robot()), (&older, robot())]);
    assert_eq!(answers.len(), 1);
    assert_eq!(bench.parse(&answers[0]).ipoc, ipoc + CYCLE_MS);
    assert_eq!(bench.last_record().inputs.robot.sequence, Sequence::Gap(1));
    let link = bench.status().link;
    assert_eq!((link.overtaken, link.lost), (1, 1));
}

#[test]
fn strangers_in_the_queue_do_not_displace_the_robot() {
    for robot_at in 0..4 {
        let mut bench = Bench::cruising(&flying());
        let before = bench.status().link;
        let (ipoc, telegram) = (bench.says.ipoc, bench.telegram());
        let foreign = bench.telegram_at(5);
        let mut queue = [(foreign.as_slice(), stranger()); 4];
        queue[robot_at] = (&telegram, robot());
        let answers = bench.datagrams(&queue);
        assert_eq!(answers.len(), 1);
        assert_eq!(answers[0].to, robot());
        assert_eq!(bench.parse(&answers[0]).ipoc, ipoc);
        let link = bench.status().link;
        assert_eq!((link.overtaken, link.lost), (0, 0));
        assert_eq!(link.foreign, before.foreign + 3);
        assert_eq!(link.cycles, before.cycles + 1);
    }
}

/// The first sender that sends a telegram is the robot, not the last one in the queue.
#[test]
fn the_first_of_two_senders_is_the_robot() {
    let mut bench = Bench::new(&flying(), false);
    let telegram = bench.telegram();
    let queue = [
        (&b"hello"[..], stranger()),
        (&telegram, robot()),
        (&telegram, stranger()),
    ];
    let answers = bench.datagrams(&queue);
    assert_eq!(answers.len(), 1);
    assert_eq!(answers[0].to, robot());
}

#[test]
fn what_cannot_be_read_does_not_displace_a_telegram() {
    let mut bench = Bench::cruising(&flying());
    let (ipoc, telegram) = (bench.says.ipoc, bench.telegram());
    let answers = bench.datagrams(&[(&telegram, robot()), (b"<Rob>", robot())]);
    assert_eq!(answers.len(), 1);
    assert_eq!(bench.parse(&answers[0]).ipoc, ipoc);
    let link = bench.status().link;
    assert_eq!((link.overtaken, link.malformed), (0, 1));
}

#[test]
fn a_duplicate_in_the_queue_is_one_cycle() {
    let mut bench = Bench::cruising(&flying());
    let before = bench.status().link;
    let telegram = bench.telegram();
    let answers = bench.datagrams(&[(&telegram, robot()), (&telegram, robot())]);
    assert_eq!(answers.len(), 1);
    assert!((counts(&bench.parse(&answers[0]))[0] - CRUISE_COUNTS).abs() <= 1);
    let link = bench.status().link;
    assert_eq!((link.cycles, link.overtaken), (before.cycles + 1, 1));
}

#[test]
fn a_flood_of_strangers_ends_and_the_robot_is_answered() {
    let mut bench = Bench::cruising(&flying());
    let before = bench.status().link;
    let (telegram, foreign) = (bench.telegram(), bench.telegram_at(5));
    let mut queue = vec![(foreign.as_slice(), stranger()); 1000];
    queue.push((&telegram, robot()));
    queue.extend(vec![(foreign.as_slice(), stranger()); 1000]);
    let answers = bench.datagrams(&queue);
    assert_eq!(answers.len(), 1);
    assert_eq!(answers[0].to, robot());
    let link = bench.status().link;
    assert_eq!(link.foreign, before.foreign + 2000);
    assert_eq!(link.cycles, before.cycles + 1);
}

#[test]
fn a_flood_behind_a_telegram_does_not_hold_its_answer_up() {
    let mut bench = Bench::cruising(&flying());
    let ipoc = bench.says.ipoc;
    let (telegram, foreign) = (bench.telegram(), bench.telegram_at(5));
    let newer = bench.telegram_at(ipoc + CYCLE_MS);
    let mut queue = vec![(telegram.as_slice(), robot())];
    queue.extend(vec![(foreign.as_slice(), stranger()); 100]);
    queue.push((&newer, robot()));
    let answers = bench.datagrams(&queue);
    let ipocs: Vec<u64> = answers.iter().map(|a| bench.parse(a).ipoc).collect();
    assert_eq!(ipocs, [ipoc, ipoc + CYCLE_MS]);
}

/// The robot's waiting time begins when it sends, not when the board reads the telegram from its queue. Here the board still
/// waits for the sample of the previous telegram.
#[test]
fn the_time_in_the_queue_belongs_to_an_answer() {
    let mut bench = Bench::new(&flying(), false);
    bench.cycles(3);
    let alone_us = bench.shared.machine().answers.longest_us;
    assert!(alone_us > 200, "{alone_us}");
    let (ipoc, came_us) = (bench.says.ipoc, bench.next_at_us + 50);
    let second = Event::Datagram(bench.telegram_at(ipoc + CYCLE_MS), robot());
    bench.world().schedule(came_us, second);
    let first = bench.telegram();
    let answers = bench.datagrams(&[(&first, robot())]);
    assert_eq!(answers.len(), 2);
    let took_us = answers[1].at_us - came_us;
    assert!(took_us > u64::from(alone_us) + 100, "{took_us}");
    assert_eq!(
        u64::from(bench.shared.machine().answers.longest_us),
        took_us
    );
}
