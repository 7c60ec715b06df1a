//! Noise and latency of what the board is told.

use super::super::case::Case;

/// Arm that makes a torque's noise of a force's and an angle's of a position's, m.
const NOISE_ARM_M: f64 = 0.1;

pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (force_n, position_um, speed_mm_s) in [
        (0.2, 0.0, 1.0),
        (0.5, 0.0, 1.0),
        (0.5, 0.0, 5.0),
        (1.0, 0.0, 5.0),
        (2.0, 0.0, 5.0),
        (1.0, 0.0, 15.0),
        (0.0, 1.0, 5.0),
        (0.0, 5.0, 5.0),
        (0.0, 20.0, 5.0),
        (0.2, 5.0, 1.0),
        (0.5, 5.0, 5.0),
        (0.5, 20.0, 5.0),
    ] {
        cases.push(noise(force_n, position_um, speed_mm_s));
    }
    for cycles in [1, 2, 4] {
        for known in [true, false] {
            cases.push(latency(cycles, known));
        }
    }
    cases
}

fn noise(force_n: f64, position_um: f64, speed_mm_s: f64) -> Case {
    let name = format!("noise_{force_n}_n_{position_um}_um_at_{speed_mm_s}_mm_s");
    let mut case = Case::new("noise", name);
    let measurement = &mut case.measurement;
    measurement.force_noise_n = force_n;
    measurement.torque_noise_n_m = force_n * NOISE_ARM_M;
    measurement.position_noise_m = position_um * 1e-6;
    measurement.angle_noise_rad = position_um * 1e-6 / NOISE_ARM_M;
    case.speeds_mm_s = vec![speed_mm_s];
    case.touches = 16;
    case.quick = (force_n, position_um) == (0.5, 5.0);
    case
}

/// The pose is older than the force; known to the board, or believed to be in step with it.
fn latency(cycles: u8, known: bool) -> Case {
    let word = if known { "known" } else { "unknown" };
    let sweep = if known {
        "known_latency"
    } else {
        "unknown_latency"
    };
    let mut case = Case::new(sweep, format!("latency_{cycles}_{word}"));
    case.measurement.pose_latency_cycles = usize::from(cycles);
    case.believed.feedback_latency_known = known;
    if known {
        case.believed.feedback_latency_cycles = cycles;
    }
    case.quick = cycles == 2;
    case
}
