//! A simulated mass that is driven by the measured force, without compensation: the energy that a late robot adds when it is
//! sent the mean velocity of each cycle. For both formulations, averaged over instants of the touch within a cycle.

use softdock_delay_plants::{Actuator, Contact, Dynamics, Formulation, Plant, PlantSettings, Wall};

const CYCLE_S: f64 = 0.004;
const MASS_KG: f64 = 500.0;
const SPEED_M_S: f64 = 0.005;

/// Speed after over speed before, mean over four instants of the touch within a cycle.
fn restitution(actuator: Actuator, omega: f64, formulation: Formulation) -> f64 {
    let places = 4;
    let sum: f64 = (0..places)
        .map(|n| {
            let place = f64::from(n) / f64::from(places);
            let distance = SPEED_M_S * (0.1 + place * CYCLE_S);
            bounce(actuator, omega, distance, formulation)
        })
        .sum();
    sum / f64::from(places)
}

fn bounce(actuator: Actuator, omega: f64, distance_m: f64, formulation: Formulation) -> f64 {
    let stiffness = MASS_KG * omega * omega;
    let wall = Wall::elastic([distance_m, 0.0, 0.0], [-1.0, 0.0, 0.0], stiffness);
    let mut plant = Plant::new(&PlantSettings {
        actuator,
        formulation,
        contact: Contact {
            probes: vec![[0.0; 3]],
            surfaces: vec![wall.into()],
        },
        ..PlantSettings::default()
    });
    let (mut v, mut mean) = (SPEED_M_S, SPEED_M_S);
    for _ in 0..300 {
        let sample = plant.step([mean, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let next = v + sample.wrench[0] / MASS_KG * CYCLE_S;
        (v, mean) = (next, 0.5 * (v + next));
    }
    assert!(plant.log().contacts[0].release_s.is_some());
    -v / SPEED_M_S
}

const PURE: Actuator = Actuator {
    delay_s: 0.032,
    ..Actuator::ideal()
};
const MIXED: Actuator = Actuator {
    delay_s: 0.016,
    dynamics: Dynamics::Lag {
        time_constant_s: 0.016,
    },
    ..Actuator::ideal()
};
const LAG: Actuator = Actuator {
    dynamics: Dynamics::Lag {
        time_constant_s: 0.032,
    },
    ..Actuator::ideal()
};

/// Known values from an earlier simulation with steps of 0.5 ms, at φ = ω · 32 ms.
#[test]
fn energy_of_a_late_robot() {
    let known = [
        (0.32, [1.68, 1.66, 1.61]),
        (0.64, [2.63, 2.51, 2.26]),
        (0.96, [3.80, 3.47, 2.86]),
    ];
    for (phi, values) in known {
        for (actuator, value) in [PURE, MIXED, LAG].into_iter().zip(values) {
            let e = restitution(actuator, phi / 0.032, Formulation::Exact);
            let again = restitution(actuator, phi / 0.032, Formulation::FixedSteps);
            assert!((e / value - 1.0).abs() < 0.01, "{phi}: {e}, known {value}");
            assert!((e - again).abs() < 1e-3, "{phi}: {e}, {again}");
        }
    }
}

/// The scenario of all tables: 21 rad/s, 32 ms, standstill of 16 ms.
#[test]
fn energy_of_delay_and_pause() {
    let actuator = Actuator {
        pause_s: 0.016,
        ..PURE
    };
    let e = restitution(actuator, 21.0, Formulation::Exact);
    let again = restitution(actuator, 21.0, Formulation::FixedSteps);
    assert!((e - 2.81).abs() < 0.03, "{e}");
    assert!((e - again).abs() < 2e-3, "{e}, {again}");
}
