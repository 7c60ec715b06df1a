//! The corrections as the robot gets them: integers of the last digit. Their sum is the commanded
//! pose, for ever, and no turn of the model makes A or C jump.

use softdock_app::record::Correction;
use softdock_control::delay::LawName;
use softdock_control::frames::{abc_from_orientation, pose_from_components};
use softdock_control::modes::FaultCode;
use softdock_control::scalar::Scalar;
use softdock_tests::driver::{flying, idle};
use softdock_tests::in_three_scalars;
use softdock_tests::walls::Case;

/// Correction per metre and per degree at 4 decimals of mm and degrees.
const COUNTS_PER_M: f64 = 1e7;
const COUNTS_PER_DEG: f64 = 1e4;

fn add(sum: &mut Correction, correction: &Correction) {
    sum.iter_mut().zip(correction).for_each(|(s, c)| *s += c);
}

/// Ten minutes between two turned walls, 4 decimals: thousands of reversals.
fn bouncing<S: Scalar>(digits: f64) {
    let mut case = Case::new(15.0, 0.01).turned(0.4);
    case.settings.robot.correction_decimals = 4;
    case.left_m = 0.001;
    case.right_m = 0.001;
    // A damped law would come to rest, a late robot would run away: ideal robot, no law.
    case.settings.delay.law = LawName::None;
    case.settings.delay.model_velocity = softdock_control::delay::ModelVelocity::End;
    case.settings.start.ramp_cycles = 1;
    let mut rig = case.start::<S>();
    let mut sum = [0; 6];
    let mut touched = 0;
    for n in 0..150_000 {
        let record = rig.step();
        assert_eq!(record.trace.fault, None);
        add(&mut sum, &record.output.correction);
        touched += u32::from(record.inputs.sensor.wrench[0] != 0.0);
        for (i, counts) in sum.iter().take(3).enumerate() {
            let meant = record.trace.command_pose[i] * COUNTS_PER_M;
            assert!(
                (*counts as f64 - meant).abs() <= digits,
                "{n}: {counts}, meant {meant}"
            );
        }
    }
    assert!(touched > 10_000, "{touched}");
}

/// A minute of turning about a slanted axis and flying, far from the origin.
fn turning<S: Scalar>((digits, digits_of_angle): (f64, f64)) {
    let mut settings = flying(0.003);
    settings.body_k.angular_velocity_rad_s = [0.004, -0.003, 0.005];
    settings.limits.box_rad = 1.0;
    let mut driver = idle::<S>(&settings);
    let start = [1.2, -0.7, 0.9, 3.1, 0.6, -2.9];
    driver.inputs.robot.pose = Some(start);
    let mut sum = driver.start().unwrap().output.correction;
    for n in 0..15_000 {
        let record = driver.step();
        assert_eq!(record.trace.fault, None);
        add(&mut sum, &record.output.correction);
        let pose = pose_from_components::<f64>(&record.trace.command_pose);
        for i in 0..3 {
            let meant = (pose.translation.vector[i] - start[i]) * COUNTS_PER_M;
            let apart = sum[i] as f64 - meant;
            assert!(apart.abs() <= digits, "{n}: {} apart by {apart}", sum[i]);
        }
        let abc = abc_from_orientation(&pose.rotation);
        for i in 0..3 {
            let meant = (abc[i] - start[i + 3]).to_degrees() * COUNTS_PER_DEG;
            let apart = (sum[i + 3] as f64 - meant).rem_euclid(360.0 * COUNTS_PER_DEG);
            let apart = apart.min(360.0 * COUNTS_PER_DEG - apart);
            assert!(
                apart <= digits_of_angle,
                "{n}: {} apart by {apart}",
                sum[i + 3]
            );
        }
    }
}

/// Turning towards B = 90°, where a small rotation needs a large step of A and C: the robot stops
/// at 80° and faults.
fn steps_near_the_singularity<S: Scalar>() {
    for spin in [[0.0, 0.2, 0.0], [0.0, 0.2, 0.01], [0.05, 0.2, -0.03]] {
        let mut settings = flying(0.0);
        settings.body_k.angular_velocity_rad_s = spin;
        settings.limits.box_rad = 1.5;
        let mut driver = idle::<S>(&settings);
        driver.inputs.robot.pose = Some([0.0, 0.0, 0.0, 0.3, 1.2, -0.2]);
        driver.start().unwrap();
        let fault = (0..3000).find_map(|_| {
            let record = driver.step();
            let [.., a, b, c] = record.output.correction.map(|v| v as f64 / COUNTS_PER_DEG);
            // 0.2 rad/s × 4 ms is 0.046°; at B = 80° A and C take up to six times that.
            let largest = a.abs().max(b.abs()).max(c.abs());
            assert!(largest < 0.3, "{spin:?}: step of {largest}°");
            record.trace.fault
        });
        assert_eq!(
            fault.map(|f| f.code),
            Some(FaultCode::SustainedClamp),
            "{spin:?}"
        );
        let pose = pose_from_components::<f64>(&driver.step().trace.command_pose);
        let [_, b, _] = abc_from_orientation(&pose.rotation);
        assert!((1.39..1.401).contains(&b), "{spin:?}: B {b}");
    }
}

in_three_scalars! {
    /// Half a digit, whatever the scalar: the displacement itself is rounded, not its steps.
    never_drifts_while_bouncing: bouncing => f64 0.501, f32 0.501, fixed 0.501,
    /// The trace adds the displacement to a start at 1.2 m: f32 does so to 1.2e-7 m, 1.2 digits.
    /// Angles: the start is given in A, B, C; f32 turns them into a quaternion and back to 4e-7
    /// rad, 0.2 digits; the sine of fixed point is good to 2e-9 rad.
    never_drifts_while_turning: turning => f64 (0.501, 0.501), f32 (2.0, 1.0), fixed (0.51, 0.51),
    near_the_singularity: steps_near_the_singularity
}
