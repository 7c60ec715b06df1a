//! Delay × stiffness × mass × damping: the predicted restitution of every law against the simulated.

use crate::delay_laws::case::{CYCLE_S, Case, Rebound};
use softdock_app::settings::BoardSettings;
use softdock_control::delay::LawName;
use softdock_experiments::check::{Check, Contact, Rig, check};

/// Not whole cycles: there the force of a damper jumps in the very instant in which it is measured,
/// and the side from which a simulation looks decides by several percent.
const DELAYS_S: [f64; 3] = [0.010, 0.025, 0.0385];
const OMEGAS_RAD_S: [f64; 3] = [8.0, 16.0, 26.0];
const MASSES_KG: [f64; 2] = [60.0, 900.0];
const DAMPING_RATIOS: [f64; 3] = [0.0, 0.1, 0.4];

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (delay_s, omega) in DELAYS_S
        .into_iter()
        .flat_map(|d| OMEGAS_RAD_S.map(|w| (d, w)))
    {
        for (mass_kg, zeta) in MASSES_KG
            .into_iter()
            .flat_map(|m| DAMPING_RATIOS.map(|z| (m, z)))
        {
            let mut case = Case::scenario_s(LawName::None);
            case.plant.actuator.delay_s = delay_s;
            case.settings.delay.actuator.delay_s = delay_s;
            case.settings.limits.force_n = 1e5;
            // As long as the check flies: what the adaptive law learns from.
            case.flight_s = 164.5 * CYCLE_S;
            (case.omega, case.mass_kg, case.damping_ratio) = (omega, mass_kg, zeta);
            cases.push(case);
        }
    }
    cases
}

fn predicted(case: &Case) -> Check {
    let board = BoardSettings {
        control: case.settings.clone(),
        ..BoardSettings::default()
    };
    let (stiffness_n_per_m, damping_n_s_per_m) = case.contact();
    let mut rig = Rig {
        actuator: Default::default(),
        feedback_latency_cycles: 0,
        contact: Contact {
            mass_kg: case.mass_kg,
            stiffness_n_per_m,
            damping_n_s_per_m,
        },
        approach_speed_m_s: case.speed_m_s,
        noise_force_n: None,
    };
    rig.actuator.delay_s = case.plant.actuator.delay_s;
    rig.actuator.pause_s = case.plant.actuator.pause_s;
    check(&board, &rig).unwrap()
}

fn simulated(case: &Case, law: LawName) -> Vec<Rebound> {
    let mut case = case.clone();
    case.settings.delay.law = law;
    let places: Vec<f64> = (0..8).map(|n| f64::from(n) / 8.0).collect();
    case.bounces_at(&[1e3 * case.speed_m_s], &places)
}

#[test]
fn every_law_at_three_points_of_the_grid() {
    every_law_at(20);
}

#[test]
#[ignore = "long: 54 cases with every law"]
fn every_law_over_the_grid() {
    assert!(every_law_at(1) > 300);
}

/// At every so many points of the grid; the number of restitutions that were compared.
fn every_law_at(every: usize) -> usize {
    let (mut worst, mut compared, mut wrong) = (0.0f64, 0, Vec::new());
    for case in cases().into_iter().step_by(every) {
        let check = predicted(&case);
        for (law, row) in LawName::ALL.into_iter().zip(&check.laws) {
            assert_eq!(row.law, law.name());
            let simulated = simulated(&case, law);
            let all = simulated.iter().map(|r| r.restitution);
            let mean = all.clone().sum::<f64>() / simulated.len() as f64;
            let what = format!(
                "{law:?}, {} s, ω {}, m {}, ζ {}",
                case.plant.actuator.delay_s, case.omega, case.mass_kg, case.damping_ratio
            );
            let ended = simulated.iter().all(|r| r.contact_time_error.is_finite());
            let Some(e) = row.expected_restitution else {
                assert!(
                    !ended || mean < 0.1,
                    "{what}: nothing predicted, {mean} simulated"
                );
                continue;
            };
            if !ended {
                assert!(e < 0.1, "{what}: {e} predicted, the contact does not end");
                continue;
            }
            let highest = all.clone().fold(f64::MIN, f64::max);
            let spread = highest - all.fold(f64::MAX, f64::min);
            // A saw-tooth over the place of the touch, seen at eight places in two ways. The Smith
            // predictors do not identify damping: behind a damped wall each place is another.
            let smith = matches!(law, LawName::Smith | LawName::SmithDeadZone);
            let blind = smith && case.damping_ratio > 0.0;
            let seen = if blind {
                0.5 * spread + 0.05
            } else {
                spread / 8.0
            };
            // Heavy damping jumps at the touch, in the middle of a cycle.
            let part = if case.damping_ratio < 0.3 { 0.02 } else { 0.04 };
            let tolerance = part * mean.abs().max(1.0) + seen;
            let error = (e - mean).abs();
            if !blind {
                worst = worst.max(error / mean.abs().max(1.0));
            }
            compared += 1;
            if error >= tolerance {
                wrong.push(format!("{what}: {e}, simulated {mean} ± {spread}"));
            }
            let border = (mean - 1.015).abs().min((mean + 0.015).abs());
            let comes_back = (-0.015..1.015).contains(&mean);
            if border > tolerance && (row.stable != comes_back || row.flies_on != (mean < 0.0)) {
                wrong.push(format!("{what}: {row:?}, simulated {mean} ± {spread}"));
            }
        }
    }
    println!("{compared} restitutions, worst difference {worst:.4}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    compared
}

/// The linear theory: without compensation an impact comes back slower than it came if and only if
/// the delay is below the critical one, but for a band around it, because an impact is half a period
/// of the lasting contact that the theory is of, and starts with a jump of the damping force.
#[test]
fn the_critical_delay_parts_gain_from_loss() {
    for damping_ratio in [0.1, 0.2, 0.3] {
        let mut case = Case::scenario_s(LawName::None);
        (case.omega, case.damping_ratio) = (16.0, damping_ratio);
        case.plant.actuator.pause_s = 0.0;
        let critical_s = predicted(&case).critical_delay_s;
        for ratio in [0.5, 0.7, 1.5, 2.0] {
            // Half a cycle of the delay is the model's own.
            case.plant.actuator.delay_s = ratio * critical_s - 0.5 * CYCLE_S;
            let e = case.bounce::<f64>().restitution;
            println!("ζ {damping_ratio}, {ratio} h_c: {e:.3}");
            assert_eq!(e > 1.0, ratio > 1.0, "ζ {damping_ratio}, {ratio} h_c: {e}");
        }
    }
}
