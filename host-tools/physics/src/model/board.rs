//! The settings of the board's robot that follow from a model.

use super::Model;
use crate::effects::actuator::{
    actuation_delay, actuation_lag, second_order_servo, zero_cross_pause,
};
use softdock_control::delay::actuator::ActuatorSettings;

impl Model {
    /// The robot for the board's delay laws: the nominal delay and lag plus those of effects, a servo, and the pause at a
    /// reversal. The laws treat all axes alike, so an effect of some axes is taken for all.
    pub fn robot_for_board(&self) -> ActuatorSettings {
        let value = |id: &str, parameter: &str| {
            let effect = self.effects.iter().find(|effect| effect.id == id);
            effect.and_then(|effect| effect.parameters.get(parameter).copied())
        };
        let added = |id, parameter| value(id, parameter).unwrap_or(0.0);
        let default = ActuatorSettings::default();
        let instead_of_lag = added(second_order_servo::EFFECT.id, "instead_of_lag") == 1.0;
        let robot = ActuatorSettings {
            delay_s: self.actuator.transport_delay_s
                + added(actuation_delay::EFFECT.id, "extra_delay_s"),
            lag_s: if instead_of_lag {
                0.0
            } else {
                self.actuator.lag_s
            },
            servo_hz: added(second_order_servo::EFFECT.id, "frequency_hz"),
            servo_damping: value(second_order_servo::EFFECT.id, "damping_ratio")
                .unwrap_or(default.servo_damping),
            pause_s: added(zero_cross_pause::EFFECT.id, "pause_s"),
            ..default
        };
        with_lag(robot, added(actuation_lag::EFFECT.id, "extra_lag_s"))
    }
}

/// Adds a second lag to that of the robot. Both together are a servo with real poles, if the board accepts its damping; else the
/// smaller lag is added to the delay.
fn with_lag(robot: ActuatorSettings, extra_s: f64) -> ActuatorSettings {
    let (longer_s, shorter_s) = (robot.lag_s.max(extra_s), robot.lag_s.min(extra_s));
    if shorter_s <= 0.0 {
        let lag_s = longer_s;
        return ActuatorSettings { lag_s, ..robot };
    }
    let mean_s = (longer_s * shorter_s).sqrt();
    let as_servo = ActuatorSettings {
        lag_s: 0.0,
        servo_hz: 1.0 / (std::f64::consts::TAU * mean_s),
        servo_damping: 0.5 * (longer_s + shorter_s) / mean_s,
        ..robot.clone()
    };
    if !robot.has_servo() && as_servo.validate().is_ok() {
        return as_servo;
    }
    ActuatorSettings {
        lag_s: longer_s,
        delay_s: robot.delay_s + shorter_s,
        ..robot
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nominal_values_and_effects_add_up() {
        let text = "[actuator]\ntransport_delay_s = 0.012\nlag_s = 0.006\n\
                    [[effect]]\nid = \"actuation_delay\"\nparameters = { extra_delay_s = 0.02 }\n\
                    [[effect]]\nid = \"zero_cross_pause\"\nparameters = { pause_s = 0.016 }\n";
        let robot = Model::from_toml(text, "test").unwrap().robot_for_board();
        assert_eq!(robot.delay_s, 0.032);
        assert_eq!((robot.lag_s, robot.pause_s), (0.006, 0.016));
        assert_eq!(robot.servo_hz, 0.0);
        assert_eq!(robot.validate(), Ok(()));
    }

    #[test]
    fn a_servo_instead_of_the_lag_leaves_no_lag() {
        for (instead, lag_s) in [(0, 0.006), (1, 0.0)] {
            let text = format!(
                "[actuator]\nlag_s = 0.006\n[[effect]]\nid = \"second_order_servo\"\n\
                 parameters = {{ frequency_hz = 12.0, damping_ratio = 0.7, instead_of_lag = {instead} }}\n"
            );
            let robot = Model::from_toml(&text, "test").unwrap().robot_for_board();
            assert_eq!((robot.lag_s, robot.servo_hz), (lag_s, 12.0));
        }
    }

    #[test]
    fn two_lags_are_a_servo_with_two_real_poles() {
        let with = |extra_lag_s: f64| {
            let text = format!(
                "[actuator]\ntransport_delay_s = 0.012\nlag_s = 0.006\n\
                 [[effect]]\nid = \"actuation_lag\"\nparameters = {{ extra_lag_s = {extra_lag_s} }}\n"
            );
            Model::from_toml(&text, "test").unwrap().robot_for_board()
        };
        let robot = with(0.014);
        assert_eq!((robot.delay_s, robot.lag_s), (0.012, 0.0));
        let poles_s = |r: &ActuatorSettings| {
            let mean = 1.0 / (std::f64::consts::TAU * r.servo_hz);
            let root = (r.servo_damping.powi(2) - 1.0).sqrt();
            [
                mean * (r.servo_damping - root),
                mean * (r.servo_damping + root),
            ]
        };
        for (pole, lag) in poles_s(&robot).iter().zip([0.006, 0.014]) {
            assert!((pole - lag).abs() < 1e-9, "{robot:?}");
        }
        // One lag is a hundred times shorter: no servo of the board has such a damping.
        let robot = with(0.000_06);
        assert_eq!((robot.lag_s, robot.servo_hz), (0.006, 0.0));
        assert!((robot.delay_s - 0.012_06).abs() < 1e-12);
        assert_eq!(robot.validate(), Ok(()));
    }
}
