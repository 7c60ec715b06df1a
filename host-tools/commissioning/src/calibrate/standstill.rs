//! Poses at rest: found by themselves in a recording, each with the mean of its readings.

use super::observation::{Group, Observation};
use super::source::{Mounting, Reading};
use anyhow::{Result, ensure};
use nalgebra::UnitQuaternion;
use softdock_control::frames::Wrench;
use std::ops::Range;

/// How far a robot at rest moves, by noise and servo: m and rad.
const STILL_M: f64 = 2e-4;
/// See [`STILL_M`].
const STILL_RAD: f64 = 1e-3;
/// Time after which tool and cables have come to rest, s.
const SETTLING_S: f64 = 0.3;
/// Time over which a pose is averaged at least, s.
const DWELL_S: f64 = 0.4;
/// Least number of readings of a pose.
const FEWEST_READINGS: usize = 5;
/// Rotation that makes another pose, rad: with a smaller one gravity is the same, wherever the tool is.
pub(super) const NEW_POSE_RAD: f64 = 0.02;

/// The groups for poses at rest. With `at_rest`, each reading is a pose of its own.
///
/// # Errors
///
/// No pose at rest at all.
pub(super) fn groups(
    readings: &[Reading],
    mounting: &Mounting,
    at_rest: bool,
) -> Result<Vec<Group>> {
    ensure!(
        !readings.is_empty(),
        "no reading of a healthy sensor with a pose is in the recording; record sensor and robot \
         together"
    );
    let rests: Vec<Range<usize>> = if at_rest {
        (0..readings.len()).map(|n| n..n + 1).collect()
    } else {
        rests(readings)
    };
    ensure!(
        !rests.is_empty(),
        "the robot never rests for {} s in this recording; stop it in each pose, or say --at-rest \
         if each row is the mean of a pose of its own",
        SETTLING_S + DWELL_S
    );
    let group = |(n, rest): (usize, &Range<usize>)| {
        let own = &readings[rest.clone()];
        Group {
            time_s: [own[0].time_s, own[own.len() - 1].time_s],
            pose: Some(n + 1),
            observations: vec![mean(own, mounting)],
        }
    };
    Ok(rests.iter().enumerate().map(group).collect())
}

/// The readings of each rest, without the time in which tool and cables settle.
pub fn rests(readings: &[Reading]) -> Vec<Range<usize>> {
    let settled = stands(readings)
        .into_iter()
        .map(|stand| settled_part(readings, stand));
    let long = settled.filter(|rest| is_long(&readings[rest.clone()]));
    merged(readings, long.collect())
}

/// For each standstill that is not used as a pose the reason, as a sentence.
pub(super) fn unused(readings: &[Reading]) -> Vec<String> {
    let used = rests(readings);
    let why = |stand: Range<usize>| {
        let (first, last) = (&readings[stand.start], &readings[stand.end - 1]);
        let (at_s, lasts_s) = (first.time_s, last.time_s - first.time_s);
        let rest = settled_part(readings, stand);
        if used.contains(&rest) || lasts_s < SETTLING_S {
            return None;
        }
        Some(match is_long(&readings[rest.clone()]) {
            true => format!(
                "The rest at {at_s:.1} s was left out: the tool hangs as in a longer rest beside it."
            ),
            false => format!(
                "The rest at {at_s:.1} s was left out: of its {lasts_s:.1} s {} readings are left when tool and cables \
                 have settled ({SETTLING_S} s); a pose takes {FEWEST_READINGS} readings in {DWELL_S} s more.",
                rest.len()
            ),
        })
    };
    stands(readings).into_iter().filter_map(why).collect()
}

/// Where the robot does not move.
fn stands(readings: &[Reading]) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    for (n, reading) in readings.iter().enumerate() {
        match found.last_mut() {
            Some(stand) if is_still(&readings[stand.start], reading) => stand.end = n + 1,
            _ => found.push(n..n + 1),
        }
    }
    found
}

/// The readings of a rest after tool and cables have come to rest.
pub(super) fn settled_part(readings: &[Reading], stand: Range<usize>) -> Range<usize> {
    let settled_s = readings[stand.start].time_s + SETTLING_S;
    let first = stand.clone().find(|n| readings[*n].time_s >= settled_s);
    first.unwrap_or(stand.end)..stand.end
}

/// Whether the robot has not moved since the first reading.
pub(super) fn is_still(first: &Reading, now: &Reading) -> bool {
    let moved = now.pose.translation.vector - first.pose.translation.vector;
    moved.norm() < STILL_M && first.pose.rotation.angle_to(&now.pose.rotation) < STILL_RAD
}

/// Whether settled readings are enough for a pose.
pub(super) fn is_long(readings: &[Reading]) -> bool {
    match (readings.first(), readings.last()) {
        (Some(first), Some(last)) => {
            readings.len() >= FEWEST_READINGS && last.time_s - first.time_s >= DWELL_S
        }
        _ => false,
    }
}

/// A rest in the orientation of the one before it is no new pose: the longer one counts.
fn merged(readings: &[Reading], found: Vec<Range<usize>>) -> Vec<Range<usize>> {
    let rotation = |range: &Range<usize>| readings[range.start].pose.rotation;
    let mut kept: Vec<Range<usize>> = Vec::new();
    for range in found {
        match kept.last_mut() {
            Some(last) if rotation(last).angle_to(&rotation(&range)) < NEW_POSE_RAD => {
                if range.len() > last.len() {
                    *last = range;
                }
            }
            _ => kept.push(range),
        }
    }
    kept
}

fn mean(readings: &[Reading], mounting: &Mounting) -> Observation {
    let count = readings.len() as f64;
    let sum = readings
        .iter()
        .fold(Wrench::zero(), |sum, reading| sum + reading.wrench);
    // Orientations of a rest differ by less than a milliradian: the mean is that of the small
    // turns from the first.
    let first = readings[0].pose.rotation;
    let turns = readings
        .iter()
        .map(|r| (first.inverse() * r.pose.rotation).scaled_axis());
    let turn = turns.sum::<nalgebra::Vector3<f64>>() / count;
    let mut pose = readings[0].pose;
    pose.rotation = first * UnitQuaternion::from_scaled_axis(turn);
    Observation::at_rest(mounting.c_from_s(&pose), sum * (1.0 / count))
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_control::frames::{Pose, orientation_from_abc};

    /// Rests of so many seconds, each turned by so many degrees, with a cycle of motion between them.
    fn recorded(rests: &[(f64, f64)]) -> Vec<Reading> {
        let mut readings: Vec<Reading> = Vec::new();
        for (seconds, turn_deg) in rests {
            for _ in 0..(seconds / 0.004).round() as usize {
                readings.push(Reading {
                    time_s: readings.len() as f64 * 0.004,
                    continues: true,
                    pose: Pose::from_parts(
                        Default::default(),
                        orientation_from_abc(&[0.0, 0.0, turn_deg.to_radians()]),
                    ),
                    wrench: Wrench::zero(),
                });
            }
        }
        readings
    }

    #[test]
    fn a_rest_that_is_no_pose_is_told_with_its_reason() {
        let readings = recorded(&[
            (1.0, 0.0),
            (0.5, 20.0),
            (1.0, 40.0),
            (0.1, 60.0),
            (1.0, 80.0),
        ]);
        assert_eq!(rests(&readings).len(), 3);
        let told = unused(&readings);
        assert_eq!(told.len(), 1, "{told:?}");
        assert!(
            told[0].starts_with("The rest at 1.0 s was left out: of its 0.5 s"),
            "{told:?}"
        );

        // Another place, and gravity as before.
        let mut readings = recorded(&[(1.0, 0.0), (2.0, 0.5)]);
        assert_eq!(rests(&readings).len(), 1);
        let told = unused(&readings);
        assert!(
            told[0].contains("as in a longer rest beside it"),
            "{told:?}"
        );
        readings.truncate(100);
        assert!(rests(&readings).is_empty());
    }
}
