//! Texts of refusals and faults for people. Recordings have their own names, which never change.

use super::{FaultCode, Refusal};
use core::fmt::{Display, Formatter, Result};

impl Display for Refusal {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.write_str(match self {
            Self::WrongMode => "it does not apply in this mode",
            Self::SensorStale => "there is no fresh sensor sample",
            Self::SensorUnhealthy => "the sensor reports an error or is saturated",
            Self::NoPose => "the robot's telegrams carry no pose",
            Self::ForceTooLarge => "the force or torque at rest is too large",
            Self::StillMoving => "the last motion has not faded out",
            Self::MovedSinceArmed => "the robot was moved after it was armed",
            Self::TooFewSamples => "there are too few good samples for a mean",
            Self::OrientationSingular => "the robot is near the gimbal lock of its angles",
            Self::NoRoom => "the jog has no room",
        })
    }
}

/// The quantity to which the numbers of a [`Fault`](super::Fault) refer.
impl Display for FaultCode {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.write_str(match self {
            Self::SensorStale => "cycles without a new sensor sample",
            Self::SensorFrozen => "cycles with the same sensor reading",
            Self::SensorStatus => "status word of the sensor",
            Self::SensorSaturated => "gauge of the sensor at its range",
            Self::Overload => "contact force (N) or torque (N m)",
            Self::ContactAtStart => "contact force (N) or torque (N m) during the start ramp",
            Self::Numeric => "number that is not finite or beyond its range",
            Self::TelegramsLost => "telegrams lost in a row",
            Self::RobotRestarted => "restart of the robot while the loop was closed",
            Self::LateAnswers => "late answers counted by the robot",
            Self::SustainedClamp => "cycles in a row at a limit of the motion",
            Self::PoseLost => "telegrams without a pose",
            Self::ActuatorUnlike => {
                "misfit of the robot's motion to `delay.actuator`, as a part of its lag"
            }
        })
    }
}
