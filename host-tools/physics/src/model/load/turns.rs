//! Where poses are along an axis, and how far they have turned about one.

use nalgebra::{UnitQuaternion, Vector3};
use softdock_control::frames::{self, Pose};
use std::f64::consts::{PI, TAU};

/// The pose of a position (m) and a quaternion (w x y z) that a file may have rounded.
pub fn pose_of([x, y, z, qw, qx, qy, qz]: &[f64; 7]) -> Pose<f64> {
    frames::pose(&[*x, *y, *z], &[*qw, *qx, *qy, *qz])
}

/// Where each pose is along an axis of C, m.
pub fn positions(poses: &[Pose<f64>], axis: &Vector3<f64>) -> Vec<f64> {
    let along = |pose: &Pose<f64>| axis.dot(&pose.translation.vector);
    poses.iter().map(along).collect()
}

/// How far each pose has turned about an axis of M, rad: the first with so many whole turns, each other with those that bring it
/// nearest to the pose before.
pub fn angles(poses: &[Pose<f64>], axis: &Vector3<f64>, whole_turns: i32) -> Vec<f64> {
    let mut angles: Vec<f64> = poses.iter().map(|pose| angle_about(pose, axis)).collect();
    count_turns(angles.iter_mut());
    let before = TAU * f64::from(whole_turns);
    angles.iter_mut().for_each(|angle| *angle += before);
    angles
}

/// How far a pose is turned about an axis of M, rad, within half a turn, whatever else turns M: the twist that is left without the
/// shortest turn that takes the axis where it points. Where it points against its direction in C, as that of a flange that hangs
/// down, no turn is the shortest, and half a turn about an axis across comes first.
pub fn angle_about(pose: &Pose<f64>, axis: &Vector3<f64>) -> f64 {
    /// Cosine from which on it does: far from mountings at right angles, at which noise would change the form.
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

/// How far each pose has turned since the first, rad, axes of M: rotation vectors from pose to pose, added, which after some turns an
/// orientation does not tell.
pub fn turned_since_first(
    poses: impl Iterator<Item = Pose<f64>>,
) -> impl Iterator<Item = Vector3<f64>> {
    let (mut turned, mut before) = (Vector3::zeros(), None);
    poses.map(move |pose| {
        let now = pose.rotation;
        if let Some(before) = before.replace(now) {
            turned += (before.inverse() * now).scaled_axis();
        }
        turned
    })
}

/// Adds to each angle the whole turns that bring it nearest to the one before.
pub fn count_turns<'a>(angles: impl Iterator<Item = &'a mut f64>) {
    let mut before = 0.0;
    for angle in angles.filter(|angle| angle.is_finite()) {
        *angle += TAU * ((before - *angle) / TAU).round();
        before = *angle;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flange at any angle that turns about an axis of its own: the angle is that of the turn, but for a constant that is the same
    /// in all logs; of a flange that is not tilted it is the angle itself.
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

    /// 2 rad from pose to pose, out over three turns and back: an orientation alone would be within half a turn.
    #[test]
    fn turns_are_counted() {
        let angle = |n: i32| f64::from(if n <= 10 { n } else { 20 - n }) * 2.0;
        let poses = (0..=20).map(|n| {
            let turn = Vector3::new(0.0, 0.0, angle(n));
            Pose::from_parts(
                Vector3::zeros().into(),
                UnitQuaternion::from_scaled_axis(turn),
            )
        });
        for (n, turned) in (0..).zip(turned_since_first(poses)) {
            assert!(
                (turned - Vector3::new(0.0, 0.0, angle(n))).norm() < 1e-12,
                "{n}"
            );
        }
    }
}
