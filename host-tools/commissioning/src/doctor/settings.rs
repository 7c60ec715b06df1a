//! The settings of a board.

use super::Check;
use softdock_app::settings::{ANY_ROBOT, BoardSettings};
use softdock_control::delay::LawName;
use softdock_control::delay::actuator::ActuatorSettings;

pub(super) fn checks(board: &BoardSettings) -> Vec<Check> {
    let valid = match board.validate() {
        Ok(()) => Check::good("settings", "complete and in their ranges"),
        Err(error) => Check::bad("settings", error.to_string()),
    };
    let mut all = vec![valid, tool(board), robot(board), law(board), address(board)];
    all.extend(frozen_sensor(board));
    all
}

/// A warning if the detection of a frozen sensor is switched off.
fn frozen_sensor(board: &BoardSettings) -> Option<Check> {
    let off = board.control.sensor.frozen_after_cycles == 0;
    off.then(|| {
        Check::warning(
            "frozen sensor",
            "not looked for: a sensor that repeats its last reading is taken for one that measures; set \
             `control.sensor.frozen_after_cycles` to 5, unless the sensor is a simulation without noise",
        )
    })
}

fn tool(board: &BoardSettings) -> Check {
    let (name, sensor) = ("tool", &board.control.sensor);
    if sensor.tool_mass_kg == 0.0 {
        return Check::warning(
            name,
            "it has no mass: its weight would count as contact; `softdock calibrate sensor`",
        );
    }
    Check::good(name, format!("{} kg", sensor.tool_mass_kg))
}

fn robot(board: &BoardSettings) -> Check {
    let (name, actuator) = ("robot's delay", &board.control.delay.actuator);
    if *actuator == ActuatorSettings::default() {
        return Check::warning(
            name,
            "the default of 32 ms, not a measurement; `softdock identify actuator`",
        );
    }
    Check::good(
        name,
        format!("{:.1} ms on average", actuator.mean_delay_s() * 1e3),
    )
}

fn law(board: &BoardSettings) -> Check {
    let name = "delay law";
    match board.control.delay.law {
        LawName::None => Check::warning(
            name,
            "none: a late robot gives every bounce energy; choose `control.delay.law`",
        ),
        law => Check::good(name, law.name()),
    }
}

fn address(board: &BoardSettings) -> Check {
    let name = "robot's address";
    if !board.rsi.says_who_is_robot() {
        return Check::warning(
            name,
            "not given, so the board is not armed by its service: set `rsi.robot_ip`, or \"any\" if whoever sends \
             first is to be the robot",
        );
    }
    if board.rsi.robot_ip == ANY_ROBOT {
        return Check::warning(name, "the first sender of a valid telegram is the robot");
    }
    Check::good(name, board.rsi.robot_ip.as_str())
}

/// `network.recorder`, as it is written.
pub(super) fn recorder(recorder: &str) -> Check {
    let name = "recorder";
    if recorder.is_empty() {
        return Check::warning(
            name,
            "the settings name nobody who gets each cycle: set `network.recorder`, or start `softdock board` with \
             --telemetry",
        );
    }
    Check::good(name, recorder)
}
