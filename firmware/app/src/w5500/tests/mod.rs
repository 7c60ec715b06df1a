//! Loss and return of the link, a start without a link, overrun, floods, and a chip that has lost its configuration: the robot is
//! answered again within ten cycles of 4 ms, each telegram in its own cycle.

mod emulated;
mod world;

use world::{Flood, World};

/// Cycles after which the robot is answered again.
const CYCLES: usize = 10;
/// Frames of 60 bytes at 100 Mbit/s: with checksum, preamble and gap 84 bytes each.
const LINE_RATE: Flood = Flood {
    period_ns: 6_720,
    bytes: 60,
};

fn running() -> World {
    let mut world = World::new(true);
    assert_answers_again(&mut world);
    assert_eq!(world.health.get().ethernet.overruns, 0);
    world
}

/// Within ten cycles, and from then on always.
fn assert_answers_again(world: &mut World) {
    let answered = world.cycles(100);
    let again = answered.iter().position(|answered| *answered);
    assert!(again.is_some_and(|cycles| cycles < CYCLES), "{again:?}");
    let last = answered.iter().rposition(|answered| !answered);
    assert!(last.is_none_or(|cycles| cycles < CYCLES), "{last:?}");
}

#[test]
fn a_board_that_starts_without_a_link_answers_when_it_comes() {
    let mut world = World::new(false);
    assert!(!world.cycles(250).contains(&true));
    assert!(world.health.get().answers && !world.health.get().ethernet.link);
    world.plug(true);
    assert_answers_again(&mut world);
    assert_eq!(world.health.get().ethernet.losses, 0);
}

#[test]
fn a_link_that_was_out_is_left_behind() {
    let mut world = running();
    // From an interruption that no check notices to one of a second.
    for cycles in [0, 1, 2, 3, 10, 250] {
        world.plug(false);
        assert!(!world.cycles(cycles).contains(&true));
        let before = world.chip.borrow().sent.len();
        world.plug(true);
        assert_answers_again(&mut world);
        // No answer to an earlier telegram is sent when the link is back.
        let sent = world.chip.borrow().sent.len() - before;
        assert!(sent <= 100, "{sent} answers to 100 telegrams");
    }
    // Interruptions longer than the time between two checks are all counted.
    let losses = world.health.get().ethernet.losses;
    assert!((3..=5).contains(&losses), "{losses}");
}

#[test]
fn the_network_is_told_of_the_link() {
    let mut world = World::new(false);
    for link in [false, true, false, true] {
        world.plug(link);
        world.quiet(10);
        assert_eq!(world.is_up(), link);
    }
}

/// A quiet network is not mistaken for a stuck chip, and the chip is not polled repeatedly.
#[test]
fn a_quiet_network_leaves_chip_and_bus_alone() {
    let mut world = running();
    let before = world.chip.borrow().transactions;
    world.quiet(250);
    assert_eq!(world.health.get().ethernet.overruns, 0);
    let transactions = world.chip.borrow().transactions - before;
    assert!(transactions < 1000, "{transactions} in a second");
    assert_answers_again(&mut world);
}

#[test]
fn a_frame_that_leaves_late_is_not_given_up() {
    let mut world = running();
    world.chip.borrow_mut().jammed = true;
    // One check, and less than two.
    world.cycles(3);
    world.release();
    assert_answers_again(&mut world);
    assert_eq!(world.health.get().ethernet.overruns, 0);
}

/// Frames that came unnoticed, up to more than the chip holds.
#[test]
fn an_overrun_of_the_receiver_is_left_behind() {
    for bytes in [60, 590, 1514] {
        for count in [1, 2, 10, 20, 100, 1000] {
            let mut world = running();
            world.burst(count, bytes);
            assert_answers_again(&mut world);
            assert!(!world.chip.borrow().waits(), "{count} frames of {bytes}");
        }
    }
}

#[test]
fn a_flood_at_line_rate_is_left_behind() {
    for bytes in [60, 590, 1514] {
        let mut world = running();
        world.flood = Some(Flood {
            period_ns: LINE_RATE.period_ns * (bytes as u64 + 24) / 84,
            bytes,
        });
        world.cycles(250);
        assert!(world.health.get().ethernet.overruns > 0, "{bytes}");
        world.flood = None;
        assert_answers_again(&mut world);
    }
}

/// Within the capacity of the bus, an answer is sent between any two received frames.
#[test]
fn in_a_flood_that_the_bus_can_carry_each_telegram_is_answered() {
    let mut world = running();
    world.flood = Some(Flood {
        period_ns: 150_000,
        bytes: 60,
    });
    assert_eq!(world.cycles(250), [true; 250]);
    assert_eq!(world.health.get().ethernet.overruns, 0);
}

#[test]
fn a_length_that_cannot_be_is_left_behind() {
    for length in [0, 1, 2, 15, 1517, 0xFFFF] {
        let mut world = running();
        world.burst(1, 60);
        world.chip.borrow_mut().spoil(length);
        assert_answers_again(&mut world);
        assert_eq!(world.health.get().ethernet.overruns, 1, "{length}");
    }
}

#[test]
fn a_chip_that_has_forgotten_everything_is_told_again() {
    let mut world = running();
    world.chip.borrow_mut().forget();
    assert_answers_again(&mut world);
    assert_eq!(world.health.get().ethernet.overruns, 1);
}

#[test]
fn a_chip_that_comes_late_or_goes_is_found_again() {
    let mut world = World::new(true);
    for _ in 0..3 {
        world.chip.borrow_mut().present = false;
        assert!(!world.cycles(50).contains(&true));
        assert!(!world.health.get().answers && !world.health.get().ethernet.link);
        world.chip.borrow_mut().present = true;
        world.chip.borrow_mut().forget();
        assert_answers_again(&mut world);
        assert!(world.health.get().answers && world.health.get().ethernet.link);
    }
    // The first time there was no link to lose.
    assert_eq!(world.health.get().ethernet.losses, 2);
}

/// A link in one direction: no frame is sent.
#[test]
fn frames_that_do_not_leave_are_given_up() {
    let mut world = running();
    world.chip.borrow_mut().jammed = true;
    assert!(!world.cycles(100).contains(&true));
    assert!(world.health.get().ethernet.overruns > 5);
    world.chip.borrow_mut().jammed = false;
    assert_answers_again(&mut world);
}
