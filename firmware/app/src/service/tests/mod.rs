mod health;
mod task;
mod told;

use super::session::AHEAD;
use super::*;
use crate::image::{IMAGE_MAX_BYTES, Image, ImageError};
use crate::processor::Processor;
use crate::settings::BoardSettings;
use crate::shared::Status;
use crate::store::{Boot, StoreError};
use softdock_control::modes::{Command, Mode};
use softdock_link::service::{Answer, Frame, Hello, Kind, PROTOCOL, Request, Value};

const BOOT: u32 = 77;

/// A board without line and flash, and a host's numbers.
struct Desk {
    session: Session,
    block: Box<Block>,
    now: Now,
    /// Number of the last request.
    sequence: u16,
    conversation: u32,
}

fn with_mass(mass_kg: f64) -> BoardSettings {
    let mut settings = BoardSettings::default();
    settings.control.body_k.mass_kg = mass_kg;
    settings
}

fn kept() -> Boot {
    let mut settings = with_mass(11.0);
    settings.rsi.robot_ip = crate::settings::Text::try_from("192.168.1.10").unwrap();
    Boot {
        settings,
        origin: Origin::Flash {
            sequence: 4,
            slot: crate::image::Slot::A,
        },
    }
}

fn defaults() -> Boot {
    Boot {
        settings: BoardSettings::default(),
        origin: Origin::Defaults(ImageError::Absent),
    }
}

fn on_trial(confirm_within_s: u16) -> Boot {
    Boot {
        origin: Origin::Trial(Trial {
            slot: crate::image::Slot::B,
            sequence: 5,
            checksum: 0,
            confirm_within_s,
        }),
        ..kept()
    }
}

fn payload(request: &Request<'_>) -> Vec<u8> {
    let mut bytes = [0; 1024];
    postcard::to_slice(request, &mut bytes).unwrap().to_vec()
}

impl Desk {
    fn new(boot: Boot) -> Self {
        let status = Status {
            connected: true,
            ..Status::default()
        };
        let mut desk = Self {
            session: Session::new(&boot, BOOT, "a board"),
            block: Box::new([0; IMAGE_MAX_BYTES]),
            now: Now { us: 0, status },
            sequence: 0,
            conversation: 0,
        };
        desk.conversation = desk.hello();
        desk
    }

    /// Begins a conversation and returns its number.
    fn hello(&mut self) -> u32 {
        self.frame(Kind::Hello, PROTOCOL, 0, &[]);
        self.answer_frame(|frame| frame.conversation)
    }

    fn frame(&mut self, kind: Kind, version: u8, conversation: u32, payload: &[u8]) -> Outcome {
        let frame = Frame {
            version,
            kind,
            sequence: self.sequence,
            conversation,
            payload,
        };
        self.session.take(&frame, &self.now, &mut self.block)
    }

    fn ask(&mut self, request: &Request<'_>) -> Outcome {
        self.sequence = self.sequence.wrapping_add(1);
        let conversation = self.conversation;
        self.frame(Kind::Request, PROTOCOL, conversation, &payload(request))
    }

    /// Calls `look` with the last answer.
    fn said<R>(&self, look: impl FnOnce(Kind, &[u8]) -> R) -> R {
        self.answer_frame(|frame| look(frame.kind, frame.payload))
    }

    fn answer_frame<R>(&self, look: impl FnOnce(&Frame<'_>) -> R) -> R {
        let mut frames = FrameReader::new();
        let (last, rest) = self.session.line().split_last().unwrap();
        assert!(rest.iter().all(|byte| frames.push(*byte).is_none()));
        let frame = frames.push(*last).unwrap().unwrap();
        assert_eq!(frame.sequence, self.sequence);
        look(&frame)
    }

    /// The answer to a request, as text.
    fn answer(&mut self, request: &Request<'_>) -> String {
        assert_eq!(self.ask(request), Outcome::Answer, "{request:?}");
        self.said(|_, payload| {
            format!("{:?}", postcard::from_bytes::<Answer<'_>>(payload).unwrap())
        })
    }

    fn is_refused(&mut self, request: &Request<'_>, refusal: &Refusal) {
        let expected = format!("{:?}", Answer::Refused(refusal.clone()));
        assert_eq!(self.answer(request), expected, "{request:?}");
    }

    fn is_done(&mut self, request: &Request<'_>) {
        assert_eq!(self.answer(request), "Done", "{request:?}");
    }

    fn set(&mut self, path: &str, value: Value<'_>) {
        self.is_done(&Request::Set { path, value });
    }
}

const COMMIT: Request<'_> = Request::Commit {
    confirm_within_s: 30,
};

#[test]
fn hello_is_answered_in_every_version() {
    let mut desk = Desk::new(kept());
    let longest = "b".repeat(IDENTITY_BYTES);
    desk.session = Session::new(&kept(), BOOT, &longest);
    for (kind, version, conversation) in [
        (Kind::Hello, PROTOCOL, 0),
        (Kind::Hello, 99, 12345),
        (Kind::Request, PROTOCOL + 1, 0),
    ] {
        assert_eq!(
            desk.frame(kind, version, conversation, b"anything"),
            Outcome::Answer
        );
        desk.said(|kind, payload| {
            assert_eq!(kind, Kind::HelloAnswer);
            let hello: Hello<'_> = postcard::from_bytes(payload).unwrap();
            assert_eq!((hello.protocol, hello.boot), (PROTOCOL, BOOT));
            assert_eq!(hello.schema, crate::image::schema());
            assert_eq!(hello.identity, longest);
        });
    }
    for kind in [Kind::Answer, Kind::HelloAnswer] {
        assert_eq!(desk.frame(kind, PROTOCOL, 0, &[]), Outcome::Ignore);
    }
}

#[test]
fn a_request_needs_a_conversation_and_has_to_be_readable() {
    let mut desk = Desk::new(kept());
    let known = desk.conversation;
    desk.conversation ^= 1;
    desk.is_refused(&Request::Status, &Refusal::NoConversation);
    // A restarted board has no conversation, whatever number a host uses.
    desk.session = Session::new(&kept(), BOOT + 1, "a board");
    for number in [known, 0] {
        desk.conversation = number;
        desk.is_refused(&Request::Status, &Refusal::NoConversation);
    }
    let conversation = desk.hello();
    assert_eq!(desk.hello(), conversation, "the answer may have been lost");
    desk.sequence += 1;
    desk.frame(Kind::Request, PROTOCOL, conversation, &[0xff; 9]);
    desk.said(|_, payload| {
        let answer = postcard::from_bytes(payload);
        assert_eq!(answer, Ok(Answer::Refused(Refusal::Unreadable)));
    });
}

#[test]
fn settings_are_listed_and_told() {
    let mut desk = Desk::new(kept());
    let count = crate::parameters::count();
    for index in 0..count {
        assert!(desk.answer(&Request::List(index)).starts_with("Entry("));
    }
    assert_eq!(desk.answer(&Request::List(count)), "End");
    let mass = desk.answer(&Request::Get("control.body_k.mass_kg"));
    assert_eq!(mass, "Value(Real(11.0))");
    desk.is_refused(&Request::Get("control.body_k"), &Refusal::UnknownName);
}

/// The default law computes in f64; without a unit for that, it would not finish within the cycle.
#[test]
fn a_law_that_is_too_slow_for_the_board_is_neither_armed_nor_kept() {
    let mut desk = Desk::new(kept());
    desk.session.run_on(Processor::Integer);
    let slow = "Settings(\"control.delay.law predictor is too slow";
    desk.is_done(&Request::Begin);
    for request in [
        Request::Mode("arm"),
        Request::Mode("start"),
        Request::Validate,
        COMMIT,
    ] {
        let answer = desk.answer(&request);
        assert!(answer.contains(slow), "{answer}");
    }
    let (path, value) = ("control.delay.law", Value::Text("seed"));
    desk.is_done(&Request::Set { path, value });
    desk.is_done(&Request::Validate);
}

/// A draft changes step by step; dependent settings are checked when it is complete.
#[test]
fn a_draft_is_checked_as_a_whole() {
    let mut desk = Desk::new(kept());
    let value = Value::Whole(50);
    let path = "control.sensor.stale_after_cycles";
    desk.is_refused(
        &Request::Set {
            path,
            value: value.clone(),
        },
        &Refusal::NoDraft,
    );
    desk.is_refused(&COMMIT, &Refusal::NoDraft);
    desk.is_done(&Request::Begin);
    // Larger than the age that latches a fault: not allowed without changing that, too.
    desk.set(path, value);
    for request in [Request::Validate, COMMIT] {
        let refused = desk.answer(&request);
        assert!(
            refused.contains("`sensor.fault_after_cycles` is 5; allowed is 50 to 1000"),
            "{refused}"
        );
    }
    desk.set("control.sensor.fault_after_cycles", Value::Whole(60));
    desk.is_done(&Request::Validate);
    let confirm_within_s = 30;
    assert_eq!(
        desk.ask(&COMMIT),
        Outcome::Job(Job::Commit { confirm_within_s })
    );
    desk.is_done(&Request::Abort);
    desk.is_refused(&Request::Validate, &Refusal::NoDraft);
}

#[test]
fn a_whole_image_comes_in_parts() {
    let mut desk = Desk::new(kept());
    let mut image = vec![0; IMAGE_MAX_BYTES];
    let (sequence, settings) = (1, with_mass(33.0));
    let length = Image { sequence, settings }.encode(&mut image).unwrap();
    image.truncate(length);
    let stage = |desk: &mut Desk, image: &[u8]| {
        desk.is_done(&Request::Begin);
        for (part, bytes) in image.chunks(400).enumerate() {
            let offset = (part * 400) as u16;
            desk.is_done(&Request::Stage { offset, bytes });
        }
    };
    stage(&mut desk, &image);
    desk.is_done(&Request::Validate);
    assert_eq!(desk.session.draft(), Some(&with_mass(33.0)));
    // Damaged, cut off, or in another order: refused, and the draft stays.
    let mut damaged = image.clone();
    damaged[500] ^= 1;
    for wrong in [&damaged, &image[..length - 1]] {
        stage(&mut desk, wrong);
        let refused = desk.answer(&Request::Validate);
        assert!(refused.starts_with("Refused(Settings("), "{refused}");
        assert_eq!(desk.session.draft(), Some(&kept().settings));
    }
    let (offset, bytes) = (800, &image[..10]);
    desk.is_refused(&Request::Stage { offset, bytes }, &Refusal::Unreadable);
}

#[test]
fn the_image_of_the_board_goes_out_in_parts() {
    let mut desk = Desk::new(kept());
    let mut image = Vec::new();
    loop {
        desk.ask(&Request::Image(image.len() as u16));
        let (length, part) = desk.said(|_, payload| match postcard::from_bytes(payload) {
            Ok(Answer::Image { length, bytes }) => (usize::from(length), bytes.to_vec()),
            other => panic!("{other:?}"),
        });
        image.extend(part);
        if image.len() == length {
            break;
        }
    }
    let image = Image::decode(&image).unwrap();
    assert_eq!((image.sequence, image.settings), (4, kept().settings));
}

#[test]
fn nothing_that_moves_the_robot_changes_while_it_moves() {
    let mut desk = Desk::new(kept());
    desk.is_done(&Request::Begin);
    desk.now.status.moves = true;
    desk.session.watch(&desk.now);
    desk.is_refused(&COMMIT, &Refusal::Moves);
    // A gap in the telegrams does not make it rest, a long silence does.
    desk.now.status.connected = false;
    desk.now.us += 1_000_000;
    desk.is_refused(&COMMIT, &Refusal::Moves);
    desk.now.us += 2_000_000;
    assert!(matches!(desk.ask(&COMMIT), Outcome::Job(_)));

    let mut desk = Desk::new(on_trial(30));
    desk.now.status.moves = true;
    desk.session.watch(&desk.now);
    desk.is_refused(&Request::Abort, &Refusal::Moves);
    desk.now.us = 31_000_000;
    assert!(!desk.session.trial_is_over(&desk.now), "it still moves");
    desk.now.status.moves = false;
    assert!(desk.session.trial_is_over(&desk.now));
}

#[test]
fn a_trial_is_confirmed_or_ended_before_anything_else() {
    let mut desk = Desk::new(on_trial(30));
    for request in [Request::Begin, Request::Previous, COMMIT] {
        desk.is_refused(&request, &Refusal::OnTrial);
    }
    desk.now.us = 12_500_000;
    let status = desk.answer(&Request::Status);
    assert!(
        status.contains("Trial { sequence: 5, left_s: 18 }"),
        "{status}"
    );
    assert!(!desk.session.trial_is_over(&desk.now));
    assert_eq!(desk.ask(&Request::Abort), Outcome::Job(Job::EndTrial));
    assert!(matches!(
        desk.ask(&Request::Confirm),
        Outcome::Job(Job::Confirm(_))
    ));
    desk.session.confirmed(Err(StoreError::ReadBack));
    desk.said(|_, payload| {
        let answer = postcard::from_bytes(payload);
        assert!(matches!(answer, Ok(Answer::Refused(Refusal::Flash(_)))));
    });
    let mut desk = Desk::new(kept());
    desk.is_refused(&Request::Confirm, &Refusal::NotOnTrial);
}

/// A request that comes twice, because its answer was lost, is carried out once.
#[test]
fn what_comes_twice_is_done_once() {
    let mut desk = Desk::new(kept());
    let hold = Request::Mode("hold");
    let job = Outcome::Job(Job::Operator(Command::Hold));
    assert_eq!(desk.ask(&hold), job);
    desk.session.finish(Ok(()));
    let line = desk.session.line().to_vec();
    // The answer to another host on the line does not replace the kept one.
    let sequence = desk.sequence;
    for (version, conversation) in [
        (PROTOCOL + 1, 0),
        (PROTOCOL, desk.conversation ^ 1),
        (PROTOCOL, desk.conversation),
    ] {
        desk.sequence = sequence + AHEAD + 9;
        desk.frame(Kind::Request, version, conversation, &payload(&hold));
        assert_ne!(desk.session.line(), line);
        desk.sequence = sequence - 1;
        assert_eq!(desk.ask(&hold), Outcome::Answer);
        assert_eq!(desk.session.line(), line);
    }
    assert_eq!(
        desk.ask(&hold),
        job,
        "with another number it is another request"
    );
}

/// Begin, Set, the same Begin repeated, Commit: the change is still in the draft, or nothing is committed.
#[test]
fn an_old_frame_that_comes_again_changes_nothing() {
    let mass = |desk: &Desk| {
        desk.session
            .draft()
            .map(|draft| draft.control.body_k.mass_kg)
    };
    let mut desk = Desk::new(kept());
    desk.sequence = 0xfffe;
    desk.conversation = desk.hello();
    desk.is_done(&Request::Begin);
    let begin = desk.sequence;
    desk.set("control.body_k.mass_kg", Value::Real(22.0));
    let next = desk.sequence;
    for old in [begin, begin.wrapping_sub(1), next + AHEAD + 1] {
        desk.sequence = old - 1;
        desk.is_refused(&Request::Begin, &Refusal::OldRequest);
        assert_eq!(mass(&desk), Some(22.0));
    }
    // A request that was given up may be missing.
    desk.sequence = next + AHEAD - 1;
    desk.set("control.body_k.mass_kg", Value::Real(33.0));

    // A recorded earlier conversation, from its hello on: the present draft is dropped, and nothing else happens, neither by the
    // recorded requests nor by those with which the live host continues.
    let live = desk.sequence;
    desk.sequence = 0xfffe;
    assert_ne!(desk.hello(), desk.conversation);
    assert_eq!(mass(&desk), None);
    for sequence in [0xfffe, live] {
        desk.sequence = sequence;
        desk.is_refused(&Request::Begin, &Refusal::NoConversation);
        desk.is_refused(&COMMIT, &Refusal::NoConversation);
    }
}

#[test]
fn commands_need_a_robot_and_settings() {
    let mut desk = Desk::new(defaults());
    for word in ["arm", "start", "jog -c"] {
        desk.is_refused(&Request::Mode(word), &Refusal::Unconfigured);
    }
    assert!(matches!(desk.ask(&Request::Mode("stop")), Outcome::Job(_)));
    desk.is_refused(&Request::Mode("dance"), &Refusal::UnknownCommand);
    let status = desk.answer(&Request::Status);
    assert!(
        status.contains("Defaults { reason: \"there are no settings\" }"),
        "{status}"
    );
    let log = desk.answer(&Request::Log(0));
    assert!(log.contains("DEFAULT SETTINGS, disarmed"), "{log}");
    let mut desk = Desk::new(kept());
    desk.now.status.connected = false;
    desk.is_refused(&Request::Mode("arm"), &Refusal::NoRobot);
}

#[test]
fn nothing_moves_before_it_is_said_who_the_robot_is() {
    let mut boot = kept();
    boot.settings.rsi.robot_ip.clear();
    let mut desk = Desk::new(boot);
    for word in ["arm", "start", "jog x"] {
        desk.is_refused(&Request::Mode(word), &Refusal::AnyRobot);
    }
    assert!(matches!(desk.ask(&Request::Mode("hold")), Outcome::Job(_)));
    for robot in [crate::settings::ANY_ROBOT, "192.168.1.10"] {
        let mut boot = kept();
        boot.settings.rsi.robot_ip = crate::settings::Text::try_from(robot).unwrap();
        assert!(boot.settings.validate().is_ok());
        let mut desk = Desk::new(boot);
        assert!(
            matches!(desk.ask(&Request::Mode("arm")), Outcome::Job(_)),
            "{robot}"
        );
    }
}

#[test]
fn what_happens_is_in_the_log() {
    let mut desk = Desk::new(kept());
    desk.now.us = 5_000;
    desk.session.watch(&desk.now);
    desk.now.status.mode = Mode::Hold;
    desk.session.watch(&desk.now);
    desk.session.watch(&desk.now);
    let log = desk.answer(&Request::Log(0));
    let (connected, hold) = (log.find("robot connected"), log.find("mode Hold"));
    assert!(connected.is_some() && connected < hold, "{log}");
    assert_eq!(log.matches("mode Hold").count(), 1);
    assert_eq!(desk.answer(&Request::Log(3)), "Log([])");
}
