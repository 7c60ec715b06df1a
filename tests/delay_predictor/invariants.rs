//! Rules that hold whatever the numbers: silence where nothing is to be done, symmetry, size.

use super::case::{Case, PURE, pausing};
use super::run::{Run, run};
use softdock_control::delay::predictor::Predictor;
use softdock_control::delay::status::{ConfidenceLevel, LawFlags};
use softdock_control::modes::FaultCode;

/// With everything mirrored, every command is the mirrored one in every bit.
#[test]
fn both_directions_are_the_same() {
    let case = Case::default();
    let there = case.fly().run;
    let mut settings = case.settings();
    settings.body_k.velocity_m_s[0] = -case.speed_m_s;
    let mut plant = case.plant();
    for surface in &mut plant.contact.surfaces {
        if let softdock_delay_plants::Surface::Wall(wall) = surface {
            (wall.point[0], wall.normal[0]) = (-wall.point[0], -wall.normal[0]);
        }
    }
    let back = run(&settings, &plant, 1.4);
    let commands = |run: &Run| -> Vec<f64> {
        let sent = run.records.iter().map(|r| r.trace.law_velocity[0]);
        sent.take(330).collect()
    };
    for (n, (a, b)) in commands(&there).iter().zip(commands(&back)).enumerate() {
        assert!(
            a.to_bits() == (-b).to_bits() || (*a == 0.0 && b == 0.0),
            "cycle {n}: {a} {b}"
        );
    }
}

/// Force that pulls along the motion is no contact: the model feels none of it.
#[test]
fn force_that_cannot_be_a_contact_is_left_out() {
    let case = Case::default();
    let mut settings = case.settings();
    // A hundredfold of what stands out, pushing the spacecraft on.
    settings.sensor.bias = [0.0; 6];
    let mut plant = case.plant();
    plant.contact.surfaces.clear();
    let free = run(&settings, &plant, 1.0);
    settings.sensor.bias[0] = -0.5;
    let pulled = run(&settings, &plant, 1.0);
    let last = |run: &Run| run.records.last().map(|r| r.trace.body_k.velocity[0]);
    assert_eq!(last(&free), last(&pulled));
    assert_eq!(last(&free), Some(case.speed_m_s));
}

/// What a law adds without a measured force is in the trace: momentum of the model and sum of all
/// impulses agree.
#[test]
fn the_account_of_momentum_is_complete() {
    let outcome = Case::default().fly();
    let records = &outcome.run.records;
    let impulse: f64 = records
        .iter()
        .skip(27)
        .map(|r| r.trace.wrench_at_m[0] * 0.004 + r.trace.unaccounted_impulse[0])
        .sum();
    let (before, after) = outcome.run.speeds();
    let change = 500.0 * (after - before);
    assert!(
        (impulse - change).abs() < 1e-9 * change.abs(),
        "{impulse} {change}"
    );
}

#[test]
fn the_confidence_level_is_in_the_trace() {
    let outcome = Case::default().fly();
    let level = |n: usize| outcome.run.records[n].trace.law_status.confidence;
    assert_eq!(level(10), ConfidenceLevel::Unverified);
    assert_eq!(level(150), ConfidenceLevel::Verified);
    let last = outcome.run.records.last().map(|r| r.trace.law_status);
    let status = last.expect("a run");
    assert!((status.delay_s - 0.032).abs() < 1e-4);
    let contact =
        |r: &softdock_app::record::CycleRecord| r.trace.law_status.flags.has(LawFlags::CONTACT);
    assert!(outcome.run.records.iter().any(contact));
    let stiffness = status.stiffness_n_per_m;
    assert!((stiffness / 220_500.0 - 1.0).abs() < 0.01, "{stiffness}");
}

/// A robot that does not move at all is not flown into anything.
#[test]
fn a_robot_that_stands_still_is_a_fault() {
    let case = Case {
        robot: softdock_delay_plants::Actuator {
            max_velocity: 0.0,
            ..pausing(PURE)
        },
        ..Case::default()
    };
    let run = run(&case.settings(), &case.plant(), 1.0);
    let fault = run.records.last().and_then(|r| r.trace.fault);
    let code = fault.map(|fault| fault.code);
    assert_eq!(code, Some(FaultCode::ActuatorUnlike));
}

/// A microcontroller keeps the state in its fast memory.
#[test]
fn the_state_is_small() {
    let bytes = size_of::<Predictor>();
    println!("{bytes} bytes");
    assert!(bytes <= 17 * 1024);
}
