//! Poses at rest: found by themselves in a recording, each with the mean of its readings.

use super::equations::{Group, Observation};
use super::source::{Mounting, Reading};
use anyhow::{Result, ensure};
use nalgebra::UnitQuaternion;
use softdock_control::frames::Wrench;

/// How far a robot at rest moves, by noise and servo: m and rad.
const STILL_M: f64 = 2e-4;
/// See [`STILL_M`].
const STILL_RAD: f64 = 1e-3;
/// Time after which tool and cables have come to rest, s.
const SETTLING_S: f64 = 0.3;
/// Time over which a pose is averaged at least, s.
const DWELL_S: f64 = 0.4;
/// Readings of a pose at least.
const FEWEST_READINGS: usize = 5;
/// Turn that makes another pose of the same place, rad: below it, gravity is the same.
const NEW_POSE_RAD: f64 = 0.02;

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
    let rests: Vec<std::ops::Range<usize>> = if at_rest {
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
    let group = |(n, rest): (usize, &std::ops::Range<usize>)| {
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
pub fn rests(readings: &[Reading]) -> Vec<std::ops::Range<usize>> {
    let mut found: Vec<std::ops::Range<usize>> = Vec::new();
    let mut begin = 0;
    for n in 0..=readings.len() {
        if n < readings.len() && n > begin && is_still(&readings[begin], &readings[n]) {
            continue;
        }
        if n > begin {
            let settled = readings[begin].time_s + SETTLING_S;
            let first = (begin..n).find(|k| readings[*k].time_s >= settled);
            let range = first.unwrap_or(n)..n;
            if is_long(&readings[range.clone()]) {
                found.push(range);
            }
        }
        begin = n;
    }
    merged(readings, found)
}

fn is_still(first: &Reading, now: &Reading) -> bool {
    let moved = now.pose.translation.vector - first.pose.translation.vector;
    moved.norm() < STILL_M && first.pose.rotation.angle_to(&now.pose.rotation) < STILL_RAD
}

fn is_long(readings: &[Reading]) -> bool {
    match (readings.first(), readings.last()) {
        (Some(first), Some(last)) => {
            readings.len() >= FEWEST_READINGS && last.time_s - first.time_s >= DWELL_S
        }
        _ => false,
    }
}

/// A rest in the orientation of the one before it is no new pose: the longer one counts.
fn merged(readings: &[Reading], found: Vec<std::ops::Range<usize>>) -> Vec<std::ops::Range<usize>> {
    let rotation = |range: &std::ops::Range<usize>| readings[range.start].pose.rotation;
    let mut kept: Vec<std::ops::Range<usize>> = Vec::new();
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
