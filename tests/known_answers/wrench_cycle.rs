//! What the sensor reads beside the contact, removed by the whole cycle: weight and zero of the
//! sensor in any pose, and the wrench that accelerating the tool takes.

use nalgebra::{Isometry3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use softdock_control::scalar::{Fixed, Scalar};
use softdock_control::settings::{DynamicCompensation, SensorSettings, Settings};
use softdock_tests::driver::idle;
use softdock_tests::in_three_scalars;

const CYCLE_S: f64 = 0.004;
const MASS_KG: f64 = 12.0;
const COM_M: [f64; 3] = [0.01, -0.02, 0.09];
const INERTIA: [f64; 3] = [0.2, 0.3, 0.1];
const BIAS: [f64; 6] = [3.0, -2.0, 1.0, 0.1, 0.2, -0.3];

fn settings(dynamic_compensation: DynamicCompensation) -> Settings {
    let [x, y, z] = INERTIA;
    Settings {
        sensor: SensorSettings {
            position_m: [0.0, 0.02, -0.3],
            orientation_wxyz: [0.9, 0.1, -0.2, 0.3],
            tool_mass_kg: MASS_KG,
            tool_com_m: COM_M,
            tool_inertia_kg_m2: [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]],
            bias: BIAS,
            dynamic_compensation,
            ..SensorSettings::default()
        },
        ..Settings::default()
    }
}

/// S in C for a pose of M, from KUKA's definition of A, B, C.
fn c_from_s([x, y, z, a, b, c]: [f64; 6]) -> Isometry3<f64> {
    let rotation = Rotation3::from_axis_angle(&Vector3::z_axis(), a)
        * Rotation3::from_axis_angle(&Vector3::y_axis(), b)
        * Rotation3::from_axis_angle(&Vector3::x_axis(), c);
    let sensor = UnitQuaternion::from_quaternion(Quaternion::new(0.9, 0.1, -0.2, 0.3));
    Isometry3::from_parts(Translation3::new(x, y, z), rotation.into())
        * Isometry3::from_parts(Translation3::new(0.0, 0.02, -0.3), sensor)
}

/// The reading in S of a force in C on the tool's centre of mass and a torque in S, and the bias.
fn reading(c_from_s: &Isometry3<f64>, force_c: Vector3<f64>, torque_s: Vector3<f64>) -> [f64; 6] {
    let force = c_from_s.rotation.inverse() * force_c;
    let torque = Vector3::from(COM_M).cross(&force) + torque_s;
    let f = [force.x, force.y, force.z, torque.x, torque.y, torque.z];
    core::array::from_fn(|i| f[i] + BIAS[i])
}

fn weight_leaves_nothing<S: Scalar>(pose: [f64; 6], tolerance: f64) -> Result<(), TestCaseError> {
    let mut driver = idle::<S>(&settings(DynamicCompensation::Off));
    driver.inputs.robot.pose = Some(pose);
    let weight = Vector3::new(0.0, 0.0, -9.81 * MASS_KG);
    driver.inputs.sensor.wrench = reading(&c_from_s(pose), weight, Vector3::zeros());
    let left = driver.step().trace.wrench_at_m;
    prop_assert!(left.iter().all(|v| v.abs() < tolerance), "{left:?}");
    Ok(())
}

proptest! {
    /// f64: rounding of 118 N. f32: 118 N × 6e-8 × some ten operations. Fixed: the sine of an
    /// angle is good to 2e-9, times 118 N and a lever of 0.3 m.
    #[test]
    fn weight_and_bias_in_any_pose(
        at in prop::array::uniform3(-3.0..3.0f64),
        a in -3.1..3.1f64, b in -1.5..1.5f64, c in -3.1..3.1f64,
    ) {
        let pose = [at[0], at[1], at[2], a, b, c];
        weight_leaves_nothing::<f64>(pose, 1e-10)?;
        weight_leaves_nothing::<f32>(pose, 2e-4)?;
        weight_leaves_nothing::<Fixed>(pose, 1e-5)?;
    }
}

/// Pose at a time: from rest, 0.3 m/s² along a slant and 0.2 rad/s² about z (A).
fn accelerated(time_s: f64) -> [f64; 6] {
    let half_square = 0.5 * time_s * time_s;
    let along = 0.3 * half_square;
    [
        along * 0.6,
        along * -0.48,
        along * 0.64,
        0.2 * half_square,
        0.3,
        -0.2,
    ]
}

/// Largest force and torque that the cycle leaves at the end of a second of acceleration.
fn left_over<S: Scalar>(compensation: DynamicCompensation) -> (f64, f64) {
    let mut driver = idle::<S>(&settings(compensation));
    let mut left = [0.0; 6];
    for n in 0..250 {
        let time_s = f64::from(n) * CYCLE_S;
        let s = c_from_s(accelerated(time_s));
        // Acceleration of the centre of mass: second difference of its path.
        let at = |t: f64| (c_from_s(accelerated(t)) * nalgebra::Point3::from(COM_M)).coords;
        let h = 1e-3;
        let acceleration = (at(time_s + h) - at(time_s) * 2.0 + at(time_s - h)) / (h * h);
        // The turn is about z of C.
        let in_s = |v: Vector3<f64>| s.rotation.inverse() * v;
        let (omega, alpha) = (in_s(Vector3::z() * 0.2 * time_s), in_s(Vector3::z() * 0.2));
        let inertia = Vector3::from(INERTIA);
        let spin = inertia.component_mul(&alpha) + omega.cross(&inertia.component_mul(&omega));
        let force = Vector3::new(0.0, 0.0, -9.81 * MASS_KG) - acceleration * MASS_KG;
        driver.inputs.robot.pose = Some(accelerated(time_s));
        driver.inputs.sensor.wrench = reading(&s, force, -spin);
        left = driver.step().trace.wrench_at_m;
    }
    let largest = |v: &[f64]| v.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    (largest(&left[..3]), largest(&left[3..]))
}

/// Tolerances: force, torque.
fn tool_inertia_is_removed<S: Scalar>((force, torque): (f64, f64)) {
    let (off_force, off_torque) = left_over::<S>(DynamicCompensation::Off);
    assert!(
        off_force > 1.5 && off_torque > 0.3,
        "{off_force} {off_torque}"
    );
    let (on_force, on_torque) = left_over::<S>(DynamicCompensation::LoadReaction);
    assert!(
        on_force < force && on_torque < torque,
        "{on_force} {on_torque}"
    );
    // The sign as printed belongs to a sensor of the other kind: here it doubles the error.
    let (printed, _) = left_over::<S>(DynamicCompensation::Printed);
    assert!((printed / off_force - 2.0).abs() < 0.05, "{printed}");
}

in_three_scalars! {
    /// Off leaves 2.6 N. The estimate of the acceleration has settled to 1e-4 after a second;
    /// f32: a step of 1 mm is good to 1e-8 m, differentiated over the filter's 100 ms and times
    /// 12 kg that is 1e-3 N.
    accelerated_tool: tool_inertia_is_removed => f64 (1e-3, 3e-4), f32 (3e-3, 1e-3), fixed (1e-3, 3e-4)
}
