//! Identifications of simulated robots whose actuator is known.

use rayon::prelude::*;
use softdock_commissioning::identify::{Identification, identify};
use softdock_experiments::jog_rehearsal::jog;
use softdock_experiments::scenario::Scenario;
use softdock_io::input::parse;
use softdock_physics::model::Axis;
use softdock_rig::rig::settings::{MechanismSettings, ServoSettings};
use softdock_statistics::RandomStream;

fn scenario() -> Scenario {
    let mut scenario = Scenario::spring_rod().unwrap();
    let actuator = &mut scenario.rig.robot.actuator;
    (actuator.delay_s, actuator.lag_s, actuator.pause_s) = (0.0, 0.0, 0.0);
    scenario
}

/// A robot drawn from a seed: structure, delay, pause and noise.
struct Drawn {
    scenario: Scenario,
    words: String,
    delay_s: f64,
    mean_s: f64,
    pause_s: f64,
}

fn drawn(seed: u64) -> Drawn {
    let mut noise = RandomStream::new(seed, 11);
    let mut scenario = scenario();
    let robot = &mut scenario.rig.robot;
    let total_s = 0.005 + 0.055 * noise.uniform();
    robot.position_noise_m = 20e-6 * noise.uniform();
    let pause_s = 0.032 * noise.uniform();
    let actuator = &mut robot.actuator;
    actuator.pause_s = pause_s;
    let share = 0.2 + 0.6 * noise.uniform();
    let (words, mean_s) = match seed % 4 {
        0 => ("delay", total_s),
        1 => {
            actuator.lag_s = share * total_s;
            ("delay + lag", total_s)
        }
        2 => {
            actuator.lag_s = total_s;
            ("delay + lag", total_s)
        }
        _ => {
            let servo = ServoSettings {
                frequency_hz: 5.0 + 10.0 * noise.uniform(),
                damping_ratio: 0.5 + 0.4 * noise.uniform(),
            };
            let behind = 2.0 * servo.damping_ratio / (std::f64::consts::TAU * servo.frequency_hz);
            actuator.servo = Some(servo);
            ("delay + servo", total_s + behind)
        }
    };
    actuator.delay_s = match seed % 4 {
        1 => total_s - actuator.lag_s,
        2 => 0.0,
        _ => total_s,
    };
    Drawn {
        delay_s: actuator.delay_s,
        scenario,
        words: words.to_owned(),
        mean_s,
        pause_s,
    }
}

fn identified(drawn: &Drawn, seed: u64) -> Identification {
    identify(&jog(&drawn.scenario, Axis::Y, seed).unwrap()).unwrap()
}

/// Of 100 robots, with up to 20 µm of noise, delay and mean delay are right within 1 ms and the pause
/// within 2 ms; also where the structure is taken for another one that follows alike.
#[test]
#[ignore = "long: a hundred identifications"]
fn a_hundred_robots_are_identified() {
    are_identified(0..100);
}

/// One robot of each structure.
#[test]
fn four_robots_are_identified() {
    are_identified(0..4);
}

fn are_identified(seeds: std::ops::Range<u64>) {
    let all: Vec<(u64, Drawn, Identification)> = seeds
        .into_par_iter()
        .map(|seed| {
            let drawn = drawn(seed);
            let found = identified(&drawn, seed);
            (seed, drawn, found)
        })
        .collect();
    let (mut wrong, mut covered, mut structures) = (Vec::new(), 0, 0);
    for (seed, drawn, found) in &all {
        let pause_s = found.pause_s.unwrap().value;
        let errors = [
            found.delay_s.value - drawn.delay_s,
            found.mean_delay_s.value - drawn.mean_s,
            pause_s - drawn.pause_s,
        ]
        .map(|e| e * 1e3);
        structures += u32::from(found.structure == drawn.words);
        covered += u32::from(
            found.mean_delay_s.low - 2.5e-4 <= drawn.mean_s
                && found.mean_delay_s.high.unwrap() + 2.5e-4 >= drawn.mean_s,
        );
        if errors[0].abs() > 1.0 || errors[1].abs() > 1.0 || errors[2].abs() > 2.0 {
            wrong.push(*seed);
            eprintln!(
                "{seed}: {} as {}, noise {:.1} um: delay {:+.2}, mean {:+.2}, pause {:+.2} ms; \
                 delay {} pause {:.1}",
                drawn.words,
                found.structure,
                drawn.scenario.rig.robot.position_noise_m * 1e6,
                errors[0],
                errors[1],
                errors[2],
                found.delay_s.in_ms(),
                drawn.pause_s * 1e3,
            );
        }
    }
    eprintln!(
        "{} of {} outside, {structures} structures right, {covered} means covered",
        wrong.len(),
        all.len()
    );
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// The tool's inertia tells the age of the pose from the delay.
#[test]
fn a_heavy_tool_shows_the_age_of_the_pose() {
    for age in [0_u8, 2, 4] {
        let mut scenario = scenario();
        scenario.rig.robot.feedback_latency_cycles = age;
        scenario.rig.robot.actuator.delay_s = 0.024;
        scenario.rig.sensor.inertial_load = true;
        scenario.rig.sensor.tool_mass_kg = 8.0;
        scenario.rig.sensor.noise_force_n = 0.5;
        scenario.rig.robot.position_noise_m = 10e-6;
        let found = identify(&jog(&scenario, Axis::Y, 1).unwrap()).unwrap();
        let latency = found.feedback_latency_cycles.unwrap();
        assert_eq!(latency.value, f64::from(age), "{latency:?}");
        assert!(
            (found.delay_s.value - 0.024).abs() < 1e-3,
            "{:?}",
            found.delay_s
        );
    }
}

/// Without a force the age is a part of the delay, and that is said.
#[test]
fn without_a_force_the_age_is_not_told_from_the_delay() {
    let mut scenario = scenario();
    scenario.rig.robot.feedback_latency_cycles = 2;
    scenario.rig.robot.actuator.delay_s = 0.024;
    let found = identify(&jog(&scenario, Axis::Y, 1).unwrap()).unwrap();
    assert!(found.feedback_latency_cycles.is_none());
    assert!(
        (found.delay_s.value - 0.032).abs() < 1e-3,
        "{:?}",
        found.delay_s
    );
    let said = |n: &String| n.contains("cannot be told from the robot's delay");
    assert!(found.notes.iter().any(said), "{:?}", found.notes);
}

#[test]
fn a_limit_of_the_acceleration_is_found() {
    let mut scenario = scenario();
    scenario.rig.robot.actuator.delay_s = 0.02;
    scenario.rig.robot.actuator.max_acceleration_m_s2 = Some(0.8);
    scenario.rig.robot.position_noise_m = 5e-6;
    let found = identify(&jog(&scenario, Axis::Y, 1).unwrap()).unwrap();
    let limit = found.axes[0].max_acceleration.unwrap();
    assert!((limit.value / 0.8 - 1.0).abs() < 0.03, "{limit:?}");
    assert!(
        (found.delay_s.value - 0.02).abs() < 1e-3,
        "{:?}",
        found.delay_s
    );
}

#[test]
fn a_limit_of_the_velocity_is_found() {
    let mut scenario = scenario();
    scenario.rig.robot.actuator.delay_s = 0.02;
    scenario.rig.robot.actuator.max_velocity_m_s = Some(0.022);
    let found = identify(&jog(&scenario, Axis::Y, 1).unwrap()).unwrap();
    let limit = found.axes[0].max_velocity.unwrap();
    assert!((limit.value / 0.022 - 1.0).abs() < 0.03, "{limit:?}");
    assert!(found.axes[0].max_acceleration.is_none());
    let delay_s = found.delay_s.value;
    assert!((delay_s - 0.02).abs() < 1e-3, "{delay_s}");
}

/// Whatever the mechanism: its force would be taken for a late pose.
#[test]
fn a_rehearsal_is_in_free_space() {
    let text = include_str!("../../host-tools/scenarios/soft-capture.toml");
    let mut scenario: Scenario = parse(text, "soft-capture.toml").unwrap();
    scenario.rig.mechanism.docking[0].position_m[0] = 3.2; // the probe is in it
    let rehearsed = jog(&scenario, Axis::X, 1).unwrap();
    scenario.rig.mechanism = MechanismSettings::default();
    assert!(rehearsed.cycles == jog(&scenario, Axis::X, 1).unwrap().cycles);
}

#[test]
fn a_robot_that_rests_tells_nothing() {
    let mut recording = jog(&scenario(), Axis::Y, 1).unwrap();
    for cycle in &mut recording.cycles {
        cycle.trace.sent_velocity = [0.0; 6];
    }
    let error = identify(&recording).unwrap_err().to_string();
    assert!(error.contains("was sent no velocity"), "{error}");
}
