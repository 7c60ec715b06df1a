//! A board with arbitrary answers, connected to a host.

use super::Script;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use softdock_app::image::{IMAGE_MAX_BYTES, Slot};
use softdock_app::service::{Job, Now, Outcome, Session};
use softdock_app::settings::BoardSettings;
use softdock_app::shared::{Shared, Status};
use softdock_app::store::{Boot, Origin};
use softdock_commissioning::parameters::{Client, LinkError};
use softdock_io::port::{Line, Port};
use softdock_link::service::{Frame, FrameReader, PAYLOAD_MAX_BYTES, SelfTest};
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};

/// A board's own session, with some answers changed by the bytes of a script. At the end of its output the line ends, so that
/// the host does not wait.
struct Board {
    session: Session,
    requests: FrameReader,
    script: Vec<u8>,
    said: VecDeque<u8>,
}

impl Board {
    fn new(script: &[u8]) -> Self {
        let boot = Boot {
            settings: BoardSettings::default(),
            origin: Origin::Flash {
                slot: Slot::A,
                sequence: 3,
            },
        };
        Self {
            session: Session::new(&boot, 7, "a board"),
            requests: FrameReader::new(),
            script: script.to_vec(),
            said: VecDeque::new(),
        }
    }

    /// Takes a byte of the host.
    fn take(&mut self, byte: u8) {
        let Some(Ok(frame)) = self.requests.push(byte) else {
            return;
        };
        let now = Now {
            us: 1_000_000,
            status: Status::default(),
        };
        let outcome = self.session.take(&frame, &now, &mut [0; IMAGE_MAX_BYTES]);
        match outcome {
            Outcome::Job(Job::Machine) => self
                .session
                .machine(&Shared::<NoopRawMutex>::new().machine()),
            Outcome::Job(Job::SelfTest(SelfTest::Can)) => self.session.loop_back(None),
            Outcome::Job(_) => self.session.finish(Ok(())),
            Outcome::Answer | Outcome::Ignore => {}
        }
        self.answer();
    }

    /// Sends the answers of the session, changed by the script.
    fn answer(&mut self) {
        let mut frames = FrameReader::new();
        let line = self.session.line().to_vec();
        let mut script = Script(&self.script);
        for byte in line {
            let Some(Ok(frame)) = frames.push(byte) else {
                continue;
            };
            let mut payload = frame.payload.to_vec();
            match script.byte() {
                // Another payload.
                Some(1) => payload = script.piece().unwrap_or_default().to_vec(),
                // Another byte.
                Some(2) => {
                    let [at, value] = script.bytes();
                    if let Some(byte) = payload.get_mut(usize::from(at)) {
                        *byte = value;
                    }
                }
                // A part of it, or a longer one.
                Some(3) => {
                    let [length] = script.bytes();
                    payload.resize((4 * usize::from(length)).min(PAYLOAD_MAX_BYTES), 0);
                }
                // Bytes before it.
                Some(4) => self.said.extend(script.piece().unwrap_or_default()),
                _ => {}
            }
            let frame = Frame {
                payload: &payload,
                ..frame
            };
            self.said.extend(frame.encode().unwrap());
        }
        self.script = script.0.to_vec();
    }
}

impl Read for Board {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.said.read(buffer)
    }
}

impl Write for Board {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        bytes.iter().for_each(|byte| self.take(*byte));
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Line for Board {
    fn try_clone(&self) -> io::Result<Box<dyn Line>> {
        Err(ErrorKind::Unsupported.into())
    }
}

/// Whatever a board answers, a host that makes every request comes to an end.
pub(super) fn board_answers(input: &[u8]) {
    let Ok(mut client) = Client::connect(Port::over_line(Board::new(input))) else {
        return;
    };
    let ended = |outcome: Result<(), LinkError>| outcome == Err(LinkError::Closed);
    let _ = ended(client.list(|_, _| ()).map(drop))
        || ended(client.status().map(drop))
        || ended(client.counters().map(drop))
        || ended(client.health().map(drop))
        || ended(client.slots().map(drop))
        || ended(client.machine().map(drop))
        || ended(client.loop_back().map(drop))
        || ended(client.log(0).map(drop))
        || ended(client.image().map(drop));
}
