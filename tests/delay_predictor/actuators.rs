//! Robots of other structure: known, and believed wrongly on purpose.

use super::case::{Case, LAG, MIXED, PURE, SERVO, SLOW_SERVO, onset_phases, pausing, worst};
use softdock_control::modes::FaultCode;
use softdock_delay_plants::Actuator;

const ROBOTS: [(&str, Actuator, f64); 5] = [
    ("pure", PURE, 0.002),
    ("mixed", MIXED, 0.005),
    ("lag", LAG, 0.005),
    ("servo", SERVO, 0.005),
    ("slow servo", SLOW_SERVO, 0.01),
];

#[test]
fn a_known_structure_is_as_good_as_a_pure_delay() {
    for (name, robot, bound) in ROBOTS {
        for robot in [robot, pausing(robot)] {
            let cases = [0.001, 0.005, 0.015].into_iter().flat_map(|speed_m_s| {
                onset_phases(3).map(move |onset_phase| Case {
                    robot,
                    believed: robot,
                    speed_m_s,
                    onset_phase,
                    ..Case::default()
                })
            });
            let name = format!("{name}, pause {}", robot.pause_s);
            assert!(worst(&name, cases) <= bound);
        }
    }
}

fn pairs() -> impl Iterator<Item = (&'static str, &'static str, Case)> {
    let all = ROBOTS
        .iter()
        .flat_map(|robot| ROBOTS.iter().map(move |believed| (robot, believed)));
    all.filter(|(robot, believed)| robot.0 != believed.0)
        .map(|(robot, believed)| {
            let case = Case {
                robot: pausing(robot.1),
                believed: pausing(believed.1),
                ..Case::default()
            };
            (robot.0, believed.0, case)
        })
}

/// No pair gains speed once the guard has acted.
#[test]
fn a_wrong_structure_does_not_diverge() {
    for (robot, believed, case) in pairs() {
        for onset_phase in onset_phases(3) {
            let outcome = Case {
                interlock: false,
                onset_phase,
                ..case.clone()
            }
            .fly();
            let e = outcome.restitution;
            println!(
                "{robot} believed {believed}: {e:.4}, guard {}",
                outcome.run.guarded()
            );
            assert!(
                (0.0..=1.02).contains(&e),
                "{robot} believed {believed}: {e}"
            );
        }
    }
}

#[test]
fn a_wrong_structure_is_not_let_into_a_contact() {
    for (robot, believed, case) in pairs() {
        let outcome = case.fly();
        let fault = outcome.run.records.last().and_then(|r| r.trace.fault);
        let code = fault.map(|fault| fault.code);
        assert_eq!(code, Some(FaultCode::ActuatorUnlike), "{robot} {believed}");
        assert!(outcome.run.log.contacts.is_empty());
    }
}
