//! A contact oblique to all axes, for the tests of its estimation: friction turns the force away from the direction of the
//! stiffness.

use super::V6;
use crate::delay::spacecraft::CYCLE_S;

/// ω, rad/s.
const OMEGA: f64 = 21.0;

/// h and Bh: direction of the load with a force part of 1, and velocity per impulse along it.
pub(super) fn direction() -> (V6, V6) {
    (
        V6::new(0.8, -0.6, 0.0, 0.1, 0.0, -0.2),
        V6::new(1.6, -1.1, 0.1, 0.3, -0.1, -0.5) * 1e-3,
    )
}

/// Direction in which the load grows.
pub(super) fn gradient() -> V6 {
    V6::new(0.9, -0.5, 0.2, 0.1, 0.1, -0.1)
}

/// Direction of the robot's motion.
pub(super) fn way() -> V6 {
    V6::new(0.9, -0.5, 0.1, 0.0, 0.2, -0.1)
}

/// A sample `n` cycles after the onset at a closing velocity (m/s): position, m, with a motion across the contact that
/// distinguishes the axes; change of the closing velocity, m/s; and load, N, with some noise.
pub(super) fn sample(n: i32, closing: f64, damping: f64, noise: f64) -> (V6, f64, f64) {
    let (sin, cos) = (OMEGA * CYCLE_S * f64::from(n)).sin_cos();
    let wave = |rate: f64| (rate * f64::from(n)).sin();
    let across = V6::from([1.1, 2.3, 1.7, 0.9, 2.9, 1.3].map(wave));
    let position = way() * (closing / OMEGA * sin) + across * 1e-5;
    let change = closing * (cos - 1.0);
    let kappa = gradient() * 2.2e5;
    let load = kappa.dot(&position) + damping * (closing + change) + noise * wave(3.7);
    (position, change, load)
}
