//! The rig moves only M. When Q turns and flies in the simulated world, M must move in the
//! laboratory, where Q stands still, as K moves seen from Q.

use nalgebra::Vector3;
use softdock_control::delay::LawName;
use softdock_control::frames::pose_from_components;
use softdock_control::scalar::Scalar;
use softdock_control::settings::Settings;
use softdock_tests::driver::idle;
use softdock_tests::in_three_scalars;

fn flight() -> Settings {
    let mut settings = Settings::default();
    settings.delay.law = LawName::None;
    let (k, q) = (&mut settings.body_k, &mut settings.body_q);
    k.position_m = [0.4, 0.1, -0.2];
    k.orientation_wxyz = [0.9, 0.1, 0.3, -0.2];
    k.velocity_m_s = [0.01, -0.006, 0.004];
    k.angular_velocity_rad_s = [0.01, 0.02, -0.015];
    q.position_m = [-0.5, 0.2, 0.3];
    q.orientation_wxyz = [0.8, -0.3, 0.1, 0.4];
    q.velocity_m_s = [-0.004, 0.008, 0.002];
    q.angular_velocity_rad_s = [0.02, -0.01, 0.03];
    q.inertia_kg_m2 = [[80.0, 5.0, 0.0], [5.0, 150.0, -3.0], [0.0, -3.0, 210.0]];
    settings.limits.box_m = [1.0; 3];
    settings.limits.box_rad = 1.0;
    settings
}

/// Five seconds of free flight; tolerances: m, rad.
fn follows<S: Scalar>((metres, radians): (f64, f64)) {
    let mut driver = idle::<S>(&flight());
    let start = [0.9, -0.3, 1.2, 0.5, -0.4, 0.3];
    driver.inputs.robot.pose = Some(start);
    let first = driver.start().unwrap().trace;
    // Q stands in the laboratory so that M is where it is measured.
    let relative = |trace: &softdock_control::io::Trace| {
        pose_from_components::<f64>(&trace.body_q.pose).inverse()
            * pose_from_components::<f64>(&trace.body_k.pose)
    };
    let c_from_q = pose_from_components::<f64>(&first.pose) * relative(&first).inverse();
    let mut farthest = 0.0_f64;
    for _ in 0..1250 {
        let trace = driver.step().trace;
        assert_eq!(trace.fault, None);
        let meant = c_from_q * relative(&trace);
        let commanded = pose_from_components::<f64>(&trace.command_pose);
        let apart = meant.translation.vector - commanded.translation.vector;
        assert!(apart.norm() < metres, "{:e} m", apart.norm());
        let angle = meant.rotation.angle_to(&commanded.rotation);
        assert!(angle < radians, "{angle:e} rad");
        let travelled = commanded.translation.vector - Vector3::new(start[0], start[1], start[2]);
        farthest = farthest.max(travelled.norm());
    }
    assert!(farthest > 0.1, "travelled only {farthest} m");
}

in_three_scalars! {
    /// The mean of two velocities is the trapezoidal rule: Ts² ω² v t/12 = 1e-9 m, and as much
    /// at the start ramp's corners. f32: a position of 1 m is good to 6e-8 m per cycle, in 1250
    /// cycles as a random walk; fixed: 2.3e-10 rad per cycle always downwards.
    turning_and_flying: follows => f64 (1e-6, 1e-6), f32 (1e-4, 1e-4), fixed (1e-5, 1e-5)
}
