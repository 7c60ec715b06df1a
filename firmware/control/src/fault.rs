//! Faults, which end a run until they are reset.

/// What latched a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum FaultCode {
    /// No new sensor sample for too long (expected: most cycles; received: cycles).
    SensorStale,
    /// Samples with the same six words for too long (most cycles; cycles).
    SensorFrozen,
    /// A status bit of the sensor (0; status word).
    SensorStatus,
    /// A gauge at its range (0; 1).
    SensorSaturated,
    /// Contact force or torque beyond its limit (limit; value).
    Overload,
    /// Contact during the start ramp (largest force; value).
    ContactAtStart,
    /// A number that is not finite (0; 0), or a pose beyond its declared range (limit; value).
    Numeric,
    /// Too many telegrams lost in a row (limit; lost).
    TelegramsLost,
    /// The robot began anew while the loop was closed.
    RobotRestarted,
    /// The robot counts late answers (most; count).
    LateAnswers,
    /// A limit clamped for too long (most cycles; cycles).
    SustainedClamp,
    /// The robot's telegrams stopped carrying a pose.
    PoseLost,
    /// The robot does not move as `delay.actuator` says (largest misfit; misfit, both as a part of
    /// the distance that it is late).
    ActuatorUnlike,
}

/// A latched fault with the numbers that caused it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Fault {
    /// The cause.
    pub code: FaultCode,
    /// The limit or the expected value, see [`FaultCode`].
    pub expected: f64,
    /// What came.
    pub received: f64,
}

impl Fault {
    /// A fault with its numbers.
    pub fn new(code: FaultCode, expected: f64, received: f64) -> Self {
        Self {
            code,
            expected,
            received,
        }
    }
}
