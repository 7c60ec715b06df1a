//! Contacts again and again between two walls: noise does not add up, contacts are remembered.

use super::case::{Case, MASS_KG, OMEGA, PURE, noise, pausing};
use super::run::{Run, run};
use softdock_control::delay::status::LawFlags;
use softdock_delay_plants::{Actuator, ForceLaw, Measurement, Wall};
use softdock_experiments::bench::delay::case::belief;

/// Bounces between two walls; the first is as far as in [`Case`].
pub(crate) fn between_walls(robot: Actuator, omega: f64, measurement: Measurement) -> Run {
    let believed = Actuator {
        delay_s: PURE.delay_s,
        ..robot
    };
    between(robot, believed, omega, measurement)
}

/// The same with something else believed of the robot.
pub(crate) fn between(
    robot: Actuator,
    believed: Actuator,
    omega: f64,
    measurement: Measurement,
) -> Run {
    let case = Case {
        robot,
        omega,
        measurement,
        ..Case::default()
    };
    let mut plant = case.plant();
    let back = Wall {
        point: [-0.6 * case.speed_m_s, 0.0, 0.0],
        normal: [1.0, 0.0, 0.0],
        law: ForceLaw::linear(MASS_KG * omega * omega, 0.0),
    };
    plant.contact.surfaces.push(back.into());
    let mut settings = case.settings();
    settings.delay.actuator = belief(&believed);
    run(&settings, &plant, 15.5)
}

/// Speed of the model between the contacts, in units of the first.
pub(crate) fn speeds(run: &Run) -> Vec<f64> {
    let speed = |cycle: usize| run.records[cycle].trace.body_k.velocity[0].abs();
    let contact = |cycle: usize| {
        let flags = run.records[cycle].trace.law_status.flags;
        flags.has(LawFlags::CONTACT)
    };
    let ends = (1..run.records.len()).filter(|n| contact(n - 1) && !contact(*n));
    ends.map(|n| speed(n) / speed(0)).collect()
}

#[test]
fn ten_bounces() {
    for (name, robot, measurement, bound) in [
        ("quiet", pausing(PURE), noise(0.0, 0.0), 0.005),
        // Each contact's impulse has a noise of 0.3 % of the momentum that the last commands cannot
        // reach any more; left alone, ten of them would make 1 %.
        ("0.5 N", pausing(PURE), noise(0.5, 0.0), 0.005),
        (
            "40 ms",
            Actuator {
                delay_s: 0.040,
                ..pausing(PURE)
            },
            noise(0.0, 0.0),
            0.005,
        ),
    ] {
        let run = between_walls(robot, OMEGA, measurement);
        let speeds = speeds(&run);
        println!("{name}: {speeds:.4?}");
        assert!(speeds.len() >= 9, "{name}: {} contacts", speeds.len());
        assert!(speeds.iter().all(|v| (v - 1.0).abs() <= bound), "{name}");
        // Noise may give a contact more than the guard lets through.
        let noisy = measurement != noise(0.0, 0.0);
        assert!(noisy || !run.guarded(), "{name}");
    }
}

/// From the second contact with each wall on, the robot turns before it feels anything.
#[test]
fn remembered_contacts_may_be_stiff() {
    for (phase, pause_s) in [(1.2, 0.016), (1.6, 0.016), (1.9, 0.0)] {
        let robot = Actuator { pause_s, ..PURE };
        let run = between_walls(robot, phase / 0.032, noise(0.0, 0.0));
        let speeds = speeds(&run);
        println!("phase {phase}, pause {pause_s}: {speeds:.4?}");
        assert!(speeds.len() >= 8);
        for pair in speeds[1..].windows(2) {
            assert!((pair[1] / pair[0] - 1.0).abs() <= 0.015, "{pair:?}");
        }
        let peak = |contact: usize| run.log.contacts[contact].peak_force_n;
        assert!(peak(3) < 0.85 * peak(0), "{} {}", peak(3), peak(0));
    }
}
