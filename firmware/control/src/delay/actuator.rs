//! What the settings say about the robot: its delay and its dynamics.
//!
//! In the order of the chain: a transport delay, a first-order lag, a second-order servo, and a pause when the executed velocity
//! crosses zero. `softdock identify actuator` measures them. The default is a pure delay: it is the wrong assumption with which
//! no law diverges. A lag that is assumed and not there is inverted, and that diverges.

use crate::range::{SettingsError, in_range};

crate::described! {
/// The robot's delay and its structure. Laws that need none of it ignore it. By default the delay that is seen at a common
/// industrial robot, and nothing else.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct ActuatorSettings {
    /// Transport delay from a command to its execution, s.
    pub delay_s: f64 = 0.032,
    /// Time constant of a first-order lag behind it, s; 0 is none.
    pub lag_s: f64 = 0.0,
    /// Natural frequency of a second-order servo behind that, Hz; 0 is none.
    pub servo_hz: f64 = 0.0,
    /// Damping ratio of the servo.
    pub servo_damping: f64 = 0.7,
    /// Time for which the robot stands still when its velocity crosses zero, s.
    pub pause_s: f64 = 0.0,
    /// Cycles by which the reported pose is older than the measured force.
    pub feedback_latency_cycles: u8 = 0,
    /// That number has been measured. If not, a law that depends on it finds out by itself.
    pub feedback_latency_known: bool = false,
}
}

impl ActuatorSettings {
    /// Checks every field.
    pub fn validate(&self) -> Result<(), SettingsError> {
        in_range("delay.actuator.delay_s", self.delay_s, 0.0, 0.2)?;
        in_range("delay.actuator.lag_s", self.lag_s, 0.0, 0.2)?;
        // Below 1 Hz an impulse response would not end within the commands that are kept.
        let servo = if self.has_servo() { 1.0 } else { 0.0 };
        in_range("delay.actuator.servo_hz", self.servo_hz, servo, 200.0)?;
        let damping = self.servo_damping;
        in_range("delay.actuator.servo_damping", damping, 0.2, 2.0)?;
        in_range("delay.actuator.pause_s", self.pause_s, 0.0, 0.1)?;
        let latency = f64::from(self.feedback_latency_cycles);
        in_range("delay.actuator.feedback_latency_cycles", latency, 0.0, 8.0)
    }

    /// Whether there is a second-order servo.
    pub fn has_servo(&self) -> bool {
        self.servo_hz > 0.0
    }

    /// Mean delay of a slow motion, s: the delay, the lag, and 2ζ/ω of the servo.
    ///
    /// ```
    /// use softdock_control::delay::actuator::ActuatorSettings;
    /// let mut robot = ActuatorSettings { delay_s: 0.016, lag_s: 0.016, ..Default::default() };
    /// assert_eq!(robot.mean_delay_s(), 0.032);
    /// robot.servo_hz = 10.0;
    /// assert!((robot.mean_delay_s() - 0.032 - 0.0223).abs() < 1e-4);
    /// ```
    pub fn mean_delay_s(&self) -> f64 {
        let servo = if self.has_servo() {
            2.0 * self.servo_damping / (core::f64::consts::TAU * self.servo_hz)
        } else {
            0.0
        };
        self.delay_s + self.lag_s + servo
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_out_of_range_is_named() {
        assert_eq!(ActuatorSettings::default().validate(), Ok(()));
        let cases = [
            ActuatorSettings {
                delay_s: 0.3,
                ..Default::default()
            },
            ActuatorSettings {
                servo_hz: 0.5,
                ..Default::default()
            },
            ActuatorSettings {
                feedback_latency_cycles: 9,
                ..Default::default()
            },
        ];
        let fields = cases.map(|case| case.validate().unwrap_err().field);
        let names = ["delay_s", "servo_hz", "feedback_latency_cycles"];
        for (field, name) in fields.iter().zip(names) {
            assert_eq!(*field, format!("delay.actuator.{name}"));
        }
    }

    /// The delay of a ramp through the chain: lags add up.
    #[test]
    fn the_mean_delay_is_that_of_a_slow_motion() {
        let robot = ActuatorSettings {
            delay_s: 0.016,
            lag_s: 0.012,
            servo_hz: 10.0,
            servo_damping: 0.7,
            ..ActuatorSettings::default()
        };
        let (mut lag, mut position, mut rate) = (0.0, 0.0, 0.0);
        let (step, omega) = (1e-5, core::f64::consts::TAU * 10.0);
        let mut time = 0.0;
        while time < 1.0 {
            let input = f64::max(time - 0.016, 0.0);
            rate += step * (omega * omega * (lag - position) - 2.0 * 0.7 * omega * rate);
            position += step * rate;
            lag += step * (input - lag) / 0.012;
            time += step;
        }
        let late = time - position;
        assert!((robot.mean_delay_s() - late).abs() < 5e-5, "{late}");
        let none = ActuatorSettings {
            servo_hz: 0.0,
            ..robot
        };
        assert!((none.mean_delay_s() - 0.028).abs() < 1e-12);
    }
}
