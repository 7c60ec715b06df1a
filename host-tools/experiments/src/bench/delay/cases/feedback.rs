//! Noise and latency of the feedback.

use super::super::case::{CYCLE_S, Case};

/// Lever that converts the noise of a force to that of a torque, and of a position to that of an angle, m.
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
    cases.extend([1, 2, 4].map(known_latency));
    for zeta in [0.0, 0.2] {
        cases.extend([0, 1, 2, 3, 4].map(|cycles| unknown_latency(cycles, zeta)));
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

/// The pose is older than the force by this number of cycles, and the board knows it.
fn known_latency(cycles: u8) -> Case {
    let mut case = Case::new("known_latency", format!("latency_{cycles}_known"));
    case.measurement.pose_latency_cycles = usize::from(cycles);
    case.believed.feedback_latency_known = true;
    case.believed.feedback_latency_cycles = cycles;
    case.quick = cycles == 2;
    case
}

/// Settings as `softdock identify actuator` writes them without a tool whose weight shows the latency: the identified delay
/// includes the latency, and the latency is set to 0. With 0 cycles this is what commissioning leaves on most robots.
fn unknown_latency(cycles: u8, zeta: f64) -> Case {
    let damped = if zeta > 0.0 {
        format!("_damping_{zeta}")
    } else {
        String::new()
    };
    let name = format!("latency_{cycles}_unknown{damped}");
    let mut case = Case::new("unknown_latency", name);
    case.scene = case.scene.damped(zeta);
    case.measurement.pose_latency_cycles = usize::from(cycles);
    case.believed.feedback_latency_known = false;
    case.believed.delay_s += CYCLE_S * f64::from(cycles);
    case.quick = cycles == 0 || cycles == 2 && zeta == 0.0;
    if cycles == 0 && zeta == 0.0 {
        case.speeds_mm_s = vec![1.0, 5.0, 15.0];
    }
    case
}
