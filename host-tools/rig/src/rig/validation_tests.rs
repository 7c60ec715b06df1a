//! Each refused value, with the name of its key and its range.

use super::RigSettings;
use super::settings::{ServoSettings, WallSettings};

type Spoil = fn(&mut RigSettings);

fn assert_refused(cases: &[(Spoil, &str)]) {
    for (spoil, expected) in cases {
        let mut settings = RigSettings::default();
        settings.validate().unwrap();
        spoil(&mut settings);
        assert_eq!(format!("{:#}", settings.validate().unwrap_err()), *expected);
    }
}

#[test]
fn steps_and_robot() {
    assert_refused(&[
        (
            |s| s.substep_us = 300,
            "rig.substep_us = 300: it must divide rig.cycle_us = 4000 without remainder",
        ),
        (
            |s| s.substep_us = 0,
            "`rig.substep_us` is 0; allowed is 63 to 4000",
        ),
        (
            |s| s.robot.actuator.delay_s = 0.3,
            "`rig.robot.actuator.delay_s` is 0.3; allowed is 0 to 0.252",
        ),
        (
            |s| s.robot.actuator.lag_s = -1.0,
            "`rig.robot.actuator.lag_s` is -1; allowed is 0 to 10",
        ),
        (
            |s| s.robot.actuator.max_velocity_rad_s = Some(0.0),
            "`rig.robot.actuator.max_velocity_rad_s` is 0; allowed is 0.000001 to 1000",
        ),
        (
            |s| {
                s.robot.actuator.servo = Some(ServoSettings {
                    frequency_hz: 20.0,
                    damping_ratio: 1.0,
                })
            },
            "`rig.robot.actuator.servo.damping_ratio` is 1; allowed is 0 to 0.999",
        ),
        (
            |s| s.robot.feedback_latency_cycles = 32,
            "`rig.robot.feedback_latency_cycles` is 32; allowed is 0 to 31",
        ),
        (
            |s| s.robot.correction_limit.lower_m[2] = 0.1,
            "`rig.robot.correction_limit.lower_m` is 0.1; allowed is -10 to 0",
        ),
    ]);
}

#[test]
fn sensor_and_mechanism() {
    assert_refused(&[
        (
            |s| s.gravity_m_s2[1] = f64::NAN,
            "`rig.gravity_m_s2` is NaN; allowed is -100 to 100",
        ),
        (
            |s| s.sensor.tool_mass_kg = -1.0,
            "`rig.sensor.tool_mass_kg` is -1; allowed is 0 to 1000",
        ),
        (
            |s| s.sensor.low_pass_hz = Some(0.0),
            "`rig.sensor.low_pass_hz` is 0; allowed is 0.1 to 100000",
        ),
        (
            |s| s.sensor.calibration[1] = [0.0; 6],
            "rig.sensor.calibration: the matrix has no inverse (determinant 0), six independent rows are needed",
        ),
        (
            |s| {
                let text = "point_m = [0, 0, 0]\nnormal = [1, 0, 0]\nstiffness_n_per_m = 1e4";
                s.mechanism.walls = vec![toml_edit::de::from_str::<WallSettings>(text).unwrap(); 9];
            },
            "rig.mechanism.walls: 9 walls, allowed are 0 to 8",
        ),
    ]);
}

/// Settings that are written read back the same.
#[test]
fn settings_survive_a_round_trip_through_toml() {
    let mut settings = RigSettings::default();
    settings.robot.actuator.servo = Some(ServoSettings {
        frequency_hz: 20.0,
        damping_ratio: 0.1,
    });
    settings.hidden = vec![crate::rig::hidden::suggest("guide_coulomb", 1).unwrap()];
    settings.mechanism.guide = Some(softdock_physics::model::GuideModel {
        axis: [1.0, 0.0, 0.0],
        point_m: [0.0; 3],
        tip_m: [0.0; 3],
        stiffness_n_per_m: 800.0,
        damping_n_s_per_m: 1.0,
    });
    let text = toml_edit::ser::to_string_pretty(&settings).unwrap();
    assert_eq!(
        softdock_io::input::parse::<RigSettings>(&text, "rig.toml").unwrap(),
        settings
    );
}
