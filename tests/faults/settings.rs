//! Settings that no rig can have are refused by name.

use softdock_app::robot_cycle::RobotCycle;
use softdock_control::settings::Settings;

type Spoil = fn(&mut Settings);

#[test]
fn each_bad_field_is_named() {
    let table: Vec<(Spoil, &str)> = vec![
        (|s| s.robot.cycle_s = 0.0, "robot.cycle_s"),
        (|s| s.robot.cycle_s = f64::NAN, "robot.cycle_s"),
        (
            |s| s.robot.correction_decimals = 7,
            "robot.correction_decimals",
        ),
        (
            |s| s.sensor.orientation_wxyz[2] = f64::INFINITY,
            "sensor.orientation_wxyz",
        ),
        (|s| s.sensor.bias[5] = f64::NAN, "sensor.bias"),
        (|s| s.sensor.tool_mass_kg = -1.0, "sensor.tool_mass_kg"),
        (
            |s| s.sensor.fault_after_cycles = 1,
            "sensor.fault_after_cycles",
        ),
        (|s| s.body_k.mass_kg = 0.0, "body_k.mass_kg"),
        (
            |s| s.body_q.inertia_kg_m2[1][1] = -3.0,
            "body_q.inertia_kg_m2",
        ),
        // Not symmetric; symmetric but not positive definite.
        (
            |s| s.body_k.inertia_kg_m2[0][1] = 5.0,
            "body_k.inertia_kg_m2",
        ),
        (
            |s| {
                s.body_k.inertia_kg_m2[0][1] = 150.0;
                s.body_k.inertia_kg_m2[1][0] = 150.0;
            },
            "body_k.inertia_kg_m2",
        ),
        (
            |s| s.body_k.inertia_kg_m2[0][0] = 0.002,
            "body_k.inertia_kg_m2 ratio of moments",
        ),
        (
            |s| s.body_q.orientation_wxyz[0] = f64::NAN,
            "body_q.orientation_wxyz",
        ),
        (
            |s| s.body_q.angular_velocity_rad_s[1] = 6.0,
            "body_q.angular_velocity_rad_s",
        ),
        (
            |s| s.frames.p_orientation_wxyz[3] = f64::NEG_INFINITY,
            "frames.p_orientation_wxyz",
        ),
        (
            |s| s.delay.seed.translation.c[3] = 1e5,
            "delay.seed.translation.c",
        ),
        (|s| s.delay.seed.low_pass_hz = 0.0, "delay.seed.low_pass_hz"),
        (|s| s.limits.box_m[2] = f64::NAN, "limits.box_m"),
        (
            |s| s.limits.clamp_fault_cycles = 0,
            "limits.clamp_fault_cycles",
        ),
        (|s| s.start.zero_cycles = 1, "start.zero_cycles"),
        (|s| s.start.ramp_cycles = 0, "start.ramp_cycles"),
        (|s| s.start.stop_time_s = 0.0, "start.stop_time_s"),
    ];
    assert!(RobotCycle::<f64>::new(&Settings::default()).is_ok());
    for (spoil, field) in table {
        let mut settings = Settings::default();
        spoil(&mut settings);
        let error = RobotCycle::<f64>::new(&settings).err();
        assert_eq!(error.map(|e| e.field), Some(field), "{error:?}");
    }
}
