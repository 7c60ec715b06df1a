//! Handling of each request.

use super::answers::{encode, text};
use super::{Job, Now, Outcome, PART_BYTES, Session};
use crate::image::{IMAGE_MAX_BYTES, Image};
use crate::parameters;
use crate::service::sequence;
use crate::service::state::{counters, health};
use crate::settings::BoardSettings;
use crate::store::{Block, Origin};
use softdock_control::modes::Command;
use softdock_link::service::{Answer, Counters, Frame, Refusal, Request, Value};

impl Session {
    pub(super) fn request(&mut self, frame: &Frame<'_>, now: &Now, block: &mut Block) -> Outcome {
        let Ok(request) = postcard::from_bytes::<Request<'_>>(frame.payload) else {
            return self.refuse(Refusal::Unreadable);
        };
        match request {
            Request::List(index) => self.list(index),
            Request::Get(path) => self.get(path),
            Request::Image(offset) => self.image(offset, block),
            Request::Status => {
                let status = self.status(now);
                self.say(&Answer::Status(status))
            }
            Request::Counters => {
                let (frames, damaged_frames) = (self.frames, self.damaged);
                self.say(&Answer::Counters(Counters {
                    frames,
                    damaged_frames,
                    ..counters(&now.status)
                }))
            }
            Request::Log(number) => {
                let lines = self.log.from(number);
                self.say(&Answer::Log(lines))
            }
            Request::Mode(text) => self.operator(text, now),
            Request::Health => self.say(&Answer::Health(health(now))),
            Request::Machine => Outcome::Job(Job::Machine),
            Request::SelfTest(_) if self.moves(now) => self.refuse(Refusal::Moves),
            Request::SelfTest(test) => Outcome::Job(Job::SelfTest(test)),
            Request::Slots => {
                // The block is needed to read them.
                self.staged = None;
                Outcome::Job(Job::Slots)
            }
            other => self.change(&other, now, block),
        }
    }

    /// Requests that change settings.
    fn change(&mut self, request: &Request<'_>, now: &Now, block: &mut Block) -> Outcome {
        let on_trial = matches!(self.origin, Origin::Trial(_));
        match request {
            Request::Begin | Request::Previous | Request::Commit { .. } if on_trial => {
                self.refuse(Refusal::OnTrial)
            }
            Request::Begin => {
                self.draft = Some(self.settings.clone());
                self.staged = None;
                self.done()
            }
            Request::Set { path, value } => self.set(path, value),
            Request::Stage { offset, bytes } => self.stage(*offset, bytes, block),
            Request::Validate => self.validate(block),
            Request::Commit { .. } if self.moves(now) => self.refuse(Refusal::Moves),
            Request::Commit { confirm_within_s } => self.commit(*confirm_within_s),
            Request::Confirm => match self.origin {
                Origin::Trial(trial) => Outcome::Job(Job::Confirm(trial)),
                _ => self.refuse(Refusal::NotOnTrial),
            },
            Request::Abort if on_trial && self.moves(now) => self.refuse(Refusal::Moves),
            Request::Abort if on_trial => Outcome::Job(Job::EndTrial),
            Request::Abort => {
                self.draft = None;
                self.staged = None;
                self.done()
            }
            Request::Previous => Outcome::Job(Job::Previous),
            _ => self.refuse(Refusal::Unreadable),
        }
    }

    fn list(&mut self, index: u16) -> Outcome {
        let header = self.header();
        let line = parameters::with_entry(&self.settings, index, |entry| {
            encode(header, &Answer::Entry(entry))
        });
        match line {
            Some(line) => self.send(line),
            None => self.say(&Answer::End),
        }
    }

    fn get(&mut self, path: &str) -> Outcome {
        let header = self.header();
        let line = parameters::get(&self.settings, path, |value| {
            encode(header, &Answer::Value(value))
        });
        match line {
            Ok(line) => self.send(line),
            Err(refusal) => self.refuse(refusal),
        }
    }

    fn set(&mut self, path: &str, value: &Value<'_>) -> Outcome {
        let Some(draft) = &mut self.draft else {
            return self.refuse(Refusal::NoDraft);
        };
        match parameters::set(draft, path, value) {
            Ok(()) => self.done(),
            Err(refusal) => self.refuse(refusal),
        }
    }

    fn commit(&mut self, confirm_within_s: u16) -> Outcome {
        let checked = self.draft.as_ref().map(|draft| self.check(draft));
        match checked {
            None => self.refuse(Refusal::NoDraft),
            Some(Err(refusal)) => self.refuse(refusal),
            Some(Ok(())) => Outcome::Job(Job::Commit { confirm_within_s }),
        }
    }

    /// A part of the image of the settings in use.
    fn image(&mut self, offset: u16, block: &mut Block) -> Outcome {
        self.staged = None;
        let image = Image {
            sequence: sequence(&self.origin),
            settings: self.settings.clone(),
        };
        let Ok(length) = image.encode(block) else {
            return self.refuse(Refusal::Unreadable);
        };
        let part = block.get(offset.into()..length).unwrap_or_default();
        let part = part.get(..part.len().min(PART_BYTES)).unwrap_or_default();
        let answer = Answer::Image {
            length: length as u16,
            bytes: part,
        };
        let line = encode(self.header(), &answer);
        self.send(line)
    }

    /// Parts must come in order; the first one restarts.
    fn stage(&mut self, offset: u16, bytes: &[u8], block: &mut Block) -> Outcome {
        if self.draft.is_none() {
            return self.refuse(Refusal::NoDraft);
        }
        let expected = match offset {
            0 => 0,
            _ => self.staged.unwrap_or_default(),
        };
        let at = usize::from(offset);
        match block.get_mut(at..at + bytes.len()) {
            Some(room) if offset == expected => {
                room.copy_from_slice(bytes);
                // A block is shorter than 64 KiB.
                self.staged = Some(offset + bytes.len() as u16);
                self.done()
            }
            _ => self.refuse(Refusal::Unreadable),
        }
    }

    fn validate(&mut self, block: &Block) -> Outcome {
        const { assert!(IMAGE_MAX_BYTES < u16::MAX as usize) };
        let Some(draft) = &mut self.draft else {
            return self.refuse(Refusal::NoDraft);
        };
        if let Some(staged) = self.staged.take() {
            let bytes = block.get(..staged.into()).unwrap_or_default();
            match Image::decode(bytes) {
                Ok(image) => *draft = image.settings,
                Err(error) => return self.refuse(Refusal::Settings(text(error))),
            }
        }
        let checked = self
            .draft
            .as_ref()
            .map_or(Ok(()), |draft| self.check(draft));
        match checked {
            Ok(()) => self.done(),
            Err(refusal) => self.refuse(refusal),
        }
    }

    /// Whether settings are valid, and the processor keeps up with them.
    fn check(&self, settings: &BoardSettings) -> Result<(), Refusal> {
        let checked = settings.validate();
        checked.map_err(|error| Refusal::Settings(text(error)))?;
        self.keeps_up(settings)
    }

    fn keeps_up(&self, settings: &BoardSettings) -> Result<(), Refusal> {
        let accepted = self.processor.accepts(settings);
        accepted.map_err(|slow| Refusal::Settings(text(slow)))
    }

    fn operator(&mut self, text: &str, now: &Now) -> Outcome {
        let Some(command) = Command::from_word(text) else {
            return self.refuse(Refusal::UnknownCommand);
        };
        let leads_to_motion = matches!(command, Command::Arm | Command::Start | Command::Jog(_));
        if leads_to_motion && matches!(self.origin, Origin::Defaults(_)) {
            return self.refuse(Refusal::Unconfigured);
        }
        if leads_to_motion && !self.settings.rsi.says_who_is_robot() {
            return self.refuse(Refusal::AnyRobot);
        }
        if let (true, Err(refusal)) = (leads_to_motion, self.keeps_up(&self.settings)) {
            return self.refuse(refusal);
        }
        if !now.status.connected {
            return self.refuse(Refusal::NoRobot);
        }
        Outcome::Job(Job::Operator(command))
    }
}
