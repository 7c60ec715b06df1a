//! Contacts of other stiffness, mass and damping, and of other force laws than a linear spring.

use super::super::case::{Case, Robot};
use super::super::scene::{End, MASS_KG, OMEGA_RAD_S, Scene, Shape};

pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for factor in [0.3, 0.5, 2.0, 3.0, 5.0] {
        let mut case = Case::new("stiffness", format!("stiffness_x{factor}"));
        case.scene.law.stiffness *= factor;
        case.quick = factor == 0.3 || factor == 2.0;
        cases.push(case);
    }
    for factor in [0.25, 0.5, 2.0, 4.0] {
        let mut case = Case::new("mass", format!("mass_x{factor}"));
        case.scene.mass_kg *= factor;
        cases.push(case);
    }
    cases.extend(phases());
    cases.extend(dampings());
    cases.extend(power_laws());
    cases.extend(as_commissioned());
    cases.push(ten_bounces());
    cases
}

/// Stiffer and stiffening contacts, with the feedback latency as commissioning leaves it: set to 0, but not known to be 0.
fn as_commissioned() -> Vec<Case> {
    let stiffer = [2.0, 3.0].map(|factor| {
        let mut case = Case::new("as_commissioned", format!("stiffness_x{factor}_unknown"));
        case.scene.law.stiffness *= factor;
        case
    });
    let stiffening = power_laws().into_iter().map(|mut case| {
        (case.sweep, case.name) = ("as_commissioned", format!("{}_unknown", case.name));
        case
    });
    let mut cases: Vec<Case> = stiffer.into_iter().chain(stiffening).collect();
    for case in &mut cases {
        case.believed.feedback_latency_known = false;
    }
    cases
}

/// φ = ω · 32 ms, without a pause: the largest phase at which a law can master a first contact.
fn phases() -> Vec<Case> {
    [0.8, 0.96, 1.12, 1.28]
        .map(|phi: f64| {
            let mut case = Case::new("phi", format!("phi_{phi}"));
            let omega = phi / 0.032;
            case.scene.law.stiffness = MASS_KG * omega * omega;
            case.robot.actuator.pause_s = 0.0;
            case.believed.pause_s = 0.0;
            case
        })
        .into()
}

/// Damping ratios, each with a pause of 16 ms and without.
fn dampings() -> Vec<Case> {
    let mut cases = Vec::new();
    for zeta in [0.1, 0.2, 0.3, 0.4, 0.5, 0.6] {
        let mut case = Case::new("damping", format!("damping_{zeta}"));
        case.scene = case.scene.damped(zeta);
        case.quick = zeta == 0.1 || zeta == 0.3;
        let mut without = Case::new("damping_no_pause", format!("damping_{zeta}_no_pause"));
        without.scene = case.scene.clone();
        without.robot.actuator.pause_s = 0.0;
        without.believed.pause_s = 0.0;
        let mut mixed = Case::new("damping_mixed", format!("damping_{zeta}_mixed"));
        mixed = mixed.with_robot(Robot::MIXED);
        mixed.scene = case.scene.clone();
        cases.extend([case, without, mixed]);
    }
    cases
}

/// Contacts with the force k depth^p whose peak force is that of the canonical contact at 5 mm/s.
fn power_laws() -> Vec<Case> {
    [1.3, 1.5]
        .map(|exponent: f64| {
            let mut case = Case::new("power_law", format!("power_law_{exponent}"));
            // ∫ k x^p dx up to the depth d is m v²/2, and k d^p the peak force.
            let (speed, force) = (0.005, 0.005 * OMEGA_RAD_S * MASS_KG);
            let depth = (exponent + 1.0) * 0.5 * MASS_KG * speed * speed / force;
            case.scene.law.stiffness = force / depth.powf(exponent);
            case.scene.law.exponent = exponent;
            case
        })
        .into()
}

/// Ten bounces between two walls, with 0.5 N of noise.
fn ten_bounces() -> Case {
    let mut case = Case::new("ten_bounces", "ten_bounces").quick();
    case.scene = Scene {
        shape: Shape::TwoWalls,
        end: End::Impacts(10),
        ..case.scene
    };
    case.measurement.force_noise_n = 0.5;
    case.measurement.torque_noise_n_m = 0.05;
    case
}
