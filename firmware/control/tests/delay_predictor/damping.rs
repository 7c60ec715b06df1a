//! Damped contacts: no outliers over fifty places of the touch within a cycle.

use crate::case::{Case, LAG, MIXED, SERVO, SLOW_SERVO, pausing, places, worst};

#[test]
fn fifty_places_in_scenario_s() {
    // At ζ = 0.5 the bound of the dead time is reached where the touch lies just after a sample: there the
    // guard acts.
    for zeta in [0.1, 0.2, 0.3, 0.4, 0.5] {
        let cases = places(50).map(|place| Case {
            zeta,
            place,
            ..Case::default()
        });
        assert!(worst(&format!("S, damping {zeta}"), cases) <= 0.02);
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
            let cases = places(6).map(|place| Case {
                robot,
                believed: robot,
                zeta,
                place,
                ..Case::default()
            });
            assert!(worst(&format!("{name}, damping {zeta}"), cases) <= 0.02);
        }
    }
}
