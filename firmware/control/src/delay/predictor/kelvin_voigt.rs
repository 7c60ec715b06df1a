//! A spring and a damper against the effective mass: the Kelvin-Voigt model of a contact, which never pulls.
//!
//! ```text
//! s(t) = V/ω_d e^(−ζωt) sin ω_d t   until k s + c s' = 0 at T = (π − 2 asin ζ)/ω_d, then −e V
//! e    = exp(−ζ/√(1−ζ²) (π − 2 asin ζ))
//! ```

use super::tuning::*;
use nalgebra::ComplexField;

/// A spring and a damper against the effective mass.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct KelvinVoigt {
    /// ω, ζ, ω_d; rad/s.
    omega: f64,
    pub(super) zeta: f64,
    damped: f64,
    /// T: duration of the contact, s.
    pub(super) contact_s: f64,
    /// e.
    pub(super) restitution: f64,
    /// s at the end of the contact, in units of V, s.
    end: f64,
}

impl KelvinVoigt {
    /// From stiffness (N/m), damping (N·s/m) and effective mass (kg).
    pub(super) fn new(stiffness: f64, damping: f64, mass: f64) -> Self {
        let omega = ComplexField::sqrt((stiffness / mass).max(1e-6));
        let zeta = (damping / (2.0 * mass * omega)).clamp(0.0, DAMPING_RATIO_LIMIT);
        let root = ComplexField::sqrt(1.0 - zeta * zeta);
        let angle = core::f64::consts::PI - 2.0 * ComplexField::asin(zeta);
        let damped = omega * root;
        let contact_s = angle / damped;
        let restitution = ComplexField::exp(-zeta / root * angle);
        let decay = ComplexField::exp(-zeta * omega * contact_s);
        let end = decay * ComplexField::sin(angle) / damped;
        Self {
            omega,
            zeta,
            damped,
            contact_s,
            restitution,
            end,
        }
    }

    /// s and s' at `N` times from `t_s` on, `step_s` apart, for V = 1.
    pub(super) fn sample<const N: usize>(&self, t_s: f64, step_s: f64) -> [(f64, f64); N] {
        let mut values = [(0.0, 0.0); N];
        // e^(−ζωt) (cos, sin)(ω_d t) at the last time within the contact.
        let mut wave: Option<(f64, f64)> = None;
        let turn = |t: f64| {
            let decay = ComplexField::exp(-self.zeta * self.omega * t);
            let angle = self.damped * t;
            (
                decay * ComplexField::cos(angle),
                decay * ComplexField::sin(angle),
            )
        };
        let (step_cos, step_sin) = turn(step_s);
        for (i, value) in values.iter_mut().enumerate() {
            let t = t_s + step_s * i as f64;
            *value = if t <= 0.0 {
                (t, 1.0)
            } else if t >= self.contact_s {
                let e = self.restitution;
                (self.end - e * (t - self.contact_s), -e)
            } else {
                let (cos, sin) = match wave {
                    Some((c, s)) => (c * step_cos - s * step_sin, s * step_cos + c * step_sin),
                    None => turn(t),
                };
                wave = Some((cos, sin));
                let s = sin / self.damped;
                (s, cos - self.zeta * self.omega * s)
            };
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_delay_plants::truth::Bounce;

    #[test]
    fn restitution_and_duration_are_those_of_the_damped_contact() {
        let (mass, omega) = (500.0, 21.0);
        for zeta in [0.0, 0.1, 0.3, 0.5, 0.8] {
            let spring = KelvinVoigt::new(mass * omega * omega, 2.0 * zeta * mass * omega, mass);
            let bounce = Bounce::new(mass, mass * omega * omega, zeta, 0.005);
            assert!(
                (spring.restitution - bounce.restitution).abs() < 1e-12,
                "{zeta}"
            );
            assert!(
                (spring.contact_s - bounce.contact_s).abs() < 1e-12,
                "{zeta}"
            );
        }
    }

    /// The recursion gives the exact motion: it ends in the rebound, and s' is the derivative of s.
    #[test]
    fn the_motion_is_consistent() {
        let spring = KelvinVoigt::new(220_500.0, 6300.0, 500.0);
        let step = 1e-4;
        let samples = spring.sample::<2000>(-0.003, step);
        for pair in samples.windows(2) {
            let [(s0, v0), (s1, v1)] = [pair[0], pair[1]];
            let slope = (s1 - s0) / step;
            assert!((slope - 0.5 * (v0 + v1)).abs() < 0.3 * step / 1e-4 * 0.02);
        }
        assert!((samples[1999].1 + spring.restitution).abs() < 1e-12);
    }
}
