//! Interface of a robot's protocol to the board. [`Rsi`](crate::rsi::Rsi) implements it.
//!
//! The robot is the clock: it sends a telegram each cycle and expects one answer with the same counter. A protocol decodes
//! telegrams, and encodes the output of the control cycle as the robot's numbers. Who may send, how repeated, damaged or missing
//! telegrams are handled, and when a cycle runs is the same for all robots ([`RobotLink`](crate::robot_link)).

use crate::record::{Correction, Output, RobotReport};
use softdock_control::io::{self, RobotSample, Sequence};
use softdock_control::robot::RobotInterface;

/// What a datagram turned out to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Received {
    /// A telegram; its place in the sequence is not known yet.
    Telegram(RobotReport),
    /// A damaged telegram whose counter can be trusted: it is answered, and nothing moves.
    Counter(u64),
    /// Nothing that can be answered.
    Unreadable,
}

/// A robot's protocol, with its state between telegrams.
pub trait RobotProtocol {
    /// Cycle and angles of the robot.
    fn interface(&self) -> RobotInterface;

    /// Decodes a datagram, which may hold any bytes.
    fn read(&self, datagram: &[u8]) -> Received;

    /// Another robot has connected: the next telegram is the first.
    fn forget(&mut self);

    /// Position of a telegram in the sequence, by its counter; `None` for a repetition of the last one, and for one that was
    /// overtaken by it.
    fn follow(&mut self, counter: u64) -> Option<Sequence>;

    /// Whether the telegram with this counter was overtaken on its way by another one.
    fn is_late(&self, counter: u64, other: u64) -> bool;

    /// Converts a telegram to the input of the control cycle. An invalid pose is NaN.
    fn sample(&self, report: &RobotReport) -> RobotSample;

    /// Converts the output of the cycle to the robot's numbers. A `report` of a new run resets what was sent; where
    /// [`start`](io::Output::start) is set, displacements count from its pose. Rounding errors are carried into the next cycle:
    /// the sum of what was sent stays within a rounding of what was intended.
    fn correct(&mut self, report: &RobotReport, wanted: &io::Output) -> Correction;

    /// The correction that moves nothing.
    fn rest(&self) -> Correction;

    /// Writes the answer to the telegram with this counter. Returns its length, 0 if it does not fit: no answer is better than a
    /// wrong one. [`ANSWER_MAX_BYTES`](crate::robot_link::ANSWER_MAX_BYTES) must be enough.
    fn write(&self, counter: u64, answer: &Output, bytes: &mut [u8]) -> usize;
}
