//! The checks before a test.

use super::*;
use crate::shared::{LastSample, LastTelegram, Shared};
use crate::store::tests::flash::Flash;
use embassy_futures::block_on;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use softdock_link::service::{Health, RobotHealth, SensorHealth, StackUse};

fn health(desk: &mut Desk) -> Health {
    assert_eq!(desk.ask(&Request::Health), Outcome::Answer);
    desk.said(|_, payload| match postcard::from_bytes(payload) {
        Ok(Answer::Health(health)) => health,
        other => panic!("{other:?}"),
    })
}

#[test]
fn robot_and_sensor_are_told_as_of_their_last_word() {
    let mut desk = Desk::new(kept());
    let nothing = health(&mut desk);
    assert_eq!((nothing.robot, nothing.sensor), (None, None));
    desk.now.us = 7_300_000;
    desk.now.status.link.cycles = 9;
    desk.now.status.telegram = Some(LastTelegram {
        late_answers: 3,
        status: 2,
        pose: true,
    });
    desk.now.status.sample = Some(LastSample {
        counter: 8,
        at_us: 7_295_000,
        status: 0x4000,
        saturated: true,
    });
    let expected = Health {
        uptime_ms: 7_300,
        cycles: 9,
        robot: Some(RobotHealth {
            late_answers: 3,
            poscorr_stat: 2,
            pose: true,
        }),
        sensor: Some(SensorHealth {
            counter: 8,
            age_ms: 5,
            status: 0x4000,
            saturated: true,
        }),
    };
    assert_eq!(health(&mut desk), expected);
}

#[test]
fn the_board_itself_is_told_as_the_tasks_have_left_it() {
    let mut desk = Desk::new(kept());
    assert_eq!(desk.ask(&Request::Machine), Outcome::Job(Job::Machine));
    let shared: Shared<NoopRawMutex> = Shared::new();
    shared.update_machine(|machine| {
        machine.reset = "watchdog";
        machine.stack = Some(StackUse {
            deepest: 80_000,
            available: 131_072,
        });
        machine.answers.take(260, 4000);
    });
    desk.session.machine(&shared.machine());
    desk.said(|_, payload| match postcard::from_bytes(payload) {
        Ok(Answer::Machine(machine)) => {
            assert_eq!(machine.reset, "watchdog");
            assert_eq!(machine.stack.unwrap().deepest, 80_000);
            assert_eq!(
                (machine.answers.longest_us, machine.answers.histogram[1]),
                (260, 1)
            );
        }
        other => panic!("{other:?}"),
    });
}

/// The longest reasons still fit into a frame.
#[test]
fn slots_are_told_with_what_is_wrong_in_them() {
    let mut desk = Desk::new(kept());
    let schema = ImageError::Schema {
        expected: u32::MAX,
        received: u32::MAX,
    };
    for (found, expected) in [
        (
            [Ok(4), Err(ImageError::Absent)],
            "[Kept { sequence: 4 }, Empty]",
        ),
        (
            [Err(ImageError::NotConfirmed), Ok(7)],
            "[NotConfirmed, Kept { sequence: 7 }]",
        ),
        ([Err(schema), Err(schema)], "schema ffffffff in place of"),
    ] {
        assert_eq!(desk.ask(&Request::Slots), Outcome::Job(Job::Slots));
        desk.session.slots(&found);
        let said = desk.said(|_, payload| {
            format!("{:?}", postcard::from_bytes::<Answer<'_>>(payload).unwrap())
        });
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn a_store_knows_its_slots() {
    let mut flash = Flash::erased();
    let mut block = [0; IMAGE_MAX_BYTES];
    let mut store = Store::new(&mut flash);
    let none = [Err(ImageError::Absent), Err(ImageError::Absent)];
    assert_eq!(block_on(store.slots(&mut block)), none);
    let in_use = defaults().origin;
    let written = block_on(store.write(&with_mass(22.0), &in_use, 30, &mut block));
    let on_trial = [Err(ImageError::NotConfirmed), Err(ImageError::Absent)];
    assert_eq!(block_on(store.slots(&mut block)), on_trial);
    block_on(store.confirm(&written.unwrap(), &mut block)).unwrap();
    let kept = [Ok(1), Err(ImageError::Absent)];
    assert_eq!(block_on(store.slots(&mut block)), kept);
}
