//! Tests with known answers: recordings of a synthetic rig, compared with models that are right or have one error.

mod regimes;
mod robustness;
mod synthetic;

use super::*;
use nalgebra::Vector3;
use synthetic::Rig;

fn channel(comparison: &Comparison, name: Channel, axis: Axis) -> &ChannelError {
    comparison
        .channels
        .iter()
        .find(|c| c.name == name && c.axis == axis)
        .unwrap()
}

fn phase(comparison: &Comparison, name: Phase) -> &PhaseError {
    comparison.phases.iter().find(|p| p.name == name).unwrap()
}

/// The rig's recording against its model, in which something is made wrong.
fn compared(rig: &Rig, spoil: impl FnOnce(&mut Model)) -> Comparison {
    let mut model = rig.model();
    spoil(&mut model);
    compare(&model, &rig.record()).unwrap()
}

/// The robot is 32 ms late, and the model has no delay.
fn with_a_late_robot() -> Comparison {
    let rig = Rig {
        late_cycles: 8,
        ..Rig::default()
    };
    compared(&rig, |model| model.actuator.transport_delay_s = 0.0)
}

fn with_a_soft_wall() -> Comparison {
    compared(&Rig::default(), |model| {
        model.contact.walls[0].stiffness_n_per_m *= 0.8;
    })
}

fn with_a_shifted_zero() -> Comparison {
    compared(&Rig::default(), |model| model.sensor.bias[2] -= 2.0)
}

#[test]
fn a_right_model_leaves_the_noise() {
    for late_cycles in [0, 3] {
        let rig = Rig {
            late_cycles,
            ..Rig::default()
        };
        let comparison = compare(&rig.model(), &rig.record()).unwrap();
        assert!(comparison.at_noise, "{}", comparison.sentence);
        assert!(comparison.sentence.contains("at the noise"));
        assert_eq!(comparison.contacts, 1);
        for name in [Channel::ExecutedVelocity, Channel::Wrench] {
            for axis in Axis::ALL {
                let error = channel(&comparison, name, axis);
                let sigma = error.rms_expected_sigma;
                assert!((0.9..1.1).contains(&sigma), "{name} {axis}: {sigma}");
            }
        }
        for error in comparison
            .channels
            .iter()
            .filter(|c| c.name == Channel::ModelVelocity)
        {
            assert!(error.rms < 1e-12, "{error:?}");
        }
    }
}

#[test]
fn a_late_robot_fails_around_the_contact_and_is_timed() {
    let comparison = with_a_late_robot();
    let worst = &comparison.failures[0];
    assert_eq!(
        (worst.channel, worst.axis),
        (Channel::ExecutedVelocity, Axis::X)
    );
    assert_eq!(comparison.failures.len(), 1, "{}", comparison.sentence);
    let free = phase(&comparison, Phase::FreeFlight);
    assert!(free.share_beyond_noise < 0.02, "{free:?}");
    let around: f64 = [
        Phase::FirstContact,
        Phase::TurningPoint,
        Phase::ZeroCrossing,
        Phase::Rebound,
    ]
    .map(|p| phase(&comparison, p).share_beyond_noise)
    .iter()
    .sum();
    assert!(around > 0.98);
    let Some(Explanation::Late(late)) = worst.explanation else {
        panic!("{:?}", worst.explanation);
    };
    assert!(late.low < 0.032 && 0.032 < late.high, "{late:?}");
    assert!(late.high - late.low < 0.004, "{late:?}");
    assert!(
        comparison.sentence.contains("the robot is 32"),
        "{}",
        comparison.sentence
    );
    assert!(comparison.sentence.contains("behind the command there"));
}

#[test]
fn a_pause_fails_at_the_zero_crossing_and_nowhere_else() {
    let rig = Rig {
        pause_cycles: 8,
        ..Rig::default()
    };
    let comparison = compare(&rig.model(), &rig.record()).unwrap();
    let worst = &comparison.failures[0];
    assert_eq!(
        (worst.channel, worst.axis),
        (Channel::ExecutedVelocity, Axis::X)
    );
    let crossing = phase(&comparison, Phase::ZeroCrossing);
    assert!(crossing.share_beyond_noise > 0.9, "{crossing:?}");
    assert!(
        comparison.sentence.contains("stands in zero crossing"),
        "{}",
        comparison.sentence
    );
}

#[test]
fn a_wrong_stiffness_fails_in_the_wrench_by_its_factor() {
    let comparison = with_a_soft_wall();
    let worst = &comparison.failures[0];
    assert_eq!((worst.channel, worst.axis), (Channel::Wrench, Axis::X));
    assert_eq!(comparison.failures.len(), 1, "{}", comparison.sentence);
    assert_eq!(
        phase(&comparison, Phase::FreeFlight).share_beyond_noise,
        0.0
    );
    let Some(Explanation::Factor(factor)) = worst.explanation else {
        panic!("{:?}", worst.explanation);
    };
    assert!(factor.low < 1.25 && 1.25 < factor.high, "{factor:?}");
}

#[test]
fn a_shifted_zero_is_an_offset_everywhere() {
    let comparison = with_a_shifted_zero();
    let worst = &comparison.failures[0];
    assert_eq!((worst.channel, worst.axis), (Channel::Wrench, Axis::Z));
    let Some(Explanation::Offset(offset)) = worst.explanation else {
        panic!("{:?}", worst.explanation);
    };
    assert!(offset.low < 2.0 && 2.0 < offset.high, "{offset:?}");
    assert!(
        comparison.sentence.contains("spread over the recording"),
        "{}",
        comparison.sentence
    );
}

#[test]
fn a_wrong_mass_fails_in_the_model_velocity() {
    let comparison = compared(&Rig::default(), |model| {
        model.bodies.k.mass_kg = Some(400.0)
    });
    let worst = &comparison.failures[0];
    assert_eq!(worst.channel, Channel::ModelVelocity);
    let Some(Explanation::Factor(factor)) = worst.explanation else {
        panic!("{:?}", worst.explanation);
    };
    // The rig integrates with 500 kg: 0.8 times the change that 400 kg would have.
    assert!((factor.value - 0.8).abs() < 1e-6, "{factor:?}");
}

#[test]
fn many_bounces_in_any_direction_are_all_found() {
    let along = Vector3::new(1.0, -2.0, 2.0) / 3.0;
    let rig = Rig {
        walls: vec![(along, 0.02), (-along, 0.02)],
        velocity_m_s: (along * 0.03).into(),
        seconds: 8.2,
        late_cycles: 1,
        ..Rig::default()
    };
    let recording = rig.record();
    let comparison = compare(&rig.model(), &recording).unwrap();
    assert!(comparison.at_noise, "{}", comparison.sentence);
    let speeds: Vec<f64> = recording
        .cycles
        .iter()
        .map(|c| Vector3::from_row_slice(&c.trace.model_velocity[..3]).dot(&along))
        .collect();
    let reversals = speeds.windows(2).filter(|v| v[0] * v[1] < 0.0).count();
    assert!(reversals > 5, "{reversals}");
    assert_eq!(comparison.contacts, reversals);
    for part in &comparison.phases {
        assert!(part.cycles > 0, "{part:?}");
    }
    for name in [Phase::TurningPoint, Phase::ZeroCrossing] {
        let windows = phase(&comparison, name).windows.len();
        assert!(windows >= comparison.contacts, "{name:?} {windows}");
    }
    let cycles: usize = comparison.phases.iter().map(|p| p.cycles).sum();
    assert_eq!(cycles, comparison.cycles);
    let shares: f64 = comparison.phases.iter().map(|p| p.share).sum();
    assert!((shares - 1.0).abs() < 1e-12);
}

#[test]
fn the_json_has_the_keys_that_programs_rely_on() {
    let rig = Rig::default();
    let comparison = compare(&rig.model(), &rig.record()).unwrap();
    let json = serde_json::to_value(&comparison).unwrap();
    assert_eq!(json["where"], comparison.sentence);
    let first = &json["channels"][0];
    assert_eq!(
        (&first["name"], &first["axis"]),
        (&"executed_velocity".into(), &"x".into())
    );
    assert_eq!(first["unit"], "m/s");
    assert!(first["rms"].is_f64() && first["rms_sigma"].is_f64());
    assert_eq!(json["phases"][3]["name"], "zero_crossing");
    assert!(json["phases"][3]["share"].is_f64());
    assert_eq!(json["channels"].as_array().unwrap().len(), 24);
    let test = &json["tests"][0];
    assert_eq!(test["channel"], "executed_velocity");
    assert!(test["whiteness"]["statistic"].is_f64() && test["whiteness"]["white"].is_boolean());
    assert_eq!(test["independence"][0]["input"], "sent_velocity");
    let noise = &json["noise"][0];
    assert!(noise["measured"].is_f64() && noise["data_sheet"].is_f64());
    assert_eq!(noise["verdict"], "as_data_sheet");
}

#[test]
fn tables_show_the_finding() {
    let comparison = with_a_late_robot();
    let tables = comparison.tables();
    assert!(tables[0].to_string().contains("executed_velocity"));
    assert!(tables[1].to_string().contains("zero crossing"));
}
