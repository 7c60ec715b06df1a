//! Recordings that lack something: a clear answer, never a panic.

use super::synthetic::{Rig, TS, board_settings_toml};
use super::*;
use proptest::prelude::*;
use softdock_app::record::CycleRecord;
use softdock_control::io::Sequence;
use softdock_control::modes::Mode;

#[test]
fn without_contact_it_says_so() {
    let rig = Rig {
        walls: Vec::new(),
        ..Rig::default()
    };
    let comparison = compare(&rig.model(), &rig.record()).unwrap();
    assert!(comparison.at_noise, "{}", comparison.sentence);
    assert_eq!(comparison.contacts, 0);
    let notes = comparison.notes.join(" ");
    assert!(notes.contains("No contact was found"), "{notes}");
}

#[test]
fn too_few_cycles_are_refused_with_the_reason() {
    let rig = Rig::default();
    let mut recording = rig.record();
    recording.cut = Some("the last chunk is incomplete".to_owned());
    for cycles in [1, 0] {
        recording.cycles.truncate(cycles);
        let error = compare(&rig.model(), &recording).unwrap_err().to_string();
        assert!(
            error.contains(&format!("holds {cycles} cycle(s)")),
            "{error}"
        );
        assert!(error.contains("the last chunk is incomplete"), "{error}");
    }
}

#[test]
fn a_recording_cut_off_in_contact_is_compared_as_far_as_it_goes() {
    let rig = Rig::default();
    let mut recording = rig.record();
    let in_contact = recording
        .cycles
        .iter()
        .position(|c| c.trace.wrench_at_m[0] < -100.0)
        .unwrap();
    recording.cycles.truncate(in_contact + 5);
    recording.cut = Some("the last chunk is incomplete".to_owned());
    let comparison = compare(&rig.model(), &recording).unwrap();
    assert_eq!(comparison.contacts, 1);
    assert!(comparison.at_noise, "{}", comparison.sentence);
    assert!(comparison.notes[0].contains("cut off (the last chunk is incomplete)"));
}

#[test]
fn missing_cycles_and_lost_telegrams_are_no_error_of_the_model() {
    let rig = Rig {
        late_cycles: 8,
        ..Rig::default()
    };
    let mut recording = rig.record();
    recording.cycles.drain(400..420);
    let comparison = compare(&rig.model(), &recording).unwrap();
    assert!(comparison.at_noise, "{}", comparison.sentence);
    assert!(
        comparison
            .notes
            .iter()
            .any(|n| n.contains("missing in 1 place"))
    );
}

#[test]
fn a_log_without_settings_and_masses_says_what_is_missing() {
    let rig = Rig::default();
    let mut recording = rig.record();
    recording.header.settings_toml.clear();
    let comparison = compare(&rig.model(), &recording).unwrap();
    assert!(
        comparison
            .notes
            .iter()
            .any(|n| n.contains("[bodies.k] mass_kg"))
    );
    assert!(comparison.at_noise, "{}", comparison.sentence);
}

#[test]
fn unreadable_settings_and_a_standing_clock_are_errors() {
    let rig = Rig::default();
    let mut recording = rig.record();
    recording.header.settings_toml = "[control.robot]\ncycle_ms = 4".to_owned();
    let error = compare(&rig.model(), &recording).unwrap_err();
    assert!(format!("{error:#}").contains("cycle_ms"), "{error:#}");
    recording.header.settings_toml.clear();
    recording
        .cycles
        .iter_mut()
        .for_each(|c| c.trace.time_s = 0.0);
    let error = compare(&rig.model(), &recording).unwrap_err().to_string();
    assert!(error.contains("does not rise"), "{error}");
}

#[test]
fn numbers_that_are_none_are_left_out() {
    let rig = Rig::default();
    let mut recording = rig.record();
    for cycle in &mut recording.cycles[500..520] {
        cycle.trace.executed_velocity = [f64::NAN; 6];
        cycle.inputs.sensor.wrench = [f64::INFINITY; 6];
        cycle.trace.pose = [f64::NAN; 7];
        cycle.trace.model_velocity = [f64::NAN; 6];
        cycle.trace.sent_velocity = [f64::NAN; 6];
    }
    let comparison = compare(&rig.model(), &recording).unwrap();
    assert!(comparison.channels.iter().all(|c| c.rms.is_finite()));
}

#[test]
fn noise_that_is_written_too_large_is_pointed_out() {
    let rig = Rig::default();
    let recording = rig.record();
    let mut model = rig.model();
    let quiet = |model| {
        let notes = compare(model, &recording).unwrap().notes;
        !notes.iter().any(|n| n.contains("taken for noise"))
    };
    assert!(quiet(&model));
    model.noise.position_m = 2e-5;
    let notes = compare(&model, &recording).unwrap().notes.join(" ");
    assert!(notes.contains("noise.position_m"), "{notes}");
    assert!(!notes.contains("noise.force_n"), "{notes}");
}

fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![4 => -1.0..1.0f64, 1 => Just(0.0), 1 => Just(f64::NAN), 1 => any::<f64>()]
}

prop_compose! {
    fn any_cycle()(
        n in 0_u64..50,
        sequence in 0..4_u32,
        running in any::<bool>(),
        has_pose in any::<bool>(),
        counter in 0..3_u32,
        age in 0..40_u32,
        numbers in prop::collection::vec(any_number(), 40),
    ) -> CycleRecord {
        let mut cycle = CycleRecord::default();
        let six = |k: usize| -> [f64; 6] { std::array::from_fn(|i| numbers[k + i]) };
        cycle.inputs.robot.counter = n;
        cycle.inputs.robot.sequence = match sequence {
            0 => Sequence::NewRun,
            1 => Sequence::Gap(u32::MAX),
            _ => Sequence::Next,
        };
        cycle.inputs.robot.pose = has_pose.then_some([0.0; 6]);
        cycle.inputs.sensor.counter = counter;
        cycle.inputs.sensor.wrench = six(0);
        cycle.trace.cycle = n;
        cycle.trace.time_s = n as f64 * TS;
        cycle.trace.sensor_age = age;
        cycle.trace.mode = if running { Mode::Running } else { Mode::Hold };
        cycle.trace.executed_velocity = six(6);
        cycle.trace.sent_velocity = six(12);
        cycle.trace.model_velocity = six(18);
        cycle.trace.wrench_at_m = six(24);
        cycle.trace.pose = std::array::from_fn(|i| numbers[30 + i]);
        cycle
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn nonsense_never_panics(
        cycles in prop::collection::vec(any_cycle(), 0..60),
        with_settings in any::<bool>(),
    ) {
        let rig = Rig::default();
        let mut recording = Recording { cycles, ..Recording::default() };
        if with_settings {
            recording.header.settings_toml = board_settings_toml(&rig.settings());
        }
        if let Ok(comparison) = compare(&rig.model(), &recording) {
            let cycles: usize = comparison.phases.iter().map(|p| p.cycles).sum();
            prop_assert_eq!(cycles, recording.cycles.len());
            prop_assert!(serde_json::to_string(&comparison).is_ok());
        }
    }
}
