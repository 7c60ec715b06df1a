//! The docking surfaces can be observed at any time: J (= N) on K seen from P on Q.

use nalgebra::{Translation3, UnitQuaternion, Vector3};
use softdock_control::delay::LawName;
use softdock_control::frames::Pose;
use softdock_control::settings::Settings;
use softdock_tests::driver::{idle, started};

/// Two turning spacecraft: the relative velocity of the surfaces is the derivative of their pose.
#[test]
fn the_relative_velocity_is_the_derivative_of_the_relative_pose() {
    let mut settings = Settings::default();
    settings.delay.law = LawName::None;
    settings.body_k.velocity_m_s = [0.02, -0.01, 0.0];
    settings.body_k.angular_velocity_rad_s = [0.0, 0.03, 0.05];
    settings.body_q.position_m = [1.5, 0.2, -0.1];
    settings.body_q.orientation_wxyz = [0.8, 0.0, 0.6, 0.0];
    settings.body_q.angular_velocity_rad_s = [0.02, 0.0, -0.04];
    settings.frames.j_position_m = [0.6, 0.1, 0.0];
    settings.frames.j_orientation_wxyz = [0.6, 0.0, 0.0, 0.8];
    settings.frames.p_position_m = [-0.7, 0.0, 0.2];
    let mut driver = started::<f64>(&settings);
    let traces: Vec<_> = (0..200).map(|_| driver.step().trace.docking).collect();
    let pose = |p: &[f64; 7]| {
        let q = nalgebra::Quaternion::new(p[3], p[4], p[5], p[6]);
        Pose::from_parts(
            Translation3::new(p[0], p[1], p[2]),
            UnitQuaternion::new_normalize(q),
        )
    };
    // After the start ramp, around the middle.
    let (before, here, after) = (&traces[148], &traces[150], &traces[152]);
    let (a, b) = (pose(&before.pose), pose(&after.pose));
    let linear = (b.translation.vector - a.translation.vector) / 0.016;
    let angular = (a.rotation.inverse() * b.rotation).scaled_axis() / 0.016;
    let seen = Vector3::from_column_slice(&here.velocity[..3]);
    let turning = Vector3::from_column_slice(&here.velocity[3..]);
    assert!((linear - seen).norm() < 1e-5, "{linear} {seen}");
    assert!((angular - turning).norm() < 1e-5, "{angular} {turning}");
}

/// Before the start the surfaces stand where the operator has put them.
#[test]
fn before_the_start_the_initial_conditions_are_seen() {
    let mut settings = Settings::default();
    settings.body_q.position_m = [1.0, 0.0, 0.0];
    settings.frames.j_position_m = [0.25, 0.0, 0.0];
    settings.frames.p_position_m = [-0.25, 0.0, 0.0];
    let driver = idle::<f64>(&settings);
    let seen = driver.cycle.cycle().observe().p_from_j.translation.vector;
    assert!(
        (seen - Vector3::new(-0.5, 0.0, 0.0)).norm() < 1e-12,
        "{seen}"
    );
}
