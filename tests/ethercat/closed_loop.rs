//! The closed loop over EtherCAT, in virtual time.

use softdock_control::delay::LawName;
use softdock_control::modes::Mode;
use softdock_experiments::impacts::{self, Impact};
use softdock_experiments::run::record;
use softdock_experiments::scenario::Scenario;
use softdock_experiments::spring_rod::{TOUCH, one_stop};
use softdock_io::recording::Recording;
use softdock_io::replay::replay;
use softdock_tests::peers::without_noise;

fn on_ethercat(mut scenario: Scenario) -> Scenario {
    scenario.board.ethercat.enabled = true;
    scenario
}

fn first_impact(scenario: &Scenario) -> (Impact, Recording) {
    let recording = record(scenario).unwrap().0;
    let impacts = impacts::find(scenario, &recording);
    (impacts.into_iter().next().unwrap(), recording)
}

/// Counts of 1e-6 N in place of gauges, and a sample that is 0.3 ms younger: the physics is the same.
#[test]
fn the_spring_rod_bounces_as_over_can() {
    for law in [LawName::None, LawName::Seed] {
        for speed in [0.001, 0.005, 0.015] {
            let scenario = without_noise(one_stop(law, speed, TOUCH).unwrap());
            let (can, _) = first_impact(&scenario);
            let (ethercat, recording) = first_impact(&on_ethercat(scenario));
            let difference = ethercat.restitution / can.restitution - 1.0;
            assert!(
                difference.abs() < 0.01,
                "{law:?} {speed}: {can:?} {ethercat:?}"
            );
            let difference = ethercat.peak_force_error - can.peak_force_error;
            assert!(
                difference.abs() < 0.01,
                "{law:?} {speed}: {can:?} {ethercat:?}"
            );
            assert_eq!(recording.cycles.last().unwrap().trace.mode, Mode::Running);
            let report = replay(&recording).unwrap();
            assert!(report.identical, "{report}");
        }
    }
}

/// Each telegram has a sample of its own, taken when it came: none is lost, none comes twice.
#[test]
fn in_twenty_thousand_cycles_at_1_khz_no_frame_is_lost() {
    let mut scenario = on_ethercat(Scenario::spring_rod().unwrap());
    scenario.rig.mechanism.walls.clear();
    let control = &mut scenario.board.control;
    control.robot.cycle_s = 0.001;
    // A jog changes its velocity from cycle to cycle by what these allow.
    (control.jog.speed_m_s, control.jog.reach_m) = (0.002, 0.005);
    (control.jog.speed_rad_s, control.jog.reach_rad) = (0.002, 0.005);
    scenario.board.can.sample_wait_s = 0.0005;
    scenario.board.ethercat.sample_wait_s = 0.0005;
    scenario.rig.cycle_us = 1000;
    scenario.duration_s = 20.0;
    let recording = record(&scenario).unwrap().0;
    assert_eq!(recording.cycles.len(), 20_000);
    let started = recording
        .cycles
        .iter()
        .position(|cycle| cycle.inputs.sensor.counter > 0);
    let running = &recording.cycles[started.unwrap()..];
    assert!(running.len() > 19_000, "{}", running.len());
    assert!(running.iter().all(|cycle| cycle.trace.sensor_age == 0));
    assert!(
        running
            .windows(2)
            .all(|pair| { pair[1].inputs.sensor.counter > pair[0].inputs.sensor.counter })
    );
}
