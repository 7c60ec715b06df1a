//! Positions of poses along an axis, and their rotation about one.
//!
//! Rotations that differ by whole turns end in the same orientation. If the orientation is the integral of a velocity, as in the
//! log of a fast shaft without a measured angle, that velocity determines the number of turns; else the shortest rotation is
//! taken.

use nalgebra::{UnitQuaternion, Vector3};
use softdock_control::frames::{self, Pose};
use std::f64::consts::{PI, TAU};

/// The pose of a position (m) and a quaternion (w x y z) that a file may have rounded.
pub fn pose_of([x, y, z, qw, qx, qy, qz]: &[f64; 7]) -> Pose<f64> {
    frames::pose(&[*x, *y, *z], &[*qw, *qx, *qy, *qz])
}

/// Position of each pose along an axis of C, m.
pub fn positions(poses: &[Pose<f64>], axis: &Vector3<f64>) -> Vec<f64> {
    let along = |pose: &Pose<f64>| axis.dot(&pose.translation.vector);
    poses.iter().map(along).collect()
}

/// A pose, and its rotation since the one before.
#[derive(Clone, Copy, Debug)]
pub struct Followed {
    /// The pose of M in C.
    pub pose: Pose<f64>,
    /// Its rotation since the pose before by the velocity, rad, axes of M; zero if unknown.
    pub by_velocity: Vector3<f64>,
}

/// A pose without a velocity.
impl From<Pose<f64>> for Followed {
    fn from(pose: Pose<f64>) -> Self {
        Self {
            pose,
            by_velocity: Vector3::zeros(),
        }
    }
}

/// Angle of each pose about an axis of M, rad, with `whole_turns` added to the first.
pub fn angles(
    poses: impl Iterator<Item = Followed>,
    axis: &Vector3<f64>,
    whole_turns: i32,
) -> Vec<f64> {
    let (turns, ahead): (Vec<f64>, Vec<f64>) = poses
        .map(|turned| {
            let angle = angle_about(&turned.pose, axis);
            (angle, axis.dot(&turned.by_velocity))
        })
        .unzip();
    let mut angles = turns;
    count_turns(angles.iter_mut().zip(ahead));
    let before = TAU * f64::from(whole_turns);
    angles.iter_mut().for_each(|angle| *angle += before);
    angles
}

/// Angle of a pose about an axis of M, rad, within half a turn, whatever the other rotation of M: the twist that remains after
/// the shortest rotation that takes the axis to its direction. If the axis points against its direction in C, as for a flange
/// that points down, there is no unique shortest rotation, and half a turn about a perpendicular axis comes first.
pub fn angle_about(pose: &Pose<f64>, axis: &Vector3<f64>) -> f64 {
    /// Cosine below which this is done: far from mountings at right angles, at which noise would switch between the two cases.
    const AGAINST: f64 = -0.5;
    let twist =
        |rotation: UnitQuaternion<f64>| match 2.0 * rotation.imag().dot(axis).atan2(rotation.w) {
            angle if angle > PI => angle - TAU,
            angle if angle < -PI => angle + TAU,
            angle => angle,
        };
    if axis.dot(&(pose.rotation * axis)) > AGAINST {
        return twist(pose.rotation);
    }
    let across = Vector3::ith_axis((axis.iamax() + 1) % 3);
    -twist(pose.rotation * UnitQuaternion::from_axis_angle(&across, PI).inverse())
}

/// Rotation of each pose since the first, rad, axes of M: the sum of rotation vectors from pose to pose, which after some turns
/// the orientation alone does not give.
pub fn turned_since_first(
    poses: impl Iterator<Item = Followed>,
) -> impl Iterator<Item = Vector3<f64>> {
    let (mut all, mut before) = (Vector3::zeros(), None);
    poses.map(move |Followed { pose, by_velocity }| {
        let now = pose.rotation;
        if let Some(before) = before.replace(now) {
            all += turn_between(&before, &now, &by_velocity);
        }
        all
    })
}

/// The rotation from one orientation to another, rad, axes of M: the shortest, or the one with additional whole turns that agrees
/// with the velocity.
pub fn turn_between(
    from: &UnitQuaternion<f64>,
    to: &UnitQuaternion<f64>,
    by_velocity: &Vector3<f64>,
) -> Vector3<f64> {
    let turn = (from.inverse() * to).scaled_axis();
    // After whole turns the shortest rotation has no direction.
    let about = turn
        .try_normalize(INTEGRAL)
        .or_else(|| by_velocity.try_normalize(INTEGRAL));
    let whole = about.map_or(turn, |about| {
        turn + about * (TAU * ((by_velocity - turn).dot(&about) / TAU).round())
    });
    match (whole - by_velocity).norm() < INTEGRAL {
        true => whole,
        false => turn,
    }
}

/// Tolerance, rad. An orientation that is the integral of a velocity agrees with that within round-off; a measured one agrees by
/// chance, once in thousands of poses.
const INTEGRAL: f64 = 1e-3;

/// Adds whole turns to each angle, so that its change from the one before agrees with its velocity, rad, or else is the shortest.
pub fn count_turns<'a>(angles: impl Iterator<Item = (&'a mut f64, f64)>) {
    let mut before = 0.0;
    for (angle, by_velocity) in angles.filter(|(angle, _)| angle.is_finite()) {
        let near = |expected: f64| *angle + TAU * ((expected - *angle) / TAU).round();
        let said = near(before + by_velocity);
        *angle = match (said - before - by_velocity).abs() < INTEGRAL {
            true => said,
            false => near(before),
        };
        before = *angle;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flange at any angle that turns about an axis of its own: the angle is that rotation, except for a constant that is the
    /// same in all logs; for a flange that is not tilted it is the angle itself.
    #[test]
    fn an_angle_is_about_the_axis_of_the_flange() {
        for (tilt, axis) in [
            ([0.0, 0.0, 0.0], 2),
            ([PI, 0.0, 0.0], 2),
            ([PI, 1e-9, -1e-9], 2),
            ([0.0, PI / 2.0, 0.0], 2),
            ([0.3, -0.8, 1.7], 0),
            ([0.0, 0.0, PI - 0.01], 1),
        ] {
            let mounted = UnitQuaternion::from_scaled_axis(tilt.into());
            let axis = Vector3::ith(axis, 1.0);
            let at = |angle: f64| {
                let turn = UnitQuaternion::from_scaled_axis(axis * angle);
                Pose::from_parts(Vector3::zeros().into(), mounted * turn)
            };
            let about = |angle: f64| angle_about(&at(angle), &axis);
            if tilt == [0.0; 3] {
                assert!((about(0.4) - 0.4).abs() < 1e-12);
            }
            for angle in [-3.0, -0.1, 0.7, 2.9] {
                let off = about(angle) - about(0.0) - angle;
                let turns = (off / TAU).round();
                assert!((off - TAU * turns).abs() < 1e-9, "{tilt:?} {angle}: {off}");
            }
        }
    }

    /// Out over some turns and back. Below half a turn from pose to pose the shortest rotation is right, whatever a velocity says
    /// that does not belong to the orientation; beyond, the velocity decides.
    #[test]
    fn turns_are_counted() {
        for (step, said) in [(2.0, 0.0), (2.0, 40.0), (4.0, 4.0), (7.0, 7.0), (TAU, TAU)] {
            let angle = |n: i32| f64::from(if n <= 10 { n } else { 20 - n }) * step;
            let ahead = |n: i32| match n {
                0 => 0.0,
                1..=10 => said,
                _ => -said,
            };
            let poses = (0..=20).map(|n| Followed {
                pose: Pose::from_parts(
                    Vector3::zeros().into(),
                    UnitQuaternion::from_scaled_axis(Vector3::z() * angle(n)),
                ),
                by_velocity: Vector3::z() * ahead(n),
            });
            let about = angles(poses.clone(), &Vector3::z(), 0);
            for ((n, turned), about) in (0..).zip(turned_since_first(poses)).zip(about) {
                let off = (turned - Vector3::z() * angle(n)).norm() + (about - angle(n)).abs();
                assert!(off < 1e-9, "{step} {n}: {off}");
            }
        }
    }
}
