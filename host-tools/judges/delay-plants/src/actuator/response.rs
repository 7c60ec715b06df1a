//! Closed-form responses of lag and servo to a constant input.

use super::Dynamics;
use std::f64::consts::TAU;

/// Velocity and acceleration of the output.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Output {
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
}

/// The output after `dt_s` of a constant input, and the distance covered meanwhile.
pub(super) fn after(dynamics: Dynamics, from: Output, input: f64, dt_s: f64) -> (Output, f64) {
    match dynamics {
        Dynamics::None => (
            Output {
                velocity: input,
                acceleration: 0.0,
            },
            input * dt_s,
        ),
        Dynamics::Lag { time_constant_s } => lag(time_constant_s, from, input, dt_s),
        Dynamics::Servo { hz, damping } => servo(TAU * hz, damping, from, input, dt_s),
    }
}

/// y(t) = u + (y0 − u) e^(−t/T).
fn lag(time_constant_s: f64, from: Output, input: f64, dt_s: f64) -> (Output, f64) {
    let apart = from.velocity - input;
    let gone = -(-dt_s / time_constant_s).exp_m1();
    let velocity = from.velocity - apart * gone;
    let output = Output {
        velocity,
        acceleration: (input - velocity) / time_constant_s,
    };
    (output, input * dt_s + apart * time_constant_s * gone)
}

/// With e = y − u: e'' + 2 ζ ω e' + ω² e = 0, whose integral follows from e and e'.
fn servo(omega: f64, damping: f64, from: Output, input: f64, dt_s: f64) -> (Output, f64) {
    let (e0, d0) = (from.velocity - input, from.acceleration);
    let decay = damping * omega;
    let fade = (-decay * dt_s).exp();
    let (even, odd) = basis(omega * omega - decay * decay, dt_s);
    let e = fade * (e0 * even + (d0 + decay * e0) * odd);
    let d = fade * (d0 * even - (omega * omega * e0 + decay * d0) * odd);
    let way = (d0 - d + 2.0 * decay * (e0 - e)) / (omega * omega);
    let output = Output {
        velocity: input + e,
        acceleration: d,
    };
    (output, input * dt_s + way)
}

/// cos(s t) and sin(s t)/s for s² of either sign.
fn basis(s_squared: f64, t: f64) -> (f64, f64) {
    let s = s_squared.abs().sqrt();
    if s * t < 1e-6 {
        (1.0, t)
    } else if s_squared > 0.0 {
        ((s * t).cos(), (s * t).sin() / s)
    } else {
        ((s * t).cosh(), (s * t).sinh() / s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Dynamics; 4] = [
        Dynamics::Lag {
            time_constant_s: 0.032,
        },
        Dynamics::Servo {
            hz: 10.0,
            damping: 0.7,
        },
        Dynamics::Servo {
            hz: 5.0,
            damping: 1.0,
        },
        Dynamics::Servo {
            hz: 5.0,
            damping: 1.6,
        },
    ];

    /// One interval gives the same as two parts of it.
    #[test]
    fn two_parts_make_the_whole() {
        let from = Output {
            velocity: 0.3,
            acceleration: -2.0,
        };
        for dynamics in ALL {
            let (whole, way) = after(dynamics, from, -1.0, 0.02);
            let (half, first) = after(dynamics, from, -1.0, 0.007);
            let (end, second) = after(dynamics, half, -1.0, 0.013);
            assert!(
                (whole.velocity - end.velocity).abs() < 1e-14,
                "{dynamics:?}"
            );
            assert!((way - first - second).abs() < 1e-15, "{dynamics:?}");
        }
    }

    /// The acceleration is the derivative of the velocity, and the velocity that of the distance.
    #[test]
    fn derivatives_agree() {
        let from = Output {
            velocity: 0.3,
            acceleration: -2.0,
        };
        let h = 1e-6;
        for dynamics in ALL {
            let ((before, w0), (at, _), (later, w1)) = (
                after(dynamics, from, -1.0, 0.01 - h),
                after(dynamics, from, -1.0, 0.01),
                after(dynamics, from, -1.0, 0.01 + h),
            );
            let acceleration = (later.velocity - before.velocity) / (2.0 * h);
            assert!(
                (acceleration - at.acceleration).abs() < 1e-6,
                "{dynamics:?}"
            );
            assert!(
                ((w1 - w0) / (2.0 * h) - at.velocity).abs() < 1e-8,
                "{dynamics:?}"
            );
        }
    }
}
