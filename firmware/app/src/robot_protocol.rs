//! What the board needs of a robot's protocol. [`Rsi`](crate::rsi::Rsi) is one.
//!
//! The robot is the clock: it sends a telegram each cycle and wants one answer with the same
//! counter. A protocol says what its telegrams mean, and puts what the control cycle wants into the
//! numbers that its robot takes. Who may send, what a repeated, damaged or missing telegram leads
//! to, and when a cycle runs is the same for all robots ([`RobotLink`](crate::robot_link)).

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

/// A robot's protocol, and what it must remember of the telegrams and answers so far.
pub trait RobotProtocol {
    /// Cycle and angles of the robot.
    fn interface(&self) -> RobotInterface;

    /// Reads a datagram. Any bytes may come.
    fn read(&self, datagram: &[u8]) -> Received;

    /// Another robot has connected: the next telegram is the first.
    fn forget(&mut self);

    /// Where a telegram stands in the sequence, by its counter; none for the last one again, and for one that it has overtaken.
    fn follow(&mut self, counter: u64) -> Option<Sequence>;

    /// Whether the telegram with this counter was overtaken on its way by another one.
    fn is_late(&self, counter: u64, other: u64) -> bool;

    /// A telegram as the control cycle takes it. A pose that is none is NaN.
    fn sample(&self, report: &RobotReport) -> RobotSample;

    /// Puts what the cycle wants into the robot's numbers. A `report` that begins anew forgets what
    /// was sent; where [`start`](io::Output::start) is set, displacements count from its pose. What
    /// is rounded away is carried into the next cycle: the sum of what was sent stays within a
    /// rounding of what was meant.
    fn correct(&mut self, report: &RobotReport, wanted: &io::Output) -> Correction;

    /// The correction that moves nothing.
    fn rest(&self) -> Correction;

    /// Writes the answer to the telegram with this counter; its length, 0 if it does not fit: no
    /// answer is better than a wrong one. [`ANSWER_MAX_BYTES`](crate::robot_link::ANSWER_MAX_BYTES)
    /// must be enough.
    fn write(&self, counter: u64, answer: &Output, bytes: &mut [u8]) -> usize;
}
