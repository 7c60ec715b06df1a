//! From a datagram to its answer: check of sender, format and sequence, then one control cycle.
//!
//! The robot gets an answer with its own counter whenever that can be read. A sender that is not the robot gets none and changes
//! nothing.

use crate::record::{CycleRecord, Inputs, Output, RobotReport};
use crate::robot_cycle::RobotCycle;
use crate::robot_protocol::{Received, RobotProtocol};
use crate::rsi::Rsi;
use crate::settings::{BoardSettings, BoardSettingsError};
use crate::shared::LinkCounters;
use core::net::{IpAddr, SocketAddr};
use softdock_control::checked::Checked;
use softdock_control::cost::Probe;
use softdock_control::cycle::Cycle;
use softdock_control::io::{SensorSample, Sequence};
use softdock_control::modes::{Command, Mode};
use softdock_control::range::SettingsError;
use softdock_control::scalar::Scalar;
use softdock_control::settings::Settings;
use softdock_link::rsi::SEN_MAX_BYTES;

/// Cycles without a telegram after which the robot counts as silent.
const SILENT_CYCLES: u64 = 3;

/// Longest answer of any protocol.
pub const ANSWER_MAX_BYTES: usize = SEN_MAX_BYTES;

/// An answer as bytes.
pub type Answer = heapless::Vec<u8, ANSWER_MAX_BYTES>;

/// Senders that may be the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Senders {
    /// Its address; `None`: the first sender of a telegram is the robot.
    pub allowed: Option<IpAddr>,
    /// Silence after which another sender may become the robot, µs.
    pub silence_us: u64,
}

/// The robot's link and the control cycle behind it.
#[derive(Clone, Debug)]
pub struct RobotLink<S: Scalar, P: RobotProtocol = Rsi> {
    cycle: RobotCycle<S, P>,
    senders: Senders,
    cycle_us: u64,
    /// The robot's address and when it was last heard.
    robot: Option<(SocketAddr, u64)>,
    /// The answer of the last cycle, its length, and whether it asks the robot to stop. It is written
    /// in place: to move a whole buffer costs more than to write the answer.
    last_answer: [u8; ANSWER_MAX_BYTES],
    last_length: usize,
    /// Counter of the telegram that it answers.
    last_counter: u64,
    stop: bool,
    counters: LinkCounters,
}

/// What a datagram turned out to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Incoming {
    /// A telegram of the robot; [`RobotLink::follow`] gives its position in the sequence.
    Telegram(RobotReport),
    /// A telegram of the robot of which only the counter can be read: no cycle is run, the answer is
    /// [`RobotLink::resting_answer`]. The next telegram then follows a gap.
    Unreadable {
        /// Its counter.
        counter: u64,
    },
    /// No answer.
    Ignored,
}

impl Incoming {
    /// The telegram's own counter, which its answer will carry.
    fn counter(&self) -> Option<u64> {
        match self {
            Self::Telegram(RobotReport { counter, .. }) | Self::Unreadable { counter } => {
                Some(*counter)
            }
            Self::Ignored => None,
        }
    }
}

/// What a link is built of: settings that have passed their checks.
#[derive(Clone, Debug)]
pub struct Prepared<P: RobotProtocol = Rsi> {
    settings: Checked,
    protocol: P,
    senders: Senders,
}

impl Prepared<Rsi> {
    /// For a KUKA robot.
    ///
    /// # Errors
    /// The settings may not be used.
    pub fn new(settings: &BoardSettings) -> Result<Self, BoardSettingsError> {
        settings.validate()?;
        let protocol = Rsi::new(&settings.control.robot, &settings.rsi)?;
        let senders = Senders {
            allowed: settings.rsi.robot_ip()?,
            silence_us: settings.rsi.silence_us(),
        };
        Ok(Self::with(&settings.control, protocol, senders)?)
    }
}

impl<P: RobotProtocol> Prepared<P> {
    /// For any robot.
    ///
    /// # Errors
    /// A setting is outside of its range.
    pub fn with(settings: &Settings, protocol: P, senders: Senders) -> Result<Self, SettingsError> {
        Ok(Self {
            settings: Checked::new(settings, &protocol.interface())?,
            protocol,
            senders,
        })
    }
}

impl<S: Scalar, P: RobotProtocol> RobotLink<S, P> {
    /// A link to which no robot is connected yet.
    #[inline(always)] // or each level would hold a copy of the law on the stack
    pub fn new(prepared: Prepared<P>) -> Self {
        let Prepared {
            settings,
            protocol,
            senders,
        } = prepared;
        let cycle_us = (protocol.interface().cycle_s * 1e6 + 0.5) as u64;
        Self {
            cycle: RobotCycle::with(settings, protocol),
            senders,
            cycle_us,
            robot: None,
            last_answer: [0; ANSWER_MAX_BYTES],
            last_length: 0,
            last_counter: 0,
            stop: false,
            counters: LinkCounters::default(),
        }
    }

    /// The mode of the control cycle.
    pub fn mode(&self) -> Mode {
        self.cycle().mode()
    }

    /// The control cycle, for observers.
    pub fn cycle(&self) -> &Cycle<S> {
        self.cycle.cycle()
    }

    /// Counters of the link.
    pub fn counters(&self) -> LinkCounters {
        self.counters
    }

    /// Counts a telegram of the robot that a newer one has overtaken.
    pub fn count_overtaken(&mut self) {
        self.counters.overtaken = self.counters.overtaken.saturating_add(1);
    }

    /// Time from which the robot counts as silent if it is not heard before, µs; `u64::MAX` before the first telegram.
    pub fn silent_at_us(&self) -> u64 {
        self.robot.map_or(u64::MAX, |(_, heard_us)| {
            heard_us.saturating_add(SILENT_CYCLES * self.cycle_us)
        })
    }

    /// When the robot was last heard, µs.
    pub fn heard_us(&self) -> u64 {
        self.robot.map_or(0, |(_, heard_us)| heard_us)
    }

    /// Length of the robot's cycle, µs.
    pub fn cycle_us(&self) -> u64 {
        self.cycle_us
    }

    /// Classifies a datagram; `now_us` only serves to detect silence.
    pub fn receive(&mut self, datagram: &[u8], from: SocketAddr, now_us: u64) -> Incoming {
        if !self.is_robot(from, now_us) {
            self.counters.foreign = self.counters.foreign.saturating_add(1);
            return Incoming::Ignored;
        }
        match self.cycle.protocol().read(datagram) {
            Received::Telegram(telegram) => {
                self.connect(from, now_us);
                Incoming::Telegram(telegram)
            }
            Received::Counter(counter) => self.malformed(Some(counter), from, now_us),
            Received::Unreadable => self.malformed(None, from, now_us),
        }
    }

    /// Whether one datagram was overtaken on its way by another one.
    pub fn is_late(&self, datagram: &Incoming, other: &Incoming) -> bool {
        let counters = datagram.counter().zip(other.counter());
        counters.is_some_and(|(counter, other)| self.cycle.protocol().is_late(counter, other))
    }

    /// Position of a telegram in the sequence; `None` for a repetition of the last one, which must not move anything again, and
    /// for one that was overtaken by the last: see [`Self::has_answered`].
    pub fn follow(&mut self, telegram: &RobotReport) -> Option<Sequence> {
        let sequence = self.cycle.protocol_mut().follow(telegram.counter);
        let counters = &mut self.counters;
        match sequence {
            Some(Sequence::NewRun) => counters.runs = counters.runs.saturating_add(1),
            Some(Sequence::Next) => {}
            Some(Sequence::Gap(lost)) => counters.lost = counters.lost.saturating_add(lost),
            None if telegram.counter == self.last_counter => {
                counters.duplicates = counters.duplicates.saturating_add(1);
            }
            None => self.count_overtaken(),
        }
        sequence
    }

    /// Runs the control cycle for a telegram; the answer is then [`Self::last_answer`].
    pub fn run_cycle(
        &mut self,
        telegram: &RobotReport,
        sequence: Sequence,
        sensor: SensorSample,
        command: Option<Command>,
    ) -> CycleRecord {
        self.run_cycle_counted(telegram, sequence, sensor, command, &mut ())
    }

    /// [`Self::run_cycle`] that reports the finished phases of the cycle.
    pub fn run_cycle_counted(
        &mut self,
        telegram: &RobotReport,
        sequence: Sequence,
        sensor: SensorSample,
        command: Option<Command>,
        probe: &mut impl Probe,
    ) -> CycleRecord {
        let robot = RobotReport {
            sequence,
            ..*telegram
        };
        let inputs = Inputs {
            robot,
            sensor,
            command,
        };
        let record = self.cycle.step_counted(&inputs, probe);
        self.stop = record.output.stop;
        let (counter, bytes) = (telegram.counter, &mut self.last_answer);
        self.last_length = self.cycle.protocol().write(counter, &record.output, bytes);
        self.last_counter = counter;
        self.counters.cycles += 1;
        record
    }

    /// Whether the last cycle was for this telegram: its answer is [`Self::last_answer`], any other's is
    /// [`Self::resting_answer`].
    pub fn has_answered(&self, telegram: &RobotReport) -> bool {
        telegram.counter == self.last_counter
    }

    /// The answer of the last cycle.
    pub fn last_answer(&self) -> &[u8] {
        self.last_answer.get(..self.last_length).unwrap_or_default()
    }

    /// The answer that moves nothing, for a telegram without a cycle.
    pub fn resting_answer(&self, counter: u64) -> Answer {
        let rest = Output {
            correction: self.cycle.rest(),
            stop: self.stop,
        };
        let mut bytes = [0; ANSWER_MAX_BYTES];
        let length = self.cycle.protocol().write(counter, &rest, &mut bytes);
        Answer::from_slice(bytes.get(..length).unwrap_or_default()).unwrap_or_default()
    }

    /// Whether a datagram may be the robot's: its configured address, and the sender that is
    /// connected, unless that has been silent for too long.
    fn is_robot(&self, from: SocketAddr, now_us: u64) -> bool {
        let allowed = self.senders.allowed.is_none_or(|ip| ip == from.ip());
        let free = match self.robot {
            Some((robot, heard)) => {
                robot == from || now_us.saturating_sub(heard) > self.senders.silence_us
            }
            None => true,
        };
        allowed && free
    }

    fn connect(&mut self, from: SocketAddr, now_us: u64) {
        if self.robot.is_none_or(|(robot, _)| robot != from) {
            self.cycle.protocol_mut().forget();
        }
        self.robot = Some((from, now_us));
    }

    /// The connected robot gets an answer if its counter can be read.
    fn malformed(&mut self, counter: Option<u64>, from: SocketAddr, now_us: u64) -> Incoming {
        self.counters.malformed = self.counters.malformed.saturating_add(1);
        if self.robot.is_none_or(|(robot, _)| robot != from) {
            return Incoming::Ignored;
        }
        self.robot = Some((from, now_us));
        match counter {
            Some(counter) => Incoming::Unreadable { counter },
            None => Incoming::Ignored,
        }
    }
}
