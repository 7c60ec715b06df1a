//! The answers of the board.

use super::{Now, Outcome, Session};
use crate::image::ImageError;
use crate::service::state::{command_word, word};
use crate::settings::BoardSettings;
use crate::shared::MachineState;
use crate::store::{Origin, StoreError, Trial};
use core::fmt::Write;
use heapless::{String, Vec};
use softdock_link::service::{
    self as link, Answer, ENCODED_MAX_BYTES, FlashSlot, Frame, Hello, Kind, LoopBack,
    PAYLOAD_MAX_BYTES, PROTOCOL, Refusal, Text,
};

impl Session {
    pub(super) fn status(&self, now: &Now) -> link::Status {
        let status = &now.status;
        link::Status {
            uptime_ms: now.us / 1000,
            origin: match self.origin {
                Origin::Flash { sequence, .. } => link::Origin::Flash { sequence },
                Origin::Trial(Trial { sequence, .. }) => link::Origin::Trial {
                    sequence,
                    left_s: self.trial_left_s(now).unwrap_or_default(),
                },
                Origin::Defaults(error) => link::Origin::Defaults {
                    reason: text(error),
                },
            },
            draft: self.draft.is_some(),
            mode: word(status.mode),
            moves: self.moves(now),
            robot: status.connected,
            sensor: status.sensor.map(word).unwrap_or_default(),
            fault: status
                .fault
                .map(|fault| (word(fault.code), fault.expected, fault.received)),
            refusal: status
                .refusal
                .map(|(command, refusal)| (command_word(command), word(refusal))),
            commands: status.commands,
        }
    }

    /// The result of keeping the settings on trial.
    pub fn confirmed(&mut self, kept: Result<Origin, StoreError>) {
        match kept {
            Ok(origin) => {
                self.origin = origin;
                self.finish(Ok(()));
            }
            Err(error) => self.failed(&error),
        }
    }

    /// The settings before those in use, if the store has them.
    pub fn previous(&mut self, previous: Option<BoardSettings>) {
        self.staged = None;
        match previous {
            Some(settings) => {
                self.draft = Some(settings);
                self.finish(Ok(()));
            }
            None => self.finish(Err(Refusal::NoPrevious)),
        }
    }

    /// What the store has found in the slots of the flash.
    pub fn slots(&mut self, found: &[Result<u32, ImageError>; 2]) {
        let slot = |kept: &Result<u32, ImageError>| match kept {
            Ok(sequence) => FlashSlot::Kept {
                sequence: *sequence,
            },
            Err(ImageError::Absent) => FlashSlot::Empty,
            Err(ImageError::NotConfirmed) => FlashSlot::NotConfirmed,
            Err(error) => FlashSlot::Unusable {
                reason: text(error),
            },
        };
        let _ = self.say(&Answer::Slots(found.each_ref().map(slot)));
    }

    /// State of the board itself.
    pub fn machine(&mut self, state: &MachineState) {
        let _ = self.say(&Answer::Machine(state.to_machine()));
    }

    /// Result of the loop-back test of a CAN controller.
    pub fn loop_back(&mut self, outcome: Option<LoopBack>) {
        let _ = self.say(&Answer::LoopBack(outcome));
    }

    /// The flash could not be written.
    pub fn failed(&mut self, error: &StoreError) {
        self.finish(Err(Refusal::Flash(text(error))));
    }

    /// The board is about to start over.
    pub fn restarting(&mut self) {
        let _ = self.say(&Answer::Restarting);
    }

    /// A job was done or refused.
    pub fn finish(&mut self, outcome: Result<(), Refusal>) {
        let _ = match outcome {
            Ok(()) => self.done(),
            Err(refusal) => self.refuse(refusal),
        };
    }

    pub(super) fn done(&mut self) -> Outcome {
        self.say(&Answer::Done)
    }

    pub(super) fn refuse(&mut self, refusal: Refusal) -> Outcome {
        self.say(&Answer::Refused(refusal))
    }

    /// Refuses a frame that does not belong to this conversation.
    pub(super) fn refuse_aside(&mut self, refusal: Refusal) -> Outcome {
        let line = encode(self.header(), &Answer::Refused(refusal));
        self.send_aside(&line)
    }

    pub(super) fn say_hello(&mut self) -> Outcome {
        let line = self.hello();
        self.send(line)
    }

    pub(super) fn hello(&self) -> Vec<u8, ENCODED_MAX_BYTES> {
        let hello = Hello {
            protocol: PROTOCOL,
            schema: self.schema,
            boot: self.boot,
            identity: &self.identity,
        };
        let header = Frame {
            kind: Kind::HelloAnswer,
            ..self.header()
        };
        encode(header, &hello)
    }

    pub(super) fn say(&mut self, answer: &Answer<'_>) -> Outcome {
        let line = encode(self.header(), answer);
        self.send(line)
    }

    pub(super) fn send(&mut self, line: Vec<u8, ENCODED_MAX_BYTES>) -> Outcome {
        self.line = line;
        Outcome::Answer
    }

    /// Sends a short frame; tests show that it has room.
    pub(super) fn send_aside(&mut self, line: &[u8]) -> Outcome {
        let _ = self.aside.extend_from_slice(line);
        Outcome::Answer
    }

    pub(super) fn header(&self) -> Frame<'static> {
        Frame {
            version: PROTOCOL,
            kind: Kind::Answer,
            sequence: self.sequence,
            conversation: self.conversation().unwrap_or_default(),
            payload: &[],
        }
    }
}

/// The bytes of a message; empty if it is longer than a frame, which a test excludes.
pub(super) fn encode(
    header: Frame<'_>,
    message: &impl serde::Serialize,
) -> Vec<u8, ENCODED_MAX_BYTES> {
    let mut payload = [0; PAYLOAD_MAX_BYTES];
    let written = postcard::to_slice(message, &mut payload);
    written
        .ok()
        .and_then(|payload| Frame { payload, ..header }.encode().ok())
        .unwrap_or_default()
}

/// A sentence, cut off at its capacity.
pub(super) fn text(value: impl core::fmt::Display) -> Text {
    let mut text = Text::new();
    let mut long = String::<400>::new();
    let _ = write!(long, "{value}");
    for character in long.chars() {
        if text.push(character).is_err() {
            break;
        }
    }
    text
}
