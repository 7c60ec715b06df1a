//! Hooks to measure the cost of a cycle.
//!
//! The cycle itself has no clock. It reports each finished part to a [`Probe`]; a board reads its counter of instructions or
//! cycles there. Everybody else passes `()`, which costs nothing.

/// A part of a cycle, in the order in which they are done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Checks of the input, pose, and the wrench without the tool's weight and inertia.
    Wrench,
    /// Commands of the operator and load limits, then the motion of the two spacecraft.
    Dynamics,
    /// Compensation of the robot's delay.
    Law,
    /// Limits, commanded pose and rounding.
    Limits,
    /// The trace for the recording.
    Trace,
}

impl Phase {
    /// All of them in their order.
    pub const ALL: [Self; 5] = [
        Self::Wrench,
        Self::Dynamics,
        Self::Law,
        Self::Limits,
        Self::Trace,
    ];
}

/// Is notified of finished phases.
pub trait Probe {
    /// Called when a phase is finished. Without a closed loop [`Phase::Dynamics`] and [`Phase::Law`] are not reported.
    fn finished(&mut self, phase: Phase);
}

impl Probe for () {
    fn finished(&mut self, _phase: Phase) {}
}
