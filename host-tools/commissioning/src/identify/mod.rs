//! How the robot follows: transport delay, lag or servo, pause at a zero crossing, limits, and the
//! age of the pose that it reports.
//!
//! - `track` takes from a recording what one axis was commanded and where it went,
//! - `misfit` simulates an actuator and compares positions, `reversals` allows for the uncertain instants of reversals,
//! - `structure` fits every structure that could be there, `judge` chooses the simplest that
//!   suffices, `answer` gives its parameters with intervals,
//! - `latency` tells the age of the reported pose from the robot's delay, where a tool is heavy
//!   enough to be felt,
//! - `outcome` is the answer, `tables` and `settings` write it down,
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
/// A recording without a whole stretch, or in which no axis shows how the robot follows.
pub fn identify(recording: &Recording) -> Result<Identification> {
    let log = Log::new(&Model::default(), recording)?;
    let (tracks, mut refused) = track::tracks(&log);
    // In a closed loop the motion follows the force, not the force the motion.
    let modes = recording.cycles.iter().map(|c| c.trace.mode);
    let is_jog = modes.into_iter().all(|mode| mode != Mode::Running);
    let found: Vec<Result<AxisActuator, String>> = tracks
        .par_iter()
        .map(|track| {
            let mut found = structure::identify_structure(track);
            if let Some(reason) = found.goes_elsewhere(track) {
                return Err(reason);
            }
            if is_jog {
                found.feedback_latency = latency::feedback(&log, track, &found);
            }
            Ok(found)
        })
        .collect();
    let mut axes = Vec::new();
    for found in found {
        match found {
            Ok(axis) => axes.push(axis),
            Err(reason) => refused.push(reason),
        }
    }
    if axes.is_empty() {
        // If an axis moved, a jog was recorded already, and each reason says what to check.
        let remedy = match tracks.is_empty() {
            true => {
                ". Record a jog in free space (`softdock identify actuator --rehearse` shows one) with velocities that jump"
            }
            false => "",
        };
        bail!(
            "no axis of this recording shows how the robot follows: {}{remedy}",
            refused.join("; ")
        );
    }
    Ok(Identification::new(axes, refused, log.cycle_s))
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_app::record::CycleRecord;
    use softdock_statistics::RandomStream;

    /// A jog out and halfway back, executed five cycles late and scaled by `times`, with so much noise of the pose, m.
    fn jogged(times: f64, noise_m: f64) -> Recording {
        let speed = |n: i32| match n {
            20..70 => 0.1,
            90..115 => -0.1,
            _ => 0.0,
        };
        let mut noise = RandomStream::new(1, 0);
        let mut place = 0.0;
        let cycle = |n: i32| {
            let mut cycle = CycleRecord::default();
            let moved = times * speed(n - 5);
            place += 0.004 * moved;
            cycle.trace.cycle = n as u64;
            cycle.trace.time_s = 0.004 * f64::from(n);
            cycle.trace.sent_velocity[0] = speed(n);
            cycle.trace.executed_velocity[0] = moved;
            let measured = noise.around(place, noise_m);
            cycle.trace.pose = [measured, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
            cycle
        };
        Recording {
            cycles: (0..150).map(cycle).collect(),
            ..Recording::default()
        }
    }

    /// An actuator that leaves the whole motion unexplained describes no robot: its values are not offered as settings.
    #[test]
    fn an_axis_that_goes_elsewhere_is_not_identified() {
        let found = identify(&jogged(1.0, 0.0)).unwrap();
        assert!(
            (found.mean_delay_s.value - 0.02).abs() < 0.004,
            "{}",
            found.sentence()
        );
        for (times, noise_m, expected) in [
            (
                -1.0,
                0.0,
                "x does not follow what it was sent (it moves by -1.0 times that: is the command of the other sign?)",
            ),
            (
                3.0,
                0.0,
                "it moves by 3.0 times that: is the command in another unit",
            ),
            (0.0, 1e-3, "x moves by no more than its noise"),
        ] {
            let refused = identify(&jogged(times, noise_m)).unwrap_err().to_string();
            assert!(refused.contains(expected), "{refused}");
            // The recording is a jog already.
            assert!(!refused.contains("Record a jog"), "{refused}");
        }
    }
}
