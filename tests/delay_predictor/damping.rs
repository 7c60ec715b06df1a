//! Damped contacts: no outliers over fifty phases of the onset within a cycle.

use super::case::{Case, LAG, MIXED, SERVO, SLOW_SERVO, onset_phases, pausing, worst};

#[test]
fn fifty_phases_in_scenario_s() {
    // At ζ = 0.5 the bound of the dead time is reached where the onset lies just after a sample: there the
    // guard acts.
    for (zeta, bound) in [
        (0.1, 0.001),
        (0.2, 0.004),
        (0.3, 0.0015),
        (0.4, 0.0015),
        (0.5, 0.012),
    ] {
        let cases = onset_phases(50).map(|onset_phase| Case {
            zeta,
            onset_phase,
            ..Case::default()
        });
        assert!(worst(&format!("S, damping {zeta}"), cases) <= bound);
    }
}

#[test]
fn other_robots() {
    for (name, robot) in [
        ("mixed", MIXED),
        ("lag", LAG),
        ("servo", SERVO),
        ("slow servo", SLOW_SERVO),
    ] {
        for zeta in [0.1, 0.3, 0.5] {
            let robot = pausing(robot);
            let cases = onset_phases(6).map(|onset_phase| Case {
                robot,
                believed: robot,
                zeta,
                onset_phase,
                ..Case::default()
            });
            assert!(worst(&format!("{name}, damping {zeta}"), cases) <= 0.02);
        }
    }
}
