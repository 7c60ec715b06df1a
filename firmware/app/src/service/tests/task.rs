//! The task with a line, a flash and a clock.

use super::*;
use crate::store::tests::flash::Flash;
use core::cell::{Cell, RefCell};
use embassy_futures::block_on;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embedded_io_async::{ErrorKind, ErrorType};

/// A line on which a host sends everything at once, and collects the answers.
#[derive(Default)]
struct Host {
    sends: Vec<u8>,
    received: RefCell<Vec<u8>>,
}

/// Bytes that the host sends, and whether the line closes after them.
struct Input<'a>(&'a [u8], bool);
struct Output<'a>(&'a RefCell<Vec<u8>>);

impl ErrorType for Input<'_> {
    type Error = ErrorKind;
}

impl Read for Input<'_> {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, ErrorKind> {
        if self.0.is_empty() && self.1 {
            return Ok(0);
        }
        if self.0.is_empty() {
            return core::future::pending().await;
        }
        let length = self.0.len().min(buffer.len());
        let (now, later) = self.0.split_at(length);
        buffer[..length].copy_from_slice(now);
        self.0 = later;
        Ok(length)
    }
}

impl ErrorType for Output<'_> {
    type Error = ErrorKind;
}

impl Write for Output<'_> {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        self.0.borrow_mut().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    async fn flush(&mut self) -> Result<(), ErrorKind> {
        Ok(())
    }
}

/// Time that passes as soon as somebody waits for it.
struct Quick(Cell<u64>);

impl Clock for Quick {
    fn now_us(&self) -> u64 {
        self.0.get()
    }

    async fn wait_until(&self, at_us: u64) {
        self.0.set(at_us.max(self.0.get()));
    }
}

impl Host {
    fn sends(requests: &[Request<'_>]) -> Self {
        // The conversation number of the first conversation after this boot number.
        let conversation = Desk::new(kept()).conversation;
        let frame = |kind, sequence, conversation, payload: &[u8]| {
            let frame = Frame {
                version: PROTOCOL,
                kind,
                sequence,
                conversation,
                payload,
            };
            frame.encode().unwrap()
        };
        let hello = frame(Kind::Hello, 0, 0, &[]);
        let requests = requests.iter().zip(1..).flat_map(|(request, sequence)| {
            frame(Kind::Request, sequence, conversation, &payload(request))
        });
        Self {
            sends: hello.into_iter().chain(requests).collect(),
            received: RefCell::default(),
        }
    }

    /// The answers, as text.
    fn received(&self) -> Vec<String> {
        let mut frames = FrameReader::new();
        let mut answers = Vec::new();
        for byte in self.received.borrow().iter() {
            let frame = frames.push(*byte).map(Result::unwrap);
            if let Some(frame) = frame.filter(|frame| frame.kind == Kind::Answer) {
                let answer: Answer<'_> = postcard::from_bytes(frame.payload).unwrap();
                answers.push(format!("{answer:?}"));
            }
        }
        answers
    }
}

/// Runs the service of a board from its start until it is to restart. Returns the end, its time (µs) and the mass in use.
fn run(flash: &mut Flash, trial: Option<Trial>, status: Status, host: &Host) -> (End, u64, f64) {
    let shared = Shared::<NoopRawMutex>::new();
    shared.update_status(|now| *now = status);
    let mut block = [0; IMAGE_MAX_BYTES];
    let mut store = Store::new(flash);
    let boot = block_on(store.boot(trial, &mut block));
    let mass = boot.settings.control.body_k.mass_kg;
    let mut session = Session::new(&boot, BOOT, "a board");
    let service = Service {
        shared: &shared,
        session: &mut session,
        store: &mut store,
        block: &mut block,
    };
    let clock = Quick(Cell::new(0));
    let end = block_on(service.run(
        Input(&host.sends, !host.sends.is_empty()),
        Output(&host.received),
        &clock,
    ));
    assert_eq!(shared.status().restarting, end != End::Closed);
    (end, clock.now_us(), mass)
}

/// Commit, restart, confirm: the settings are kept. Without a confirmation the board returns to the old ones by itself.
#[test]
fn settings_are_tried_and_kept_or_given_up() {
    let mut flash = Flash::erased();
    let path = "control.body_k.mass_kg";
    let value = Value::Real(22.0);
    let host = Host::sends(&[
        Request::Begin,
        Request::Set { path, value },
        Request::Validate,
        COMMIT,
    ]);
    let (end, _, _) = run(&mut flash, None, Status::default(), &host);
    assert_eq!(host.received(), ["Done", "Done", "Done", "Restarting"]);
    let End::Restart(Some(trial)) = end else {
        panic!("{end:?}");
    };
    // Nobody sends anything.
    let silent = Host::default();
    let (end, at_us, mass) = run(&mut flash, Some(trial), Status::default(), &silent);
    assert_eq!((end, mass), (End::Restart(None), 22.0));
    assert!((30_000_000..30_200_000).contains(&at_us), "{at_us}");
    let after = boot(&mut flash, None);
    assert!(matches!(after.origin, Origin::Defaults(_)), "{after:?}");
    // On a new trial it is confirmed, and cannot be dropped any more.
    let host = Host::sends(&[
        Request::Confirm,
        Request::Get(path),
        Request::Confirm,
        COMMIT,
    ]);
    let (_, _, mass) = run(&mut flash, Some(trial), Status::default(), &host);
    assert_eq!(mass, 22.0);
    let answers = [
        "Done",
        "Value(Real(22.0))",
        "Refused(NotOnTrial)",
        "Refused(NoDraft)",
    ];
    assert_eq!(host.received(), answers);
    let after = boot(&mut flash, None);
    assert_eq!(after.settings, with_mass(22.0));
}

fn boot(flash: &mut Flash, trial: Option<Trial>) -> Boot {
    let mut block = [0; IMAGE_MAX_BYTES];
    block_on(Store::new(flash).boot(trial, &mut block))
}

/// A motion that begins while flash is written keeps the board from starting over.
#[test]
fn a_motion_that_begins_in_time_wins() {
    let mut flash = Flash::erased();
    let moving = Status {
        connected: true,
        moves: true,
        ..Status::default()
    };
    let shared = Shared::<NoopRawMutex>::new();
    shared.update_status(|now| *now = moving);
    let mut desk = Desk::new(kept());
    desk.is_done(&Request::Begin);
    let mut store = Store::new(&mut flash);
    let service = &mut Service {
        shared: &shared,
        session: &mut desk.session,
        store: &mut store,
        block: &mut desk.block,
    };
    let job = Job::Commit {
        confirm_within_s: 9,
    };
    let clock = Quick(Cell::new(0));
    assert_eq!(block_on(service.carry_out(job, &clock)), None);
    assert!(!shared.status().restarting);
    desk.said(|_, payload| {
        let answer = postcard::from_bytes(payload);
        assert_eq!(answer, Ok(Answer::Refused(Refusal::Moves)));
    });
}

/// A host that does not read delays an answer for a limited time, and does not block the service.
#[test]
fn an_answer_that_nobody_takes_is_given_up() {
    struct Full;
    impl ErrorType for Full {
        type Error = ErrorKind;
    }
    impl Write for Full {
        async fn write(&mut self, _: &[u8]) -> Result<usize, ErrorKind> {
            core::future::pending().await
        }

        async fn flush(&mut self) -> Result<(), ErrorKind> {
            Ok(())
        }
    }
    let (mut flash, shared) = (Flash::erased(), Shared::<NoopRawMutex>::new());
    let (mut desk, mut store) = (Desk::new(kept()), Store::new(&mut flash));
    let service = Service {
        shared: &shared,
        session: &mut desk.session,
        store: &mut store,
        block: &mut desk.block,
    };
    let requests = [Request::Begin, Request::Validate];
    let host = Host::sends(&requests);
    let start_us = 5_000_000;
    let clock = Quick(Cell::new(start_us));
    let end = block_on(service.run(Input(&host.sends, true), Full, &clock));
    // The timeouts of the greeting and of both requests.
    assert_eq!(
        (end, clock.now_us()),
        (End::Closed, start_us + 3 * WRITE_US)
    );
}

#[test]
fn the_lamps_that_are_tested_are_lit_for_their_time() {
    let (mut flash, shared) = (Flash::erased(), Shared::<NoopRawMutex>::new());
    let (mut desk, mut store) = (Desk::new(kept()), Store::new(&mut flash));
    let service = &mut Service {
        shared: &shared,
        session: &mut desk.session,
        store: &mut store,
        block: &mut desk.block,
    };
    let lit = [true, false, true];
    let job = Job::SelfTest(SelfTest::Lamps(Some(lit)));
    let start_us = 5_000_000;
    let clock = Quick(Cell::new(start_us));
    assert_eq!(block_on(service.carry_out(job, &clock)), None);
    let end_us = start_us + u64::from(LAMPS_S) * 1_000_000;
    let leds = [end_us - 1, end_us].map(|us| shared.leds(us));
    assert_eq!(leds, [Some(Leds::from(lit)), None]);
}

/// No task can test a bus here; the answer comes all the same. A hang ends the service.
#[test]
fn a_new_board_is_tested_unless_the_robot_moves() {
    let mut flash = Flash::erased();
    let test = Request::SelfTest;
    let requests = [
        test(SelfTest::Can),
        test(SelfTest::Lamps(Some([true, false, false]))),
        test(SelfTest::Hang),
    ];
    let host = Host::sends(&requests);
    let (end, at_us, _) = run(&mut flash, None, Status::default(), &host);
    assert_eq!(end, End::Hang);
    assert!(at_us >= BUS_TEST_US, "{at_us}");
    assert_eq!(host.received(), ["LoopBack(None)", "Done", "Restarting"]);

    let moving = Status {
        connected: true,
        moves: true,
        ..Status::default()
    };
    let host = Host::sends(&requests);
    let (end, ..) = run(&mut flash, None, moving, &host);
    assert_eq!(end, End::Closed);
    assert_eq!(host.received(), ["Refused(Moves)"; 3]);
}
