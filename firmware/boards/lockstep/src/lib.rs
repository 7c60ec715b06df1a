//! The robot's link and the control cycle, run step by step.
//!
//! A [`Step`] contains all inputs of a board for one answer. [`Done`] contains all results: the bytes of the answer, the
//! record of the cycle, and the cost of each part of the work. A host and the machine code in QEMU run the same [`Session`]
//! on the same steps, and every bit has to be equal. QEMU's virtual time counts instructions, so the cost is exact too.
//!
//! [`frame`] and [`unframe`] put messages into a stream of bytes: two bytes of length, postcard.
#![no_std]

use core::net::{IpAddr, Ipv4Addr, SocketAddr};
use serde::{Deserialize, Serialize};
use softdock_app::record::CycleRecord;
use softdock_app::robot_link::{Answer, Incoming, Prepared, RobotLink};
use softdock_app::settings::{BoardSettings, BoardSettingsError};
use softdock_control::cost::{Phase, Probe};
use softdock_control::io::SensorSample;
use softdock_control::modes::Command;
use softdock_control::scalar::Scalar;

/// Longest datagram of a step.
pub const DATAGRAM_BYTES: usize = 1500;
/// Longest message: a step with its datagram, or a record with its answer.
pub const MESSAGE_BYTES: usize = 4096;

/// A sender on another computer than the robot's.
pub const STRANGER: u8 = 66;

/// Inputs of a board for one answer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// The datagram.
    pub datagram: heapless::Vec<u8, DATAGRAM_BYTES>,
    /// Who sent it: 0 is the robot, [`STRANGER`] another computer, the rest are other programs of the robot's.
    pub sender: u8,
    /// When it came, µs.
    pub now_us: u64,
    /// The newest sensor sample.
    pub sample: SensorSample,
    /// The operator's command.
    pub command: Option<Command>,
}

/// Parts of the work for an answer, in their order.
pub const PARTS: [&str; 7] = [
    "parse", "wrench", "dynamics", "law", "limits", "trace", "write",
];

/// Cost of each of [`PARTS`], in ticks of the counter.
pub type Cost = [u32; PARTS.len()];

/// Functions whose cost is compared.
pub const FUNCTIONS: [&str; 4] = [
    "square root",
    "sine",
    "arc tangent of two",
    "logarithm to base 10",
];
/// Libraries with these functions. The first is for numbers that are only displayed, the last for the control cycle.
pub const LIBRARIES: [&str; 3] = ["micromath", "libm, f32", "libm, f64"];
/// Calls of each.
pub const CALLS: u32 = 1000;

/// Ticks of the counter for [`CALLS`] calls of each of [`FUNCTIONS`] in each of [`LIBRARIES`].
pub type FunctionCosts = [[u32; LIBRARIES.len()]; FUNCTIONS.len()];

/// Results of a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Done {
    /// The answer; empty if there is none.
    pub answer: Answer,
    /// The cycle, if one was run.
    pub record: Option<CycleRecord>,
    /// Cost of the cycle; zeros without a cycle.
    pub cost: Cost,
}

/// A counter that increases with the work done.
pub trait Counter {
    /// The count; it may wrap.
    fn count(&mut self) -> u32;
}

/// Always zero.
impl Counter for () {
    fn count(&mut self) -> u32 {
        0
    }
}

/// A robot's link with its control cycle.
#[derive(Clone, Debug)]
pub struct Session<S: Scalar>(RobotLink<S>);

impl<S: Scalar> Session<S> {
    /// From settings, which are checked.
    ///
    /// # Errors
    /// The settings are not valid.
    pub fn new(settings: &BoardSettings) -> Result<Self, BoardSettingsError> {
        Prepared::new(settings).map(RobotLink::new).map(Self)
    }

    /// Handles a datagram as the robot task does.
    pub fn take(&mut self, step: &Step, counter: &mut impl Counter) -> Done {
        let mut done = Done {
            answer: Answer::new(),
            record: None,
            cost: Cost::default(),
        };
        let mut meter = CostMeter::start(counter);
        match self.0.receive(&step.datagram, sender(step), step.now_us) {
            Incoming::Telegram(telegram) => {
                if let Some(sequence) = self.0.follow(&telegram) {
                    meter.finish(0);
                    let (sample, command) = (step.sample, step.command);
                    let record = self
                        .0
                        .run_cycle_counted(&telegram, sequence, sample, command, &mut meter);
                    meter.finish(PARTS.len() - 1);
                    done.cost = meter.cost;
                    done.record = Some(record);
                }
                done.answer = Answer::from_slice(self.0.last_answer()).unwrap_or_default();
            }
            Incoming::Unreadable { counter } => done.answer = self.0.resting_answer(counter),
            Incoming::Ignored => {}
        }
        done
    }
}

fn sender(step: &Step) -> SocketAddr {
    let (computer, port) = match step.sender {
        STRANGER => (STRANGER, 0),
        port => (10, port),
    };
    let computer = Ipv4Addr::new(192, 168, 1, computer);
    SocketAddr::new(IpAddr::V4(computer), 49_152 + u16::from(port))
}

/// Reads the counter at the end of each part.
struct CostMeter<'a, C: Counter> {
    counter: &'a mut C,
    last: u32,
    cost: Cost,
}

impl<'a, C: Counter> CostMeter<'a, C> {
    fn start(counter: &'a mut C) -> Self {
        let last = counter.count();
        Self {
            counter,
            last,
            cost: Cost::default(),
        }
    }

    /// Ends a part, an index of [`PARTS`].
    fn finish(&mut self, part: usize) {
        let now = self.counter.count();
        if let Some(cost) = self.cost.get_mut(part) {
            *cost = now.wrapping_sub(self.last);
        }
        self.last = now;
    }
}

impl<C: Counter> Probe for CostMeter<'_, C> {
    fn finished(&mut self, phase: Phase) {
        let index = Phase::ALL.iter().position(|known| *known == phase);
        self.finish(1 + index.unwrap_or(0));
    }
}

/// A message that cannot be written or read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadMessage;

/// Writes the length of a message and the message; returns the used bytes of `buffer`.
///
/// # Errors
/// The message is longer than `buffer`.
pub fn frame<'a>(message: &impl Serialize, buffer: &'a mut [u8]) -> Result<&'a [u8], BadMessage> {
    let (length, body) = buffer.split_first_chunk_mut::<2>().ok_or(BadMessage)?;
    let written = postcard::to_slice(message, body).map_err(|_| BadMessage)?;
    let count = written.len();
    *length = u16::try_from(count).map_err(|_| BadMessage)?.to_le_bytes();
    buffer.get(..2 + count).ok_or(BadMessage)
}

/// Reads a message, without its length.
///
/// # Errors
/// The bytes are not such a message.
pub fn unframe<'a, T: Deserialize<'a>>(body: &'a [u8]) -> Result<T, BadMessage> {
    postcard::from_bytes(body).map_err(|_| BadMessage)
}
