//! How the robot follows: transport delay, lag or servo, pause at a zero crossing, limits, and the
//! age of the pose that it reports.
//!
//! - `track` takes from a recording what one axis was told and where it went,
//! - `misfit` simulates an actuator and compares positions, `reversals` has room for what is not known
//!   of a reversal,
//! - `structure` fits every structure that could be there, `judge` chooses the simplest that
//!   suffices, `answer` gives its parameters with intervals,
//! - `latency` tells the age of the reported pose from the robot's delay, where a tool is heavy
//!   enough to be felt,
//! - `outcome` is the answer, `page` and `settings` write it down,
//! - `live` jogs a robot that is there.
//!
//! Positions are compared, not velocities: their noise is white, while a velocity made of 20 µm of
//! noise has 7 mm/s of it at 4 ms.

mod answer;
mod judge;
mod latency;
pub mod live;
mod misfit;
mod outcome;
mod reversals;
mod settings;
mod structure;
mod tables;
mod track;

pub use outcome::{AxisActuator, Estimate, Evidence, Identification};

use anyhow::{Result, bail};
use rayon::prelude::*;
use softdock_control::modes::Mode;
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use softdock_physics::model::log::Log;

/// Identifies the actuator of every axis that a recording moves.
///
/// # Errors
///
/// A recording without a whole stretch, or in which no axis is told to move as it takes.
pub fn identify(recording: &Recording) -> Result<Identification> {
    let log = Log::new(&Model::default(), recording)?;
    let (tracks, mut refused) = track::tracks(&log);
    // In a closed loop the motion follows the force, not the force the motion.
    let modes = recording.cycles.iter().map(|c| c.trace.mode);
    let is_jog = modes.into_iter().all(|mode| mode != Mode::Running);
    let found: Vec<AxisActuator> = tracks
        .par_iter()
        .map(|track| {
            let mut found = structure::found(track);
            if is_jog {
                found.feedback_latency = latency::feedback(&log, track, &found);
            }
            found
        })
        .collect();
    refused.extend(found.iter().filter_map(AxisActuator::goes_elsewhere));
    let axes: Vec<AxisActuator> = found
        .into_iter()
        .filter(|axis| axis.goes_elsewhere().is_none())
        .collect();
    if axes.is_empty() {
        bail!(
            "no axis of this recording shows how the robot follows: {}. Record a jog in free space \
             (`softdock identify actuator --rehearse` shows one) with velocities that jump",
            refused.join("; ")
        );
    }
    Ok(Identification::new(axes, refused, log.cycle_s))
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_app::record::CycleRecord;

    /// Out, and back by half, five cycles late, in the direction of `sign`.
    fn jogged(sign: f64) -> Recording {
        let speed = |n: i32| match n {
            20..70 => 0.1,
            90..115 => -0.1,
            _ => 0.0,
        };
        let mut place = 0.0;
        let cycle = |n: i32| {
            let mut cycle = CycleRecord::default();
            let moved = sign * speed(n - 5);
            place += 0.004 * moved;
            cycle.trace.cycle = n as u64;
            cycle.trace.time_s = 0.004 * f64::from(n);
            cycle.trace.sent_velocity[0] = speed(n);
            cycle.trace.executed_velocity[0] = moved;
            cycle.trace.pose = [place, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
            cycle
        };
        Recording {
            cycles: (0..150).map(cycle).collect(),
            ..Recording::default()
        }
    }

    /// Numbers of an actuator that leaves all of the motion are none of the robot, and are not offered as settings.
    #[test]
    fn an_axis_that_goes_elsewhere_is_not_identified() {
        let found = identify(&jogged(1.0)).unwrap();
        assert!(
            (found.mean_delay_s.value - 0.02).abs() < 0.004,
            "{}",
            found.sentence()
        );
        let refused = identify(&jogged(-1.0)).unwrap_err().to_string();
        assert!(
            refused.contains("x does not follow what it was sent"),
            "{refused}"
        );
    }
}
