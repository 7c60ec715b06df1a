//! Scenario S: a pure delay of 32 ms, a pause of 16 ms, 21 rad/s, elastic, 1 to 15 mm/s.

use super::case::{Case, MASS_KG, OMEGA, PURE, noise, onset_phases, pausing, spread, worst};
use softdock_delay_plants::{Actuator, Formulation};

#[test]
fn all_speeds_without_retuning() {
    let mut largest = [0.0_f64; 5];
    for speed in [1.0, 2.0, 3.0, 5.0, 8.0, 10.0, 12.0, 15.0] {
        for onset_phase in onset_phases(4) {
            let outcome = Case {
                speed_m_s: speed * 1e-3,
                onset_phase,
                ..Case::default()
            }
            .fly();
            assert!(!outcome.run.guarded(), "{speed} mm/s, phase {onset_phase}");
            let errors = [
                outcome.error,
                outcome.energy,
                outcome.peak_force,
                outcome.contact_time,
                outcome.unaccounted,
            ];
            for (largest, error) in largest.iter_mut().zip(errors) {
                assert!(error.is_finite());
                *largest = largest.max(error.abs());
            }
        }
    }
    println!("e, energy, peak force, contact time, unaccounted: {largest:.4?}");
    let [e, energy, force, time, unaccounted] = largest;
    assert!(e <= 0.002 && energy <= 0.005 && force <= 0.03);
    assert!(time <= 0.0065 && unaccounted <= 0.001);
}

#[test]
fn the_other_formulation_of_the_plant_agrees() {
    let cases = onset_phases(4).map(|onset_phase| Case {
        onset_phase,
        formulation: Formulation::FixedSteps,
        ..Case::default()
    });
    assert!(worst("fixed steps", cases) <= 0.002);
}

#[test]
fn stiffness_need_not_be_known() {
    for ratio in [0.3_f64, 0.5, 2.0, 3.0] {
        let cases = onset_phases(6).map(|onset_phase| Case {
            omega: OMEGA * ratio.sqrt(),
            onset_phase,
            ..Case::default()
        });
        let bound = if ratio > 2.0 { 0.01 } else { 0.005 };
        assert!(worst(&format!("stiffness x {ratio}"), cases) <= bound);
    }
}

/// ω τ of 1.2 on a first contact, with an expectation that is wrong by a factor of three.
#[test]
fn a_stiff_first_contact() {
    let omega = 1.2 / 0.032;
    for ratio in [1.0 / 3.0, 1.0, 3.0] {
        for pause_s in [0.0, 0.016] {
            let robot = Actuator { pause_s, ..PURE };
            let cases = onset_phases(5).map(|onset_phase| Case {
                robot,
                believed: robot,
                omega,
                expected_stiffness: ratio * MASS_KG * omega * omega,
                onset_phase,
                ..Case::default()
            });
            let name = format!("phase 1.2, expected x {ratio:.2}, pause {pause_s}");
            assert!(worst(&name, cases) <= 0.03);
        }
    }
}

#[test]
fn the_delay_is_followed() {
    for (quiet, bound) in [(true, 0.005), (false, 0.02)] {
        for delay_ms in [24.0, 28.0, 32.0, 36.0, 40.0, 48.0] {
            let robot = Actuator {
                delay_s: delay_ms * 1e-3,
                ..pausing(PURE)
            };
            let count = if quiet { 4 } else { 8 };
            let cases = onset_phases(count)
                .enumerate()
                .map(|(seed, onset_phase)| Case {
                    robot,
                    onset_phase,
                    seed: seed as u64,
                    measurement: if quiet {
                        noise(0.0, 0.0)
                    } else {
                        noise(0.5, 5e-6)
                    },
                    ..Case::default()
                });
            let errors: Vec<f64> = cases.map(|case| case.fly().error).collect();
            let (mean, deviation, worst) = spread(&errors);
            println!("true delay {delay_ms} ms, quiet: {quiet}: {mean:+.4} ± {deviation:.4}");
            let size = if quiet { worst } else { mean.abs() };
            assert!(size <= bound && deviation <= 0.02);
        }
    }
}

/// A force that grows with depth^1.5 is no spring; the misfit is in the trace.
#[test]
fn a_stiffening_contact_is_nearly_right_or_reported() {
    for onset_phase in onset_phases(3) {
        let case = Case {
            exponent: 1.5,
            // A hundredth of the stiffness at a tenth of a millimetre.
            omega: 210.0,
            onset_phase,
            ..Case::default()
        };
        let run = super::run::run(&case.settings(), &case.plant(), 1.6);
        let misfit = run
            .records
            .last()
            .map_or(0.0, |r| r.trace.law_status.misfit);
        let error = run.restitution() - 1.0;
        println!("depth^1.5: {error:+.4}, misfit {misfit:.3}");
        assert!(error.abs() <= 0.015 || misfit > 0.03, "{error} {misfit}");
    }
}
