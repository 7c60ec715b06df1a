//! Recordings and settings with one thing wrong.

use softdock_app::settings::BoardSettings;
use softdock_commissioning::doctor::{Check, State, of_recording, of_settings, worst};
use softdock_control::io::Sequence;
use softdock_control::modes::{Fault, FaultCode, Mode};
use softdock_experiments::run::record;
use softdock_experiments::scenario::Scenario;
use softdock_io::recording::Recording;

fn recording() -> Recording {
    let mut scenario = Scenario::spring_rod().unwrap();
    scenario.duration_s = 1.0;
    record(&scenario).unwrap().0
}

fn state(checks: &[Check], name: &str) -> State {
    checks.iter().find(|c| c.name == name).unwrap().state
}

#[test]
fn a_run_of_the_simulated_rig_has_nothing_bad() {
    let checks = of_recording(&recording());
    assert_ne!(worst(&checks), State::Bad, "{checks:#?}");
    for name in [
        "robot cycle",
        "lost telegrams",
        "late answers",
        "sensor status",
        "POSCORR",
    ] {
        assert_eq!(state(&checks, name), State::Good, "{checks:#?}");
    }
}

#[test]
fn what_is_wrong_is_named() {
    type Harm = fn(&mut Recording);
    let cases: [(&str, Harm); 8] = [
        ("recording", |r| r.cycles.clear()),
        ("faults", |r| {
            r.cycles[9].trace.fault = Some(Fault::new(FaultCode::Overload, 1.0, 2.0));
        }),
        ("lost telegrams", |r| {
            r.cycles[9].inputs.robot.sequence = Sequence::Gap(40);
        }),
        ("robot cycle", |r| {
            for (n, cycle) in r.cycles.iter_mut().enumerate() {
                cycle.inputs.robot.counter = 1000 + 12 * n as u64;
            }
        }),
        ("robot pose", |r| r.cycles[9].inputs.robot.pose = None),
        ("POSCORR", |r| r.cycles[9].inputs.robot.status = 3),
        ("sensor status", |r| {
            r.cycles[9].inputs.sensor.status = 0x4000
        }),
        ("sensor rate", |r| r.cycles[9].trace.sensor_age = 7),
    ];
    for (name, harm) in cases {
        let mut recording = recording();
        harm(&mut recording);
        let checks = of_recording(&recording);
        assert_eq!(state(&checks, name), State::Bad, "{name}: {checks:#?}");
    }
}

#[test]
fn settings_that_nobody_measured_are_warned_of() {
    let mut board = BoardSettings::default();
    let checks = of_settings(&board);
    assert_eq!(state(&checks, "tool"), State::Warning);
    assert_eq!(state(&checks, "robot's delay"), State::Warning);
    board.control.sensor.tool_mass_kg = 2.0;
    board.control.delay.actuator.delay_s = 0.03;
    let checks = of_settings(&board);
    assert_eq!(state(&checks, "tool"), State::Good);
    assert_eq!(state(&checks, "robot's delay"), State::Good);
    board.control.sensor.tool_mass_kg = -1.0;
    assert_eq!(state(&of_settings(&board), "settings"), State::Bad);
}

/// A board that is recorded from its first cycle has no sample then, and the tool's weight stands in its place.
#[test]
fn cycles_before_the_first_sample_are_no_force_at_rest() {
    let mut recording = recording();
    let early = recording.cycles.len() * 3 / 4;
    for cycle in &mut recording.cycles {
        cycle.trace.mode = Mode::Hold;
        cycle.trace.wrench_at_m = [0.1, 0.0, 0.2, 0.0, 0.0, 0.0];
    }
    for cycle in &mut recording.cycles[..early] {
        cycle.inputs.sensor.counter = 0;
        cycle.trace.wrench_at_m[2] = -18.0;
    }
    let checks = of_recording(&recording);
    assert_eq!(state(&checks, "force at rest"), State::Good, "{checks:#?}");
}
