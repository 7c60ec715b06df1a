//! The firmware's tasks against the simulated rig in virtual time: deterministic, replayable, and
//! with the numbers of the paper's experiment.

use softdock_app::record::CycleRecord;
use softdock_app::settings::SensorKind;
use softdock_control::delay::LawName;
use softdock_control::modes::{Command, Mode};
use softdock_experiments::impacts::{self, Impact};
use softdock_experiments::run::record;
use softdock_experiments::scenario::Scenario;
use softdock_experiments::spring_rod::{TOUCH, one_stop, two_stops};
use softdock_io::recording::Recording;
use softdock_io::replay::replay;
use softdock_link::can::ati::AtiCalibration;
use softdock_rig::board::virtual_time::{Simulation, simulate};
use softdock_rig::rig::Rig;
use std::ops::ControlFlow;

/// A noisy spring-rod run of one second.
fn noisy() -> Scenario {
    let mut scenario = Scenario::spring_rod().unwrap().with_law(LawName::Seed);
    scenario.duration_s = 1.6;
    scenario.rig.sensor.noise_force_n = 0.3;
    scenario.rig.sensor.noise_torque_nm = 0.02;
    scenario.rig.robot.position_noise_m = 2e-6;
    scenario
}

fn run(scenario: &Scenario) -> Recording {
    record(scenario).unwrap().0
}

fn first_impact(scenario: &Scenario) -> Impact {
    impacts::find(scenario, &run(scenario))
        .into_iter()
        .next()
        .unwrap()
}

#[test]
fn a_run_is_deterministic_and_its_seed_matters() {
    let mut scenario = noisy();
    let first = run(&scenario);
    assert_eq!(first, run(&scenario));
    scenario.seed += 1;
    assert_ne!(first.cycles, run(&scenario).cycles);
}

#[test]
fn every_cycle_is_recorded_and_replays_bit_for_bit() {
    let scenario = noisy();
    let recording = run(&scenario);
    assert_eq!(recording.cycles.len(), scenario.cycles());
    assert_eq!(recording.truth.len(), scenario.cycles());
    let report = replay(&recording).unwrap();
    assert!(report.identical, "{report}");
}

/// As in the closed loops of single cycles, where it is so at every speed.
#[test]
fn without_compensation_the_bounce_is_2_8_times_too_fast() {
    let impact = first_impact(&one_stop(LawName::None, 0.005, TOUCH).unwrap());
    assert!((impact.restitution - 2.81).abs() < 0.06, "{impact:?}");
    assert!((impact.peak_force_error - 0.66).abs() < 0.01, "{impact:?}");
}

#[test]
fn impacts_grow_until_the_sensor_is_saturated() {
    let scenario = two_stops(LawName::None, 0.005, 6.0).unwrap();
    let recording = run(&scenario);
    let impacts = impacts::find(&scenario, &recording);
    assert!(impacts.len() >= 3);
    for pair in impacts.windows(2) {
        assert!(
            pair[1].peak_force_n > 2.0 * pair[0].peak_force_n,
            "{impacts:?}"
        );
    }
    assert_eq!(recording.cycles.last().unwrap().trace.mode, Mode::Fault);
}

#[test]
fn without_delay_an_off_centre_oblique_bounce_turns_the_spacecraft_as_it_should() {
    let mut scenario = Scenario::spring_rod().unwrap();
    scenario.rig.robot.actuator.delay_s = 0.0;
    scenario.rig.robot.actuator.pause_s = 0.0;
    scenario.board.control.delay.model_velocity = softdock_control::delay::ModelVelocity::End;
    let wall = &mut scenario.rig.mechanism.walls[0];
    wall.normal = [-0.8, -0.6, 0.0];
    wall.tip_m = [0.0, 0.0, 0.3];
    let recording = run(&scenario);
    let impacts = impacts::find(&scenario, &recording);
    let impact = impacts.first().unwrap();
    assert!((impact.restitution - 1.0).abs() < 0.02, "{impact:?}");
    assert!(impact.contact_time_error.abs() < 0.05, "{impact:?}");
    // Momentum that the wall took, and its lever: Δω = I⁻¹ (r × J) for a small turn.
    let last = recording.cycles.last().unwrap().trace.body_k.velocity;
    let impulse: Vec<f64> = (0..3)
        .map(|i| 500.0 * (last[i] - [0.005, 0.0, 0.0][i]))
        .collect();
    let turn = [-0.3 * impulse[1] / 180.0, 0.3 * impulse[0] / 220.0];
    assert!(
        (last[3] - turn[0]).abs() < 0.02 * turn[0].abs(),
        "{last:?} {turn:?}"
    );
    assert!(
        (last[4] - turn[1]).abs() < 0.02 * turn[1].abs(),
        "{last:?} {turn:?}"
    );
}

#[test]
fn the_analytic_bounce_does_not_depend_on_how_the_laboratory_is_turned() {
    let impact = |turned: bool| {
        let mut scenario = one_stop(LawName::None, 0.005, TOUCH).unwrap();
        scenario.rig.robot.actuator.delay_s = 0.0;
        scenario.rig.robot.actuator.pause_s = 0.0;
        let control = &mut scenario.board.control;
        control.delay.model_velocity = softdock_control::delay::ModelVelocity::End;
        control.body_q.fixed = false;
        control.body_q.mass_kg = 800.0;
        control.body_q.inertia_kg_m2 = [[300.0, 0.0, 0.0], [0.0, 400.0, 0.0], [0.0, 0.0, 500.0]];
        control.body_q.position_m = [1.0, 0.4, 0.0];
        let wall = &mut scenario.rig.mechanism.walls[0];
        wall.tip_m = [0.0, 0.2, 0.0];
        if turned {
            // A quarter turn about z, of M and of what the spacecraft flies against.
            let turn = |[x, y, z]: [f64; 3]| [-y, x, z];
            scenario.start_abc_rad = [std::f64::consts::FRAC_PI_2, 0.0, 0.0];
            let start = scenario.start_position_m;
            let wall = &mut scenario.rig.mechanism.walls[0];
            let ahead: Vec<f64> = (0..3).map(|i| wall.point_m[i] - start[i]).collect();
            let ahead = turn([ahead[0], ahead[1], ahead[2]]);
            wall.point_m = [0, 1, 2].map(|i| start[i] + ahead[i]);
            wall.normal = turn(wall.normal);
        }
        first_impact(&scenario)
    };
    let (straight, turned) = (impact(false), impact(true));
    assert!(straight.peak_force_error.abs() < 0.05, "{straight:?}");
    assert!(
        (straight.peak_force_error - turned.peak_force_error).abs() < 0.02,
        "{turned:?}"
    );
    assert!((straight.contact_time_error - turned.contact_time_error).abs() < 0.05);
}

#[test]
fn a_streaming_sensor_gives_the_same_bounce_as_a_polled_one() {
    let mut scenario = one_stop(LawName::None, 0.005, TOUCH).unwrap();
    let polled = first_impact(&scenario);
    scenario.board.can.sensor = SensorKind::Sri;
    let streamed = first_impact(&scenario);
    assert!(
        (polled.restitution - streamed.restitution).abs() < 0.03,
        "{polled:?} {streamed:?}"
    );
}

#[test]
fn an_operator_holds_arms_starts_and_stops() {
    let mut scenario = noisy();
    scenario.rig.mechanism.walls.clear();
    let sensor = &scenario.rig.sensor;
    let commands = [
        Command::Hold,
        Command::Zero,
        Command::Arm,
        Command::Start,
        Command::Stop,
    ];
    let simulation = Simulation {
        board: &scenario.board,
        rig: Rig::new(&scenario.rig, scenario.start_pose(), 1).unwrap(),
        calibration: AtiCalibration {
            matrix: sensor.calibration,
            counts_per_force: sensor.counts_per_newton,
            counts_per_torque: sensor.counts_per_newton_metre,
        },
        duration_s: 1.0,
        commands: (0..).map(|n| 40 * (n + 1)).zip(commands).collect(),
    };
    let mut records: Vec<CycleRecord> = Vec::new();
    simulate(simulation, &mut |record, _| {
        records.push(*record);
        ControlFlow::Continue(())
    })
    .unwrap();
    let modes = [39, 79, 119, 159, 199, 249].map(|n: usize| records[n].trace.mode);
    let expected = [
        Mode::Idle,
        Mode::Hold,
        Mode::Hold,
        Mode::Armed,
        Mode::Running,
        Mode::Hold,
    ];
    assert_eq!(modes, expected);
    let speed = |n: usize| records[n].trace.sent_velocity[0];
    assert!((speed(199) - 0.005).abs() < 1e-4);
    assert!(speed(205) > 0.0 && speed(205) < 0.005, "a stop fades out");
    assert_eq!(speed(249), 0.0);
}
