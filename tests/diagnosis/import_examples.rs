//! The mappings in `examples/` with the recordings that they are for.
//!
//! The data is not part of the project: `SOFTDOCK_DATA` names the folder that holds it.

use nalgebra::Vector3;
use softdock_analysis::import::mapping::import;
use softdock_app::record::CycleRecord;
use softdock_control::frames;
use softdock_tests::process::recorded_data;
use std::path::Path;

/// Rows and root mean squares of the examples, whose data is not part of the project.
#[test]
fn the_examples_import_as_their_origins_say() {
    let Some(data) = recorded_data("") else {
        return;
    };
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let logs = |data_name: &str, example: &str| {
        let mapping = examples.join(example).join("mapping.toml");
        let logs = import(&data.join(data_name), &mapping).unwrap();
        assert_eq!(logs.warnings, Vec::<String>::new(), "{example}");
        logs
    };
    let rms = |cycles: &[CycleRecord], value: &dyn Fn(&CycleRecord) -> f64| {
        let squares: f64 = cycles.iter().map(|c| value(c) * value(c)).sum();
        (squares / cycles.len() as f64).sqrt()
    };
    let force = |i: usize| move |c: &CycleRecord| c.inputs.sensor.wrench[i];

    let emps = logs("emps", "emps");
    let test = &emps.test[0];
    // 0.15 s less at each end, where the filter starts and stops.
    assert_eq!(
        (emps.train[0].cycles.len(), test.cycles.len()),
        (6135, 6135)
    );
    let received = rms(&emps.train[0].cycles, &force(0));
    assert!((received - 54.01).abs() < 0.05, "{received} N");

    let ati = logs("ft_gravity_ati", "ati-gravity");
    let [train, test] = [&ati.train[0].cycles, &ati.test[0].cycles];
    assert_eq!((train.len(), test.len()), (67, 33));
    // A weight of 12.15 N and this zero leave 0.287 N per axis of all 100 poses.
    let zero = Vector3::new(-3.46, -4.70, -16.68);
    let left = |c: &CycleRecord| {
        let [x, y, z, qw, qx, qy, qz] = c.trace.pose;
        let c_from_s = frames::pose::<f64>(&[x, y, z], &[qw, qx, qy, qz]).rotation;
        let weight = c_from_s.inverse() * Vector3::new(0.0, 0.0, -12.15);
        (Vector3::from_row_slice(&c.inputs.sensor.wrench[..3]) - weight - zero).norm()
    };
    let all: Vec<CycleRecord> = train.iter().chain(test).cloned().collect();
    let received = rms(&all, &left) / 3.0_f64.sqrt();
    assert!((received - 0.287).abs() < 0.001, "{received} N");

    let ur5 = &logs("ur_delay", "ur5-delay").train[0].cycles;
    assert_eq!(ur5.len(), 480);
    let error = |c: &CycleRecord| c.trace.sent_velocity[5] - c.trace.executed_velocity[5];
    // 0.44 s from the command on.
    let received = rms(&ur5[251..306], &error);
    assert!((received - 0.106).abs() < 0.001, "{received} rad/s");
}
