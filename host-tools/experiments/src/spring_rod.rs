//! Variants of the spring-rod test, made from the built-in scenario.

use super::scenario::Scenario;
use anyhow::{Context, Result};
use softdock_control::delay::LawName;

/// Time of free flight before the first touch, in cycles: enough for the start ramp and a steady view. What the ramp costs
/// and the robot's delay are whole cycles too, so that the touch coincides with a telegram unless it is moved.
const FLIGHT_CYCLES: f64 = 150.0;
/// Default instant of the touch within a cycle. It changes the restitution of the paper's law by several percent; with this
/// one the numbers are those of the simulation with which the law's unprinted settings were found.
pub const TOUCH: f64 = 0.75;
/// Time recorded after a single touch, s: four times the contact itself.
const AFTER_S: f64 = 0.8;

/// One touch of one stop at a speed (m/s), at the same time of the run for all speeds; `touch` (0 to 1) is its instant within
/// a cycle.
pub fn one_stop(law: LawName, speed_m_s: f64, touch: f64) -> Result<Scenario> {
    let mut scenario = Scenario::spring_rod()?
        .with_law(law)
        .with_speed(speed_m_s)?;
    let start_x = scenario.start_position_m[0];
    let flight_s = (FLIGHT_CYCLES - 1.0 + touch) * scenario.board.control.robot.cycle_s;
    let wall = scenario
        .rig
        .mechanism
        .walls
        .first_mut()
        .context("the scenario has no stop")?;
    wall.point_m[0] = start_x + speed_m_s * flight_s;
    scenario.duration_s = flight_s + AFTER_S;
    scenario.title = format!("Spring rod, one stop, {} mm/s", speed_m_s * 1e3);
    Ok(scenario)
}

/// Two stops that face each other, so that the spacecraft goes to and fro.
pub fn two_stops(law: LawName, speed_m_s: f64, duration_s: f64) -> Result<Scenario> {
    let mut scenario = one_stop(law, speed_m_s, TOUCH)?;
    let start_x = scenario.start_position_m[0];
    let walls = &mut scenario.rig.mechanism.walls;
    let mut behind = walls.first().context("the scenario has no stop")?.clone();
    behind.normal = behind.normal.map(|n| -n);
    behind.point_m[0] = 2.0 * start_x - behind.point_m[0];
    walls.push(behind);
    scenario.duration_s = duration_s;
    scenario.title = format!("Spring rod, two stops, {} mm/s", speed_m_s * 1e3);
    Ok(scenario)
}
