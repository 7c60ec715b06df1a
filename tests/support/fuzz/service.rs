//! A host's conversation with the parameter service, down to the flash.

use core::cell::Cell;
use embassy_futures::block_on;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use softdock_app::board::Clock;
use softdock_app::image::IMAGE_MAX_BYTES;
use softdock_app::service::{End, Now, Service, Session};
use softdock_app::settings::BoardSettings;
use softdock_app::shared::{Shared, Status};
use softdock_app::store::{Boot, Store};
use softdock_link::service::{Frame, FrameReader, Kind, PROTOCOL};
use softdock_rig::board::flash::FileFlash;

/// Space for all answers of a session, bytes.
const ROOM: usize = 1 << 20;
/// Number of the boot.
const BOOT: u32 = 7;

/// A clock that advances at once when it is waited for.
struct Quick(Cell<u64>);

impl Clock for Quick {
    fn now_us(&self) -> u64 {
        self.0.get()
    }

    async fn wait_until(&self, at_us: u64) {
        self.0.set(at_us.max(self.0.get()));
    }
}

const HELLO: Frame<'static> = Frame {
    version: PROTOCOL,
    kind: Kind::Hello,
    sequence: 0,
    conversation: 0,
    payload: &[],
};

/// Number of the first conversation of a board that starts with `boot`.
fn first_conversation(boot: &Boot) -> u32 {
    let mut session = Session::new(boot, BOOT, "a board");
    let now = Now {
        us: 0,
        status: Status::default(),
    };
    session.take(&HELLO, &now, &mut [0; IMAGE_MAX_BYTES]);
    let mut frames = FrameReader::new();
    let mut numbers = session.line().iter().filter_map(|byte| {
        let frame = frames.push(*byte)?;
        Some(frame.expect("a frame").conversation)
    });
    numbers.next().expect("an answer")
}

/// A hello, and the bytes as pieces: a length and the payload of a frame or, with an odd length, bytes of the line.
fn line(input: &[u8], conversation: u32) -> Vec<u8> {
    let (mut line, mut rest) = (HELLO.encode().unwrap().to_vec(), input);
    for sequence in 1.. {
        let Some((length, tail)) = rest.split_first() else {
            break;
        };
        let (piece, tail) = tail.split_at(usize::from(length / 2).min(tail.len()));
        rest = tail;
        if length % 2 == 1 {
            line.extend_from_slice(piece);
            continue;
        }
        let frame = Frame {
            version: PROTOCOL,
            kind: Kind::Request,
            sequence,
            conversation,
            payload: piece,
        };
        line.extend_from_slice(&frame.encode().unwrap());
    }
    line
}

/// Whatever the host sends, all answers are frames, and the next start finds valid settings.
pub(super) fn service_session(input: &[u8]) {
    let mut flash: FileFlash = FileFlash::open(None).unwrap();
    let mut kept = BoardSettings::default();
    kept.rsi.robot_ip = "any".try_into().unwrap();
    flash.put_if_empty(kept).unwrap();
    let mut trial = None;
    // Settings on trial need a start of their own.
    for _ in 0..2 {
        let mut block = [0; IMAGE_MAX_BYTES];
        let mut store = Store::new(&mut flash);
        let boot = block_on(store.boot(trial.take(), &mut block));
        boot.settings.validate().expect("settings that may be used");
        let conversation = first_conversation(&boot);
        let shared = Shared::<NoopRawMutex>::new();
        let mut session = Session::new(&boot, BOOT, "a board");
        let mut room = vec![0; ROOM];
        let mut answers = room.as_mut_slice();
        let service = Service {
            shared: &shared,
            session: &mut session,
            store: &mut store,
            block: &mut block,
        };
        let clock = Quick(Cell::new(0));
        let end = block_on(service.run(line(input, conversation).as_slice(), &mut answers, &clock));
        let said = ROOM - answers.len();
        let mut frames = FrameReader::new();
        for byte in &room[..said] {
            assert!(
                !matches!(frames.push(*byte), Some(Err(_))),
                "an answer that is no frame"
            );
        }
        let End::Restart(next) = end else {
            return;
        };
        trial = next;
    }
}
