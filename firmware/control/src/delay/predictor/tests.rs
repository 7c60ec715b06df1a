//! The law between two walls.

use super::*;
use crate::delay::docking::{Docking, STIFFNESS, believed, between_walls, robot, walls};
use crate::delay::status::ConfidenceLevel;
use crate::delay::{Law, LawName};
use crate::modes::FaultCode;
use softdock_delay_plants::truth::Bounce;
use softdock_delay_plants::{
    Actuator, DelayChange, Dynamics, ForceLaw, Measurement, PlantSettings, Wall,
};

fn predictor(docking: &Docking) -> &Predictor {
    match &docking.law {
        Law::Predictor(law) => law,
        _ => panic!("another law"),
    }
}

fn observer(docking: &Docking) -> &Observer {
    predictor(docking).observer.as_ref().unwrap()
}

/// 36 cycles before its load is measured: the prediction horizon less the control horizon.
#[test]
fn a_contact_that_is_remembered_is_expected_before_it_is_felt() {
    let plant = between_walls(robot(), 0.0, Measurement::default());
    let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &plant, 0.005);
    docking.bounce();
    docking.bounce();
    let expected = LawFlags::MEMORY;
    let mut waited = 0;
    while !docking.status.flags.has(LawFlags::CONTACT) {
        waited += usize::from(docking.status.flags.has(expected));
        docking.step();
    }
    assert!((35..=37).contains(&waited), "{waited}");
}

#[test]
fn a_law_that_is_restarted_knows_nothing_of_the_robot() {
    let actuator = Actuator {
        delay_s: 0.036,
        ..robot()
    };
    let settings = believed(LawName::Predictor, &robot());
    let plant = between_walls(actuator, 0.0, Measurement::default());
    let mut docking = Docking::new(&settings, &plant, 0.005);
    docking.bounce();
    assert!((docking.status.delay_s - 0.036).abs() < 1e-4);
    docking
        .law
        .restart(&settings, crate::delay::spacecraft::CYCLE_S);
    docking.step();
    assert_eq!(docking.status.delay_s, 0.032);
    assert_eq!(docking.status.confidence, ConfidenceLevel::Unverified);
}

/// Asserts the identified stiffness and damping (N/m, N·s/m) to a fraction.
fn assert_found(docking: &Docking, damping: f64, part: f64) {
    let status = docking.status;
    assert!(
        (status.stiffness_n_per_m / STIFFNESS - 1.0).abs() < part,
        "{status:?}"
    );
    let apart = (status.damping_n_s_per_m - damping).abs();
    assert!(apart <= part * damping, "{status:?}");
    assert_eq!(status.confidence, ConfidenceLevel::Verified);
}

/// The robot is 32 ms late; without a law each contact would add half of the speed.
#[test]
fn elastic_contacts_give_back_the_speed_that_came() {
    let plant = between_walls(robot(), 0.0, Measurement::default());
    let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &plant, 0.005);
    for n in 0..4 {
        docking.seen = LawFlags::default();
        let restitution = docking.bounce();
        assert!((restitution - 1.0).abs() < 2e-4, "{n}: {restitution}");
        assert_found(&docking, 0.0, 2e-4);
        assert!(docking.status.misfit < 2e-3);
        assert_eq!(
            (docking.status.delay_s, docking.status.latency_cycles),
            (0.032, 0)
        );
        // A wall is remembered only after its first contact.
        assert_eq!(docking.seen.has(LawFlags::MEMORY), n >= 2);
        let others = docking.seen.without(LawFlags::MEMORY);
        assert_eq!(others, LawFlags::CONTACT, "{n}");
    }
    let half_a_period = core::f64::consts::PI / 21.0;
    for contact in &docking.plant.log().contacts {
        let duration = contact.duration_s().unwrap();
        assert!((duration / half_a_period - 1.0).abs() < 7e-3, "{duration}");
    }
}

#[test]
fn damped_contacts_give_back_what_the_damper_leaves() {
    let plant = between_walls(robot(), 2100.0, Measurement::default());
    let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &plant, 0.005);
    let expected = Bounce::new(500.0, STIFFNESS, 0.1, 0.005).restitution;
    for n in 0..4 {
        let restitution = docking.bounce();
        assert!(
            (restitution / expected - 1.0).abs() < 8e-3,
            "{n}: {restitution} {expected}"
        );
        assert_found(&docking, 2100.0, 2e-4);
    }
}

/// By then the robot's delay is known to a hundredth of a cycle.
#[test]
fn a_damping_is_found_in_noise() {
    let noise = Measurement {
        position_noise_m: 1e-6,
        force_noise_n: 0.05,
        ..Measurement::default()
    };
    let plant = between_walls(robot(), 2100.0, noise);
    let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &plant, 0.005);
    docking.bounce();
    assert_found(&docking, 2100.0, 0.05);
}

#[test]
fn noise_neither_opens_contacts_nor_adds_speed() {
    let noise = Measurement {
        position_noise_m: 5e-6,
        force_noise_n: 0.05,
        ..Measurement::default()
    };
    let mut docking = Docking::new(
        &believed(LawName::Predictor, &robot()),
        &between_walls(robot(), 0.0, noise),
        0.005,
    );
    docking.run(200);
    assert!(!docking.seen.has(LawFlags::CONTACT));
    assert_eq!(docking.speed(), 0.005);
    for n in 0..4 {
        let restitution = docking.bounce();
        assert!((restitution - 1.0).abs() < 1e-3, "{n}: {restitution}");
        assert_found(&docking, 0.0, 3e-3);
        assert!(docking.seen.has(LawFlags::DAMPING_IN_NOISE));
    }
}

/// The pose is two cycles older than the force.
#[test]
fn the_age_of_the_pose_is_found_in_the_first_contact() {
    let late = Measurement {
        pose_latency_cycles: 2,
        ..Measurement::default()
    };
    let mut docking = Docking::new(
        &believed(LawName::Predictor, &robot()),
        &between_walls(robot(), 0.0, late),
        0.005,
    );
    let restitution = docking.bounce();
    assert!((restitution - 1.0).abs() < 3e-3, "{restitution}");
    assert_eq!(docking.status.latency_cycles, 2);
    assert!((docking.status.delay_s - 0.032).abs() < 1e-6);
}

#[test]
fn a_robot_that_is_later_than_believed_is_noticed_on_the_approach() {
    for delay_s in [0.0372, 0.026, 0.044] {
        let actuator = Actuator { delay_s, ..robot() };
        let plant = between_walls(actuator, 0.0, Measurement::default());
        let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &plant, 0.005);
        docking.run(100);
        assert!(
            (docking.status.delay_s - delay_s).abs() < 1e-5,
            "{:?}",
            docking.status
        );
        let observer = observer(&docking);
        let apart =
            observer.robot.position[0] - docking.plant.log().moments[docking.cycle - 2].position[0];
        assert!(apart.abs() < 1e-9, "{apart}");
        let restitution = docking.bounce();
        assert!((restitution - 1.0).abs() < 2e-3, "{delay_s}: {restitution}");
    }
}

/// The wall is 1 mm away, reached in 0.26 s of the 0.35 s of an approach: the motion back from it must not be fitted as approach.
#[test]
fn a_contact_before_the_approach_is_over_ends_it() {
    let near = PlantSettings {
        contact: walls(&[0.001, -0.006], 0.0),
        ..between_walls(robot(), 0.0, Measurement::default())
    };
    let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &near, 0.005);
    for n in 0..3 {
        let restitution = docking.bounce();
        assert!((restitution - 1.0).abs() < 1e-3, "{n}: {restitution}");
        docking.run(60);
        assert!(
            (docking.status.delay_s - 0.032).abs() < 4e-4,
            "{n}: {:?}",
            docking.status
        );
        assert_eq!(docking.fault, None);
    }
}

#[test]
fn a_delay_that_changes_is_followed_from_contact_to_contact() {
    let change = DelayChange {
        at_s: 0.6,
        cycles: 2,
    };
    let actuator = Actuator {
        delay_change: Some(change),
        ..robot()
    };
    let plant = between_walls(actuator, 0.0, Measurement::default());
    let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &plant, 0.005);
    // Each contact corrects a part of the remaining error.
    let mut left = 0.008;
    for _ in 0..4 {
        docking.bounce();
        let apart = (docking.status.delay_s - 0.040).abs();
        assert!(apart < 0.6 * left, "{:?}", docking.status);
        left = apart;
    }
    assert!(docking.seen.has(LawFlags::DELAY_FOLLOWED));
}

#[test]
fn a_robot_that_is_none_of_those_believed_does_not_get_into_a_contact() {
    let servo = Dynamics::Servo {
        hz: 10.0,
        damping: 0.7,
    };
    for (delay_s, dynamics, at_bound) in [(0.0097, servo, false), (0.1, Dynamics::None, true)] {
        let actuator = Actuator {
            delay_s,
            dynamics,
            ..robot()
        };
        let plant = between_walls(actuator, 0.0, Measurement::default());
        let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &plant, 0.005);
        docking.run(150);
        let fault = docking.fault.expect("a fault");
        assert!(fault.received > fault.expected && fault.received == docking.status.misfit);
        // The limit, relative to the displacement in a delay, plus that of noise.
        let law = predictor(&docking);
        let model = &law.supervisor.model;
        let displacement = 0.005 * model.linear.mean_delay * model.cycle_s;
        let noise = law.supervisor.approach.findings.noise_m / displacement;
        assert!((fault.expected - 0.0035 - noise).abs() < 1e-9, "{fault:?}");
        assert_eq!(docking.seen.has(LawFlags::DELAY_AT_BOUND), at_bound);
        assert_eq!(docking.status.confidence, ConfidenceLevel::Unverified);
        assert_eq!(fault.code, FaultCode::ActuatorUnlike);
        let mut settings = believed(LawName::Predictor, &robot());
        settings.predictor.interlock = false;
        let mut docking = Docking::new(&settings, &plant, 0.005);
        docking.run(150);
        assert!(docking.fault.is_none());
        assert_eq!(docking.status.confidence, ConfidenceLevel::Unverified);
    }
}

/// Beyond by half a cycle; also with noise that allows as much misfit.
#[test]
fn a_robot_just_beyond_the_range_of_the_delay_is_refused_with_a_misfit_above_the_limit() {
    for position_noise_m in [0.0, 5e-6] {
        let actuator = Actuator {
            delay_s: 0.072 + 0.002,
            ..robot()
        };
        let measurement = Measurement {
            position_noise_m,
            ..Measurement::default()
        };
        let plant = between_walls(actuator, 0.0, measurement);
        let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &plant, 0.005);
        docking.run(150);
        let fault = docking.fault.expect("a fault");
        assert_eq!(fault.code, FaultCode::ActuatorUnlike);
        assert!(fault.received > fault.expected, "{fault:?}");
        assert!(docking.seen.has(LawFlags::DELAY_AT_BOUND));
    }
}

/// A push from behind by 5 N, and loads that are not significant.
#[test]
fn a_load_that_is_no_contact_moves_nothing() {
    for (force, spurious) in [(5.0, true), (0.005, false), (-0.005, false)] {
        let plant = between_walls(robot(), 0.0, Measurement::default());
        let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &plant, 0.005);
        docking.run(150);
        for _ in 0..10 {
            docking.sample.wrench[0] = force;
            docking.step();
        }
        assert_eq!(
            docking.seen.has(LawFlags::SPURIOUS_LOAD),
            spurious,
            "{force}"
        );
        assert!(!docking.seen.has(LawFlags::CONTACT));
        assert_eq!(docking.speed(), 0.005);
    }
}

/// A load that grows with the square of the depth.
#[test]
fn a_contact_that_is_not_understood_is_kept_passive_and_the_next_led_by_the_fallback() {
    let law = ForceLaw {
        exponent: 2.0,
        ..ForceLaw::linear(STIFFNESS / 2.4e-4, 0.0)
    };
    let wall = |x: f64| Wall {
        point: [x, 0.0, 0.0],
        normal: [-x.signum(), 0.0, 0.0],
        law,
    };
    for guard in [true, false] {
        let mut plant = between_walls(robot(), 0.0, Measurement::default());
        plant.contact.surfaces = [0.0045, -0.003].map(|x| wall(x).into()).to_vec();
        let mut settings = believed(LawName::Predictor, &robot());
        settings.predictor.guard = guard;
        let mut docking = Docking::new(&settings, &plant, 0.005);
        for n in 0..3 {
            docking.seen = LawFlags::default();
            let restitution = docking.bounce();
            assert_eq!(docking.status.confidence, ConfidenceLevel::Fallback);
            assert_eq!(docking.seen.has(LawFlags::GUARD_PASSIVE), guard);
            // A robot that is led by the model's acceleration alone comes back too fast.
            let speed = if guard { 1.0..=1.0 } else { 1.005..=1.5 };
            assert!(speed.contains(&restitution), "{guard} {n}: {restitution}");
            // The robot was not at the model's position; from now on the model is at the robot's.
            let observer = observer(&docking);
            let apart = observer.model - observer.robot.position;
            assert!(n == 0 || apart[0].abs() < 2e-4, "{n}: {apart}");
            assert!(!docking.seen.has(LawFlags::MEMORY));
        }
    }
}
