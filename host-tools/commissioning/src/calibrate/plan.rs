//! Poses to move the robot to for a calibration.
//!
//! From the pose in which the robot stands, the tool is tilted about horizontal axes, one after the
//! other around the circle, so that each pose is a short way from the one before it and gravity
//! wanders once around a cone in the sensor. The flange point stays where it is.

use super::advice::{determined_by, open_words};
use super::gravity::Gravity;
use super::source::Mounting;
use anyhow::{Result, ensure};
use nalgebra::{UnitQuaternion, Vector3};
use serde::Serialize;
use softdock_control::frames::{abc_from_orientation, components};
use std::f64::consts::FRAC_PI_4;

/// Directions of the tilt.
const DIRECTIONS: u32 = 8;
/// Nearer to B = ±90° than this (10°), A and C cannot be told apart.
const SINGULAR_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// Factor by which a tilt is reduced until it keeps away from these.
const LESS: f64 = 0.9;
/// Smallest tilt that is worth a pose, rad.
const SMALLEST_RAD: f64 = 0.15;

/// A pose of a plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlannedPose {
    /// A, B, C of M, degrees.
    pub abc_deg: [f64; 3],
    /// Direction of gravity in the sensor, a unit vector.
    pub down_in_s: [f64; 3],
    /// Condition of the calibration with the poses up to here; None while something is open.
    pub condition: Option<f64>,
    /// What it adds to the poses before, in words.
    pub adds: String,
}

/// The poses in a safe order.
///
/// # Errors
///
/// A tilt out of its range, or a start from which no tilt is possible.
pub fn plan(
    start: &UnitQuaternion<f64>,
    mounting: &Mounting,
    gravity_m_s2: [f64; 3],
    tilt_rad: f64,
) -> Result<Vec<PlannedPose>> {
    let degrees = tilt_rad.to_degrees();
    ensure!(
        (10.0..=120.0).contains(&degrees),
        "the tilt is {degrees}°; allowed is 10 to 120"
    );
    let gravity = Gravity::new(gravity_m_s2);
    ensure!(
        gravity.vector.norm() > 1.0,
        "gravity is {:.3} m/s² long; expected about 9.81",
        gravity.vector.norm()
    );
    let [first, second] = gravity.across();
    let tilted = (0..DIRECTIONS).filter_map(|k| {
        let angle = f64::from(k) * FRAC_PI_4;
        let axis = first * angle.cos() + second * angle.sin();
        regular(start, &axis, tilt_rad)
    });
    let orientations: Vec<UnitQuaternion<f64>> = std::iter::once(*start).chain(tilted).collect();
    ensure!(
        orientations.len() >= 4,
        "from this pose nearly every tilt leads to B = ±90°, where A and C cannot be told apart; \
         start from a pose with another B"
    );
    Ok(described(&orientations, mounting, &gravity))
}

/// The start, tilted as far as A, B, C stay regular; None if that is not far.
fn regular(
    start: &UnitQuaternion<f64>,
    axis: &Vector3<f64>,
    tilt_rad: f64,
) -> Option<UnitQuaternion<f64>> {
    let mut tilt = tilt_rad;
    while tilt >= SMALLEST_RAD {
        let turned = UnitQuaternion::from_scaled_axis(axis * tilt) * start;
        let [_, b, _] = abc_from_orientation(&turned);
        if b.abs() < std::f64::consts::FRAC_PI_2 - SINGULAR_RAD {
            return Some(turned);
        }
        tilt *= LESS;
    }
    None
}

fn described(
    orientations: &[UnitQuaternion<f64>],
    mounting: &Mounting,
    gravity: &Gravity,
) -> Vec<PlannedPose> {
    let mut before = None;
    (1..=orientations.len())
        .map(|count| {
            let now = &orientations[count - 1];
            let determined = determined_by(&orientations[..count], mounting, gravity);
            let condition = (determined.open == 0).then_some(determined.condition);
            let adds = match (condition, before) {
                (None, _) => format!("still open: {}", open_words(&determined)),
                (Some(now), None) => format!("all is determined, condition number {now:.1}"),
                (Some(now), Some(last)) if now < 0.95 * last => {
                    format!("a better condition number: {now:.1}")
                }
                (Some(_), Some(_)) => "less noise, and a check of the others".to_owned(),
            };
            before = condition;
            let c_from_s = now * mounting.m_from_s.rotation;
            let down = c_from_s.inverse() * gravity.vector.normalize();
            PlannedPose {
                abc_deg: abc_from_orientation(now).map(f64::to_degrees),
                down_in_s: components(&down),
                condition,
                adds,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_control::frames::orientation_from_abc;

    #[test]
    fn a_plan_determines_everything_and_keeps_away_from_the_singularity() {
        for abc in [
            [0.0, 0.0, 0.0],
            [1.0, 0.9, 3.0],
            [0.0, 1.2, 0.4],
            [-2.0, -0.5, 1.57],
        ] {
            let start = orientation_from_abc::<f64>(&abc);
            let poses = plan(&start, &Mounting::default(), [0.0, 0.0, -9.81], 1.0).unwrap();
            let last = poses.last().unwrap();
            assert!(last.condition.unwrap() < 5.0, "{abc:?} {last:?}");
            for pose in &poses {
                assert!(pose.abc_deg[1].abs() <= 80.0, "{pose:?}");
            }
            let conditions: Vec<f64> = poses.iter().filter_map(|p| p.condition).collect();
            assert!(conditions.len() >= poses.len() - 2, "{poses:?}");
        }
    }

    #[test]
    fn a_tilt_out_of_range_is_refused() {
        let start = UnitQuaternion::identity();
        let error = plan(&start, &Mounting::default(), [0.0, 0.0, -9.81], 0.05).unwrap_err();
        assert!(
            error.to_string().contains("allowed is 10 to 120"),
            "{error}"
        );
    }
}
