//! Complete logs with any number in any place: every evaluation of a recording returns a result or an error.

use super::Script;
use softdock_analysis::compare::compare;
use softdock_app::record::CycleRecord;
use softdock_control::modes::Command;
use softdock_experiments::run::record;
use softdock_experiments::scenario::Scenario;
use softdock_io::recording::Recording;
use softdock_io::replay::replay;
use softdock_physics::model::Model;
use std::sync::LazyLock;

/// Half a second of flight and contact.
static LOG: LazyLock<Recording> = LazyLock::new(|| {
    let mut scenario = Scenario::spring_rod().unwrap();
    scenario.duration_s = 0.5;
    scenario.rig.mechanism.walls[0].point_m[0] = scenario.start_position_m[0] + 1e-3;
    record(&scenario).unwrap().0
});

pub(super) fn log(input: &[u8]) {
    let mut log = LOG.clone();
    let mut script = Script(input);
    while let Some(place) = script.byte() {
        let cycles = log.cycles.len();
        match log.cycles.get_mut(usize::from(place)) {
            Some(cycle) => change(cycle, &mut script),
            None if place % 2 == 0 => log.cycles.truncate(usize::from(place) / 2),
            None => log.cycles.rotate_left(cycles.min(1)),
        }
    }
    log.truth.clear();
    let untouched = input.is_empty();
    let replayed = replay(&log).is_ok_and(|report| report.identical);
    assert!(replayed || !untouched, "a log is what the firmware did");
    let compared = compare(&Model::default(), &log);
    assert!(compared.is_ok() || !untouched);
}

/// Changes the value of one quantity.
fn change(cycle: &mut CycleRecord, script: &mut Script<'_>) {
    let CycleRecord { inputs, trace, .. } = cycle;
    let (event, axis) = (script.byte().unwrap_or_default(), script.byte());
    let axis = usize::from(axis.unwrap_or_default()) % 6;
    match event % 12 {
        0 => inputs.sensor.wrench[axis] = script.number(10.0),
        1 => trace.wrench_at_m[axis] = script.number(10.0),
        2 => trace.executed_velocity[axis] = script.number(1e-3),
        3 => trace.model_velocity[axis] = script.number(1e-3),
        4 => trace.sent_velocity[axis] = script.number(1e-3),
        5 => trace.pose[axis] = script.number(1e-3),
        6 => trace.time_s = script.number(4e-3),
        7 => trace.cycle = u64::from_le_bytes(script.bytes()),
        8 => inputs.sensor.counter = u32::from_le_bytes(script.bytes()),
        9 => inputs.robot.pose = script.byte().map(|_| [script.number(0.1); 6]),
        10 => inputs.command = Some(script.choose(&Command::WORDS).1),
        _ => trace.body_k.velocity[axis] = script.number(1e-3),
    }
}
