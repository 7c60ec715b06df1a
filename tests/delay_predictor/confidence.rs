//! A contact that is not understood: the next one is led by the model's velocity alone.

use super::case::{Case, MASS_KG, OMEGA};
use super::repeated::speeds;
use super::run::{Run, run};
use softdock_control::delay::status::ConfidenceLevel;
use softdock_delay_plants::{ForceLaw, Wall};

/// Depth of an elastic contact of scenario S at 5 mm/s, m.
const DEPTH_M: f64 = 0.005 / OMEGA;

/// Force as depth^p, as large as that of the elastic contact at its depth.
fn power(exponent: f64) -> ForceLaw {
    ForceLaw {
        stiffness: MASS_KG * OMEGA * OMEGA * DEPTH_M.powf(1.0 - exponent),
        exponent,
        ..ForceLaw::linear(0.0, 0.0)
    }
}

/// Between an elastic wall and another one.
fn bounces(case: &Case, back: ForceLaw) -> Run {
    let mut plant = case.plant();
    let back = Wall {
        point: [-0.6 * case.speed_m_s, 0.0, 0.0],
        normal: [1.0, 0.0, 0.0],
        law: back,
    };
    plant.contact.surfaces.push(back.into());
    run(&case.settings(), &plant, 12.0)
}

/// Records with which the law comes to a confidence level.
fn changes_to(run: &Run, level: ConfidenceLevel) -> Vec<usize> {
    let at = |n: usize| run.records[n].trace.law_status.confidence;
    let all = 1..run.records.len();
    all.filter(|n| at(*n) == level && at(n - 1) != level)
        .collect()
}

/// The level changes at every contact: no speed is gained, and no change is a jump.
#[test]
fn an_unfit_contact_is_followed_by_one_that_is_led_less() {
    let case = Case::default();
    for exponent in [2.0, 3.0, 4.0] {
        let run = bounces(&case, power(exponent));
        let speeds = speeds(&run);
        println!("depth^{exponent}: {speeds:.4?}");
        assert!(speeds.len() >= 8);
        assert!(speeds.iter().all(|v| (0.97..=1.004).contains(v)));
        let (down, up) = (
            changes_to(&run, ConfidenceLevel::Fallback),
            changes_to(&run, ConfidenceLevel::Verified),
        );
        assert!(down.len() >= 3 && up.len() >= 3, "{down:?} {up:?}");
        // In units of the speed: from the cycle after the guard has set the model's velocity on.
        let sent = |n: usize| run.records[n].trace.law_velocity[0] / case.speed_m_s;
        let free = |n: &usize| *n > down[0] && n + 20 < run.records.len();
        for n in down.iter().chain(&up).copied().filter(free) {
            for k in n + 1..n + 15 {
                let change = (sent(k) - sent(k - 1)).abs();
                assert!(change < 0.18, "depth^{exponent}, cycle {k}: {change}");
            }
        }
    }
}
