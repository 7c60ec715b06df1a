//! Requests and answers.

use super::Setting;
use anyhow::Result;
use softdock_io::port::Port;
use softdock_link::service::{
    Answer, Counters, FlashSlot, Frame, FrameReader, Health, Hello, Kind, LogLine, LoopBack,
    Machine, PROTOCOL, Refusal, Request, SelfTest, Status,
};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{Read, Write};
use std::time::{Duration, Instant};

/// Time after which an answer counts as lost: the longest one takes 0.1 s on the line.
const ANSWER: Duration = Duration::from_millis(400);
/// Times that a request is sent.
pub(super) const ATTEMPTS: u32 = 6;
/// The same for requests that write flash. This takes two erasures of 2 s (STM32H743 data sheet) and more: a request that is
/// repeated meanwhile waits, and is answered without being carried out twice.
const FLASH_ANSWER: Duration = Duration::from_secs(3);
/// Times that such a request is sent.
const FLASH_ATTEMPTS: u32 = 4;

/// Most lines of a board's log that are requested: many times what a board keeps, which may add lines meanwhile.
const LOG_LINES: usize = 1000;

/// Why there is no answer, or not the one that was wanted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LinkError {
    /// Nothing came.
    #[error(
        "no answer: is the board powered and running, is this its port, is the baud rate right (--baud; a NUCLEO has 115200), and is no other program connected to it?"
    )]
    Silent,
    /// Something came that makes no sense.
    #[error(
        "{0} bytes came, but nothing that a board says: is the baud rate right (--baud; a NUCLEO has 115200), and is this the board's port?"
    )]
    Garbled(usize),
    /// The line ended.
    #[error(
        "the connection has ended: the board was unplugged or stopped, or another program has its port"
    )]
    Closed,
    /// The board says no.
    #[error("{0}")]
    Refused(Refusal),
    /// The board speaks another version of the protocol.
    #[error(
        "the board speaks version {board} of the protocol, this softdock version {PROTOCOL}; use the softdock that fits its firmware: {identity}"
    )]
    Protocol {
        /// Its version.
        board: u8,
        /// Its firmware.
        identity: String,
    },
    /// An answer to another question.
    #[error("the board answers something else than it was asked")]
    Unexpected,
}

/// Who the board is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Identity {
    /// Schema of its settings.
    pub schema: u32,
    /// A number that differs from boot to boot.
    pub boot: u32,
    /// Firmware and board.
    pub text: String,
}

/// A conversation with a board.
pub struct Client {
    port: Port,
    frames: FrameReader,
    sequence: u16,
    /// Number of the conversation, as the frame of the board's hello bore it; 0 before.
    conversation: u32,
    identity: Identity,
}

/// A frame as it came.
struct Reply {
    kind: Kind,
    conversation: u32,
    payload: Vec<u8>,
}

impl Client {
    /// Asks the board who it is.
    ///
    /// # Errors
    /// There is no board, or it speaks another version.
    pub fn connect(port: Port) -> Result<Self, LinkError> {
        let mut client = Self {
            port,
            frames: FrameReader::new(),
            // Not the number with which another program's conversation went on.
            sequence: RandomState::new().build_hasher().finish() as u16,
            conversation: 0,
            identity: Identity::default(),
        };
        client.hello(ATTEMPTS)?;
        Ok(client)
    }

    /// Who the board is.
    pub fn identity(&self) -> &Identity {
        &self.identity
    }

    /// Asks anew who the board is.
    ///
    /// # Errors
    /// As [`Self::connect`].
    pub fn hello(&mut self, attempts: u32) -> Result<(), LinkError> {
        let reply = self.exchange(Kind::Hello, &[], ANSWER, attempts)?;
        self.identity = identity(&reply)?;
        self.conversation = reply.conversation;
        Ok(())
    }

    /// Sends a request until it is answered.
    ///
    /// # Errors
    /// There is no answer, or it is a refusal.
    pub fn call<R>(
        &mut self,
        request: &Request<'_>,
        take: impl FnOnce(Answer<'_>) -> Option<R>,
    ) -> Result<R, LinkError> {
        let (patience, attempts) = match request {
            Request::Commit { .. } | Request::Confirm | Request::Previous => {
                (FLASH_ANSWER, FLASH_ATTEMPTS)
            }
            _ => (ANSWER, ATTEMPTS),
        };
        let payload = postcard::to_slice(request, &mut [0; 1024])
            .map_err(|_| LinkError::Unexpected)?
            .to_vec();
        let reply = self.exchange(Kind::Request, &payload, patience, attempts)?;
        if reply.kind == Kind::HelloAnswer {
            identity(&reply)?;
        }
        match postcard::from_bytes(&reply.payload) {
            Ok(Answer::Refused(refusal)) => Err(LinkError::Refused(refusal)),
            Ok(answer) => take(answer).ok_or(LinkError::Unexpected),
            Err(_) => Err(LinkError::Unexpected),
        }
    }

    /// A request that is answered with [`Answer::Done`].
    ///
    /// # Errors
    /// As [`Self::call`].
    pub fn expect_done(&mut self, request: &Request<'_>) -> Result<(), LinkError> {
        self.call(request, |answer| (answer == Answer::Done).then_some(()))
    }

    /// All settings; `progress` is told how many of how many there are.
    ///
    /// # Errors
    /// As [`Self::call`].
    pub fn list(&mut self, mut progress: impl FnMut(u16, u16)) -> Result<Vec<Setting>, LinkError> {
        let mut settings = Vec::new();
        for index in 0..=u16::MAX {
            let entry = self.call(&Request::List(index), |answer| match answer {
                Answer::Entry(entry) if index < entry.of => {
                    Some(Some((entry.of, Setting::from(entry))))
                }
                Answer::End => Some(None),
                _ => None,
            })?;
            let Some((of, setting)) = entry else { break };
            settings.push(setting);
            progress(index + 1, of);
        }
        Ok(settings)
    }

    /// The state of the board.
    ///
    /// # Errors
    /// As [`Self::call`].
    pub fn status(&mut self) -> Result<Status, LinkError> {
        self.call(&Request::Status, |answer| match answer {
            Answer::Status(status) => Some(status),
            _ => None,
        })
    }

    /// Its counters.
    ///
    /// # Errors
    /// As [`Self::call`].
    pub fn counters(&mut self) -> Result<Counters, LinkError> {
        self.call(&Request::Counters, |answer| match answer {
            Answer::Counters(counters) => Some(counters),
            _ => None,
        })
    }

    /// How robot and sensor are at this instant.
    ///
    /// # Errors
    /// As [`Self::call`]; older firmware refuses it as [`Refusal::Unreadable`].
    pub fn health(&mut self) -> Result<Health, LinkError> {
        self.call(&Request::Health, |answer| match answer {
            Answer::Health(health) => Some(health),
            _ => None,
        })
    }

    /// What is in the slots of its flash.
    ///
    /// # Errors
    /// As [`Self::health`].
    pub fn slots(&mut self) -> Result<[FlashSlot; 2], LinkError> {
        self.call(&Request::Slots, |answer| match answer {
            Answer::Slots(slots) => Some(slots),
            _ => None,
        })
    }

    /// State of the board itself: stack, Ethernet, answer times and noise of the sensor.
    ///
    /// # Errors
    /// As [`Self::health`].
    pub fn machine(&mut self) -> Result<Machine, LinkError> {
        self.call(&Request::Machine, |answer| match answer {
            Answer::Machine(machine) => Some(machine),
            _ => None,
        })
    }

    /// Result of CAN frames that the board sends to itself; None if it has no controller that can.
    ///
    /// # Errors
    /// As [`Self::health`]; or the robot moves.
    pub fn loop_back(&mut self) -> Result<Option<LoopBack>, LinkError> {
        self.call(&Request::SelfTest(SelfTest::Can), |answer| match answer {
            Answer::LoopBack(outcome) => Some(outcome),
            _ => None,
        })
    }

    /// Lights these LEDs, in the order green, yellow, red; None returns them to their normal use.
    ///
    /// # Errors
    /// As [`Self::loop_back`].
    pub fn lamps(&mut self, lit: Option<[bool; 3]>) -> Result<(), LinkError> {
        self.expect_done(&Request::SelfTest(SelfTest::Lamps(lit)))
    }

    /// The lines of its log that it still has, from a number on.
    ///
    /// # Errors
    /// As [`Self::call`].
    pub fn log(&mut self, mut from: u32) -> Result<Vec<LogLine>, LinkError> {
        let mut lines = Vec::new();
        while lines.len() < LOG_LINES {
            let more = self.call(&Request::Log(from), |answer| match answer {
                Answer::Log(lines) => Some(lines),
                _ => None,
            })?;
            let Some(last) = more.last() else { break };
            from = last.number.wrapping_add(1);
            lines.extend(more);
        }
        Ok(lines)
    }

    /// The whole image of the settings in use, as it would lie in flash.
    ///
    /// # Errors
    /// As [`Self::call`].
    pub fn image(&mut self) -> Result<Vec<u8>, LinkError> {
        let mut image = Vec::new();
        loop {
            let offset = image.len() as u16;
            let (length, part) = self.call(&Request::Image(offset), |answer| match answer {
                Answer::Image { length, bytes } => Some((length, bytes.to_vec())),
                _ => None,
            })?;
            image.extend(&part);
            if part.is_empty() || image.len() >= usize::from(length) {
                return Ok(image);
            }
        }
    }

    /// Sends a frame until an answer with its number comes.
    fn exchange(
        &mut self,
        kind: Kind,
        payload: &[u8],
        patience: Duration,
        attempts: u32,
    ) -> Result<Reply, LinkError> {
        self.sequence = self.sequence.wrapping_add(1);
        let conversation = match kind {
            Kind::Hello => 0,
            _ => self.conversation,
        };
        let frame = Frame {
            version: PROTOCOL,
            kind,
            sequence: self.sequence,
            conversation,
            payload,
        };
        let line = frame.encode().map_err(|_| LinkError::Unexpected)?;
        let mut heard = 0;
        for _ in 0..attempts {
            self.port.write_all(&line).map_err(|_| LinkError::Closed)?;
            self.port.flush().map_err(|_| LinkError::Closed)?;
            if let Some(reply) = self.reply(patience, &mut heard)? {
                return Ok(reply);
            }
        }
        match heard {
            0 => Err(LinkError::Silent),
            bytes => Err(LinkError::Garbled(bytes)),
        }
    }

    /// The frame with the present number, if it comes in time.
    fn reply(&mut self, patience: Duration, heard: &mut usize) -> Result<Option<Reply>, LinkError> {
        let give_up = Instant::now() + patience;
        let mut bytes = [0; 512];
        while Instant::now() < give_up {
            let length = self.port.read(&mut bytes).map_err(|_| LinkError::Closed)?;
            *heard += length;
            for byte in &bytes[..length] {
                let Some(Ok(frame)) = self.frames.push(*byte) else {
                    continue;
                };
                let answer = matches!(frame.kind, Kind::Answer | Kind::HelloAnswer);
                if answer && frame.sequence == self.sequence {
                    return Ok(Some(Reply {
                        kind: frame.kind,
                        conversation: frame.conversation,
                        payload: frame.payload.to_vec(),
                    }));
                }
            }
        }
        Ok(None)
    }
}

fn identity(reply: &Reply) -> Result<Identity, LinkError> {
    // Later versions may add something at the end.
    let (hello, _) = postcard::take_from_bytes::<Hello<'_>>(&reply.payload)
        .map_err(|_| LinkError::Unexpected)?;
    if hello.protocol != PROTOCOL {
        return Err(LinkError::Protocol {
            board: hello.protocol,
            identity: hello.identity.into(),
        });
    }
    Ok(Identity {
        schema: hello.schema,
        boot: hello.boot,
        text: hello.identity.into(),
    })
}
