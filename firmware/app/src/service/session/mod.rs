//! The conversation: takes frames and returns answers.

mod answers;
mod requests;

use super::log::Log;
use crate::checksum::CHECKSUM;
use crate::image::schema;
use crate::processor::Processor;
use crate::settings::BoardSettings;
use crate::shared::{Change, Status};
use crate::store::{Block, Boot, Origin, Trial};
use heapless::{String, Vec};
use softdock_control::modes::{Command, Fault};
use softdock_link::service::{
    ENCODED_MAX_BYTES, Frame, Kind, PAYLOAD_MAX_BYTES, PROTOCOL, Refusal, SelfTest,
};

/// Longest identity: of a board on a computer, 98 bytes and the recorder's address, 58 in IPv6 with a scope.
pub const IDENTITY_BYTES: usize = 160;
/// Silence of the robot after which it does not move any more, µs: RSI stops by itself after its
/// own time-out, some 100 ms.
const SILENT_US: u64 = 2_000_000;
/// Most request numbers that a host may have skipped: requests that it gave up and the board never received. Small compared with
/// 65,536, as another conversation begins at any number.
pub(super) const AHEAD: u16 = 64;
/// Room for a refusal or a hello on the line, bytes: a short frame.
const ASIDE_BYTES: usize = 256;
/// Longest part of an image in an answer: room is left for the message around it.
const PART_BYTES: usize = PAYLOAD_MAX_BYTES - 32;

/// State of the board at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Now {
    /// Time since boot, µs.
    pub us: u64,
    /// The state that the tasks share.
    pub status: Status,
}

/// Work for a request, beyond answering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Job {
    /// Write the draft and start over.
    Commit {
        /// Time to confirm it, s.
        confirm_within_s: u16,
    },
    /// Keep what is on trial.
    Confirm(Trial),
    /// End the trial.
    EndTrial,
    /// Make a draft of the settings before those in use.
    Previous,
    /// Look into the slots of the flash.
    Slots,
    /// Tell how the board itself is.
    Machine,
    /// Test a part of the board.
    SelfTest(SelfTest),
    /// Give a command to the robot task.
    Operator(Command),
}

/// Result of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// It was not for a board.
    Ignore,
    /// [`Session::line`] has the answer.
    Answer,
    /// [`Session::line`] will have it when this is done.
    Job(Job),
}

/// A board's side of the service.
#[derive(Debug)]
pub struct Session {
    identity: String<IDENTITY_BYTES>,
    boot: u32,
    processor: Processor,
    schema: u32,
    settings: BoardSettings,
    origin: Origin,
    draft: Option<BoardSettings>,
    /// Bytes received so far of an image.
    staged: Option<u16>,
    log: Log,
    seen: Status,
    /// When the robot's last telegram was seen, µs.
    heard_us: u64,
    frames: u32,
    damaged: u32,
    /// The request that was answered last: its number and checksum.
    answered: Option<(u16, u32)>,
    /// Conversations that hosts have begun since boot.
    conversations: u32,
    /// The newest request number of this conversation.
    newest: u16,
    /// Number of the request that is being answered.
    sequence: u16,
    line: Vec<u8, ENCODED_MAX_BYTES>,
    /// The answer to a frame that does not belong to this conversation, empty if the last one did: the answer in `line` is kept
    /// for a host that repeats its request.
    aside: Vec<u8, ASIDE_BYTES>,
}

impl Session {
    /// A session of a board that has started with these settings. `boot` differs from boot to boot.
    pub fn new(boot: &Boot, number: u32, identity: &str) -> Self {
        let mut name = String::new();
        for character in identity.chars() {
            // A longer one is cut off.
            let _ = name.push(character);
        }
        let mut session = Self {
            identity: name,
            boot: number,
            processor: Processor::default(),
            schema: schema(),
            settings: boot.settings.clone(),
            origin: boot.origin,
            draft: None,
            staged: None,
            log: Log::new(),
            seen: Status::default(),
            heard_us: 0,
            frames: 0,
            damaged: 0,
            answered: None,
            conversations: 0,
            newest: 0,
            sequence: 0,
            line: Vec::new(),
            aside: Vec::new(),
        };
        match session.origin {
            Origin::Flash { sequence, .. } => session.note(0, format_args!("settings {sequence}")),
            Origin::Trial(trial) => session.note(
                0,
                format_args!(
                    "settings {} on trial for {} s",
                    trial.sequence, trial.confirm_within_s
                ),
            ),
            Origin::Defaults(error) => {
                session.note(0, format_args!("DEFAULT SETTINGS, disarmed: {error}"));
            }
        }
        session
    }

    /// Sets the processor, if it cannot run every law.
    pub fn run_on(&mut self, processor: Processor) {
        self.processor = processor;
        if let Err(slow) = processor.accepts(&self.settings) {
            self.note(0, format_args!("NOT TO BE ARMED: {slow}"));
        }
    }

    /// Adds a line to the log.
    pub fn note(&mut self, at_us: u64, text: core::fmt::Arguments<'_>) {
        self.log.add(at_us, text);
    }

    /// Where the settings in use come from.
    pub fn origin(&self) -> &Origin {
        &self.origin
    }

    /// The draft, if there is one.
    pub fn draft(&self) -> Option<&BoardSettings> {
        self.draft.as_ref()
    }

    /// The bytes of the last answer.
    pub fn line(&self) -> &[u8] {
        match self.aside.is_empty() {
            true => &self.line,
            false => &self.aside,
        }
    }

    /// A frame was damaged on the line.
    pub fn count_damaged(&mut self) {
        self.damaged = self.damaged.wrapping_add(1);
    }

    /// Whether the robot moves or may begin to. A robot that has been silent for long does not.
    pub fn moves(&self, now: &Now) -> bool {
        let silent = !now.status.connected && now.us.saturating_sub(self.heard_us) > SILENT_US;
        now.status.moves && !silent
    }

    /// Whether the time of the trial is over; it is prolonged while the robot moves.
    pub fn trial_is_over(&self, now: &Now) -> bool {
        self.trial_left_s(now) == Some(0) && !self.moves(now)
    }

    fn trial_left_s(&self, now: &Now) -> Option<u16> {
        let Origin::Trial(trial) = self.origin else {
            return None;
        };
        let left_us = (u64::from(trial.confirm_within_s) * 1_000_000).saturating_sub(now.us);
        u16::try_from(left_us.div_ceil(1_000_000)).ok()
    }

    /// Logs changes since the last call. To be called often.
    pub fn watch(&mut self, now: &Now) {
        if now.status.connected {
            self.heard_us = now.us;
        }
        for change in now.status.changes_since(&self.seen) {
            match change {
                Change::Connected(true) => self.note(now.us, format_args!("robot connected")),
                Change::Connected(false) => self.note(now.us, format_args!("robot silent")),
                Change::Mode(mode) => self.note(now.us, format_args!("mode {mode:?}")),
                Change::Fault(Fault {
                    code,
                    expected,
                    received,
                }) => self.note(
                    now.us,
                    format_args!("fault: {code}: expected {expected}, received {received}"),
                ),
                Change::Refusal(command, refusal) => self.note(
                    now.us,
                    format_args!("{} refused: {refusal}", command.word()),
                ),
                Change::Sensor(sensor) => self.note(now.us, format_args!("sensor {sensor:?}")),
            }
        }
        self.seen = now.status;
    }

    /// A host begins a conversation: request numbers restart, and drafts of the previous conversation are dropped. A host that
    /// repeats its hello, because it may not have been received, may get both answers.
    fn begin_conversation(&mut self) {
        let said_again = self.answered.is_none() && self.newest == self.sequence;
        if said_again && self.conversations > 0 {
            return;
        }
        self.answered = None;
        self.conversations = self.conversations.wrapping_add(1);
        self.newest = self.sequence;
        self.draft = None;
        self.staged = None;
    }

    /// Number of this conversation: different from all others of this boot, and with a probability of 1 − 2⁻³² from one of
    /// another boot; `None` before the first hello.
    fn conversation(&self) -> Option<u32> {
        let mut number = CHECKSUM.digest();
        number.update(&self.boot.to_le_bytes());
        number.update(&self.conversations.to_le_bytes());
        (self.conversations > 0).then(|| number.finalize())
    }

    /// Whether a request number is one of the next. Old frames may be repeated by the line or by someone who recorded them; an
    /// old `Begin` would drop the draft.
    fn follows(&self, sequence: u16) -> bool {
        (1..=AHEAD).contains(&sequence.wrapping_sub(self.newest))
    }

    /// Takes in a frame. `block` is room for a whole image. Between the parts of an image nobody else may use it; an image of
    /// mixed parts is refused by its checksum.
    pub fn take(&mut self, frame: &Frame<'_>, now: &Now, block: &mut Block) -> Outcome {
        self.frames = self.frames.wrapping_add(1);
        self.sequence = frame.sequence;
        self.aside.clear();
        match frame.kind {
            Kind::Hello => {
                self.begin_conversation();
                self.say_hello()
            }
            // A host with another protocol version is told this one.
            Kind::Request if frame.version != PROTOCOL => {
                let hello = self.hello();
                self.send_aside(&hello)
            }
            Kind::Request => {
                let request = (frame.sequence, CHECKSUM.checksum(frame.payload));
                if self.answered == Some(request) {
                    return Outcome::Answer;
                }
                if self.conversation() != Some(frame.conversation) {
                    return self.refuse_aside(Refusal::NoConversation);
                }
                if !self.follows(frame.sequence) {
                    return self.refuse_aside(Refusal::OldRequest);
                }
                self.answered = Some(request);
                self.newest = frame.sequence;
                self.request(frame, now, block)
            }
            Kind::HelloAnswer | Kind::Answer => Outcome::Ignore,
        }
    }
}
