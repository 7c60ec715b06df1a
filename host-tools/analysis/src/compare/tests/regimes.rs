//! Regimes, tests against noise, and the noise floor, where the answer is known.

use super::synthetic::Rig;
use super::*;

fn tests(comparison: &Comparison, channel: Channel, axis: Axis) -> &ResidualTests {
    let mut tests = comparison.tests.iter();
    tests
        .find(|t| t.channel == channel && t.axis == axis)
        .unwrap()
}

#[test]
fn a_right_model_leaves_no_regime_and_passes_every_test() {
    let rig = Rig::default();
    let comparison = compare(&rig.model(), &rig.record()).unwrap();
    assert_eq!(comparison.regimes, vec![]);
    assert_eq!(comparison.tests.len(), comparison.channels.len());
    for test in &comparison.tests {
        assert!(test.whiteness.white, "{test:?}");
        assert!(test.independence.iter().all(|i| i.independent), "{test:?}");
    }
    assert_eq!(comparison.noise.len(), 18);
    for level in &comparison.noise {
        assert_eq!(level.verdict, NoiseVerdict::AsDataSheet, "{level:?}");
        assert!((0.8..1.25).contains(&level.ratio), "{level:?}");
    }
}

#[test]
fn the_error_of_a_late_robot_follows_its_acceleration() {
    let comparison = with_a_late_robot();
    let regime = comparison.failures[0].regime.as_ref().unwrap();
    assert_eq!(regime.variable, Quantity::Acceleration);
    assert_eq!(regime.along, Some(Axis::X));
    assert!(regime.significant && regime.share > 0.4, "{regime:?}");
    let x = tests(&comparison, Channel::ExecutedVelocity, Axis::X);
    assert!(!x.whiteness.white && x.whiteness.statistic > 1000.0);
    assert!(!x.independence.iter().all(|i| i.independent), "{x:?}");
    let y = tests(&comparison, Channel::ExecutedVelocity, Axis::Y);
    assert!(y.whiteness.white, "{y:?}");
}

#[test]
fn a_wrong_stiffness_follows_the_load_in_contact() {
    let comparison = with_a_soft_wall();
    let regime = comparison.failures[0].regime.as_ref().unwrap();
    let of_contact = [Quantity::Force, Quantity::Position];
    assert!(of_contact.contains(&regime.variable), "{regime:?}");
    assert_eq!(regime.along, Some(Axis::X));
    assert!(regime.share > 0.9, "{regime:?}");
    let shares: f64 = regime.bins.iter().map(|b| b.share).sum();
    assert!((shares - 1.0).abs() < 0.1, "{shares}");
    let cycles: usize = regime.bins.iter().map(|b| b.cycles).sum();
    assert!(cycles <= comparison.cycles);
    let of_wrench_x = |r: &&Regime| r.channel == Channel::Wrench && r.axis == Axis::X;
    let kinds = comparison.regimes.iter().filter(of_wrench_x).count();
    assert!(kinds >= 6, "{kinds} quantities were tried");
}

#[test]
fn an_offset_is_no_regime() {
    let comparison = with_a_shifted_zero();
    assert_eq!(comparison.failures[0].regime, None);
    let best = &comparison.regimes[0];
    assert!(best.offset_share > 0.95, "{best:?}");
    assert!((best.offset - 2.0).abs() < 0.1, "{best:?}");
}

#[test]
fn a_recording_that_is_noisier_than_the_data_sheet_says_so() {
    let rig = Rig::default();
    let recording = rig.record();
    let mut model = rig.model();
    model.noise.position_m *= 1e-3;
    let comparison = compare(&model, &recording).unwrap();
    let notes = comparison.notes.join(" ");
    assert!(notes.contains("noise.position_m"), "{notes}");
    assert!(notes.contains("millimetres for metres"), "{notes}");
    let of_pose = |n: &&NoiseLevel| n.channel == Channel::Pose && !n.axis.is_rotation();
    let mut pose = comparison.noise.iter().filter(of_pose);
    assert!(pose.all(|n| n.verdict == NoiseVerdict::Noisier && n.ratio > 800.0));
}

#[test]
fn a_coarse_sensor_is_seen_as_one() {
    let rig = Rig::default();
    let mut recording = rig.record();
    for cycle in &mut recording.cycles {
        for value in &mut cycle.inputs.sensor.wrench[..3] {
            *value = (*value / 5.0).round() * 5.0;
        }
    }
    let comparison = compare(&rig.model(), &recording).unwrap();
    let of_x = |n: &&NoiseLevel| n.channel == Channel::Wrench && n.axis == Axis::X;
    let level = comparison.noise.iter().find(of_x).unwrap();
    assert_eq!(level.verdict, NoiseVerdict::Coarse);
    assert!((level.step.unwrap() - 5.0).abs() < 1e-9);
    let notes = comparison.notes.join(" ");
    assert!(notes.contains("comes in steps of 5.00 N"), "{notes}");
}
