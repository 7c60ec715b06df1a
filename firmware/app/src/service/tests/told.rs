//! Reports of the board, and answers to jobs.

use super::*;
use crate::store::StoreError;
use softdock_control::modes::{Fault, FaultCode, Refusal as ModeRefusal};
use softdock_link::sensor::SensorState;
use softdock_link::service::{Counters, LoopBack, SelfTest, Status};

impl Desk {
    fn told(&self) -> String {
        self.said(|_, payload| {
            format!("{:?}", postcard::from_bytes::<Answer<'_>>(payload).unwrap())
        })
    }

    fn status(&mut self) -> Status {
        assert_eq!(self.ask(&Request::Status), Outcome::Answer);
        self.said(|_, payload| match postcard::from_bytes(payload) {
            Ok(Answer::Status(status)) => status,
            other => panic!("{other:?}"),
        })
    }

    fn log(&mut self) -> Vec<String> {
        let mut all: Vec<String> = Vec::new();
        loop {
            self.ask(&Request::Log(all.len() as u32));
            let lines = self.said(|_, payload| match postcard::from_bytes(payload) {
                Ok(Answer::Log(lines)) => lines
                    .into_iter()
                    .map(|line| line.text.to_string())
                    .collect(),
                other => panic!("{other:?}"),
            });
            match Vec::is_empty(&lines) {
                true => return all,
                false => all.extend(lines),
            }
        }
    }

    fn counters(&mut self) -> Counters {
        assert_eq!(self.ask(&Request::Counters), Outcome::Answer);
        self.said(|_, payload| match postcard::from_bytes(payload) {
            Ok(Answer::Counters(counters)) => counters,
            other => panic!("{other:?}"),
        })
    }
}

#[test]
fn a_status_says_what_the_tasks_have_left() {
    let mut desk = Desk::new(kept());
    let status = &mut desk.now.status;
    status.mode = Mode::Fault;
    status.sensor = Some(SensorState::Running);
    status.fault = Some(Fault::new(FaultCode::SensorStale, 5.0, 6.0));
    status.refusal = Some((Command::Arm, ModeRefusal::SensorStale));
    status.commands = 3;
    desk.now.us = 2_500_999;
    let told = desk.status();
    assert_eq!((told.uptime_ms, told.commands), (2_500, 3));
    assert_eq!(
        (told.mode.as_str(), told.sensor.as_str()),
        ("Fault", "Running")
    );
    assert_eq!((told.draft, told.moves, told.robot), (false, false, true));
    let (code, expected, received) = told.fault.unwrap();
    assert_eq!(
        (code.as_str(), expected, received),
        ("SensorStale", 5.0, 6.0)
    );
    let (command, refusal) = told.refusal.unwrap();
    assert_eq!((command.as_str(), refusal.as_str()), ("arm", "SensorStale"));
    desk.is_done(&Request::Begin);
    desk.now.status.moves = true;
    let told = desk.status();
    assert_eq!((told.draft, told.moves), (true, true));
}

#[test]
fn frames_are_counted_whole_and_damaged() {
    let mut desk = Desk::new(kept());
    desk.now.status.link.lost = 7;
    let first = desk.counters();
    desk.session.count_damaged();
    desk.session.count_damaged();
    let second = desk.counters();
    assert_eq!((first.damaged_frames, second.damaged_frames), (0, 2));
    assert_eq!((first.frames, second.frames), (2, 3), "with the hello");
    assert_eq!(second.lost, 7);
}

/// Two seconds, and not a microsecond less.
#[test]
fn a_robot_rests_when_it_has_been_silent_for_long() {
    let mut desk = Desk::new(kept());
    desk.now.status.moves = true;
    desk.now.us = 1_000_000;
    desk.session.watch(&desk.now);
    desk.now.status.connected = false;
    for (us, moves) in [(3_000_000, true), (3_000_001, false)] {
        desk.now.us = us;
        desk.session.watch(&desk.now);
        assert_eq!(desk.session.moves(&desk.now), moves, "{us}");
    }
}

#[test]
fn each_change_is_logged_once_with_its_numbers() {
    let mut desk = Desk::new(kept());
    desk.session.watch(&desk.now);
    let status = &mut desk.now.status;
    status.fault = Some(Fault::new(FaultCode::SensorStale, 5.0, 6.0));
    status.refusal = Some((Command::Start, ModeRefusal::WrongMode));
    status.sensor = Some(SensorState::Starting);
    status.connected = false;
    for _ in 0..3 {
        desk.session.watch(&desk.now);
    }
    // A fault or refusal that has ended needs no line.
    (
        desk.now.status.fault,
        desk.now.status.refusal,
        desk.now.status.sensor,
    ) = (None, None, None);
    desk.session.watch(&desk.now);
    let log = desk.log();
    let expected = [
        "settings 4",
        "robot connected",
        "robot silent",
        "fault: cycles without a new sensor sample: expected 5, received 6",
        "start refused: it does not apply in this mode",
        "sensor Starting",
    ];
    assert_eq!(log, expected);
}

#[test]
fn jobs_are_answered_by_what_came_of_them() {
    let mut desk = Desk::new(kept());
    assert_eq!(desk.ask(&Request::Previous), Outcome::Job(Job::Previous));
    desk.session.previous(None);
    assert_eq!(desk.told(), "Refused(NoPrevious)");
    assert_eq!(desk.session.draft(), None);
    desk.session.previous(Some(with_mass(44.0)));
    assert_eq!(desk.told(), "Done");
    assert_eq!(desk.session.draft(), Some(&with_mass(44.0)));
    desk.session.failed(&StoreError::ReadBack);
    assert!(desk.told().starts_with("Refused(Flash("), "{}", desk.told());
    desk.session.restarting();
    assert_eq!(desk.told(), "Restarting");
    desk.session.loop_back(Some(LoopBack { sent: 9, back: 8 }));
    assert_eq!(desk.told(), "LoopBack(Some(LoopBack { sent: 9, back: 8 }))");
}

#[test]
fn a_confirmed_trial_is_none_any_more() {
    let mut desk = Desk::new(on_trial(30));
    desk.ask(&Request::Confirm);
    desk.session.confirmed(Ok(kept().origin));
    assert_eq!(desk.told(), "Done");
    assert_eq!(*desk.session.origin(), kept().origin);
    desk.now.us = 60_000_000;
    assert!(!desk.session.trial_is_over(&desk.now));
}

/// Reading the flash needs the block, so that a partly received image is lost.
#[test]
fn what_takes_the_block_ends_the_image_that_was_coming() {
    let mut desk = Desk::new(kept());
    let bytes = &[7; 10][..];
    let follows = Request::Stage { offset: 10, bytes };
    for between in [Request::Slots, Request::Image(0), Request::Previous] {
        desk.is_done(&Request::Begin);
        desk.is_done(&Request::Stage { offset: 0, bytes });
        desk.is_done(&follows);
        desk.ask(&between);
        if between == Request::Previous {
            desk.session.previous(Some(kept().settings));
        }
        desk.is_refused(&Request::Stage { offset: 20, bytes }, &Refusal::Unreadable);
    }
    // Without a new draft, the first part restarts the image.
    desk.is_done(&Request::Begin);
    for _ in 0..2 {
        desk.is_done(&Request::Stage { offset: 0, bytes });
        desk.is_done(&follows);
    }
    let offset = (IMAGE_MAX_BYTES - 9) as u16;
    desk.is_refused(&Request::Stage { offset, bytes }, &Refusal::Unreadable);
}

#[test]
fn a_part_of_an_image_is_as_long_as_a_frame_takes() {
    let mut desk = Desk::new(kept());
    desk.ask(&Request::Image(0));
    let length = desk.said(|_, payload| match postcard::from_bytes(payload) {
        Ok(Answer::Image { length, bytes }) => (usize::from(length), bytes.len()),
        other => panic!("{other:?}"),
    });
    assert_eq!(length.1, length.0.min(1024 - 32));
    desk.ask(&Request::Image(u16::MAX));
    assert!(desk.told().ends_with("bytes: [] }"), "{}", desk.told());
}

#[test]
fn nothing_is_tested_while_the_robot_moves() {
    let mut desk = Desk::new(kept());
    let test = Request::SelfTest(SelfTest::Can);
    assert_eq!(desk.ask(&test), Outcome::Job(Job::SelfTest(SelfTest::Can)));
    desk.now.status.moves = true;
    desk.is_refused(&test, &Refusal::Moves);
    desk.is_done(&Request::Begin);
    desk.is_done(&Request::Abort);
    assert_eq!(desk.session.draft(), None);
}
