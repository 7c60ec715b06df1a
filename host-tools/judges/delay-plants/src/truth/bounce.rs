//! One mass on one wall, in closed form.

use std::f64::consts::PI;

/// A mass that meets a damped spring, k x + c x', which cannot pull.
///
/// The contact ends when k x + c x' = 0, before x = 0. With ζ = c / (2 √(k m)) < 1,
/// ω = √(k/m) and ω_d = ω √(1 − ζ²):
/// * contact time (π − 2 asin ζ) / ω_d,
/// * restitution exp(−ζ/√(1−ζ²) (π − 2 asin ζ)),
/// * the force is c v at the touch and has its largest value where its derivative is zero, if
///   that is after the touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounce {
    /// Speed after over speed before.
    pub restitution: f64,
    /// Largest force, N.
    pub peak_force_n: f64,
    /// Time with force, s.
    pub contact_s: f64,
    speed_m_s: f64,
    mass_kg: f64,
    zeta: f64,
    omega: f64,
}

impl Bounce {
    /// The bounce of a mass (kg) on a stiffness (N/m) with a damping ratio (0 to less than 1) and a speed (m/s).
    pub fn new(mass_kg: f64, stiffness_n_m: f64, damping_ratio: f64, speed_m_s: f64) -> Self {
        let (zeta, omega) = (damping_ratio, (stiffness_n_m / mass_kg).sqrt());
        let root = (1.0 - zeta * zeta).sqrt();
        let angle = PI - 2.0 * zeta.asin();
        let scale = speed_m_s * (stiffness_n_m * mass_kg).sqrt();
        // F(φ)/scale with φ = ω_d t: e^(−ζφ/root) (sin φ (1 − 2ζ²)/root + 2ζ cos φ); its slope is
        // zero at tan φ = root (1 − 4ζ²) / (ζ (3 − 4ζ²)).
        let force = |phi: f64| {
            (-zeta * phi / root).exp()
                * (phi.sin() * (1.0 - 2.0 * zeta * zeta) / root + 2.0 * zeta * phi.cos())
        };
        let top = (root * (1.0 - 4.0 * zeta * zeta)).atan2(zeta * (3.0 - 4.0 * zeta * zeta));
        let peak = force(0.0).max(force(top.clamp(0.0, angle)));
        Self {
            restitution: (-zeta / root * angle).exp(),
            peak_force_n: scale * peak,
            contact_s: angle / (omega * root),
            speed_m_s,
            mass_kg,
            zeta,
            omega,
        }
    }

    /// Distance beyond the position of the touch (m) at a time since the touch (s, also before and after the contact): x =
    /// v/ω_d e^(−ζωt) sin ω_d t, and then uniform motion with the speed after.
    pub fn displacement_m(&self, since_touch_s: f64) -> f64 {
        let t = since_touch_s.clamp(0.0, self.contact_s);
        let damped = self.omega * (1.0 - self.zeta * self.zeta).sqrt();
        let curve =
            self.speed_m_s / damped * (-self.zeta * self.omega * t).exp() * (damped * t).sin();
        let before = since_touch_s.min(0.0) * self.speed_m_s;
        let after = (since_touch_s - self.contact_s).max(0.0) * self.speed_m_s * self.restitution;
        before + curve - after
    }

    /// Rate of that distance, m/s.
    pub fn rate_m_s(&self, since_touch_s: f64) -> f64 {
        match since_touch_s {
            t if t <= 0.0 => self.speed_m_s,
            t if t >= self.contact_s => -self.restitution * self.speed_m_s,
            t => {
                let damped = self.omega * (1.0 - self.zeta * self.zeta).sqrt();
                let decay = self.speed_m_s * (-self.zeta * self.omega * t).exp();
                decay * (damped * t).cos() - self.zeta * self.omega * self.displacement_m(t)
            }
        }
    }

    /// Force on the mass, N: k x + c x' in the contact.
    pub fn force_n(&self, since_touch_s: f64) -> f64 {
        if since_touch_s <= 0.0 || since_touch_s >= self.contact_s {
            return 0.0;
        }
        let spring = self.omega * self.omega * self.displacement_m(since_touch_s);
        let damper = 2.0 * self.zeta * self.omega * self.rate_m_s(since_touch_s);
        self.mass_kg * (spring + damper)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ζ .1 to .6: the values of the literature's formula.
    #[test]
    fn known_restitutions() {
        let known = [
            (0.0, 1.0),
            (0.1, 0.744),
            (0.2, 0.572),
            (0.3, 0.451),
            (0.4, 0.364),
            (0.5, 0.298),
            (0.6, 0.249),
        ];
        for (zeta, e) in known {
            let bounce = Bounce::new(500.0, 220_500.0, zeta, 0.005);
            assert!((bounce.restitution - e).abs() < 1e-3, "{zeta}");
        }
    }

    /// Without damping: a half sine.
    #[test]
    fn half_sine() {
        let bounce = Bounce::new(500.0, 500.0 * 21.0 * 21.0, 0.0, 0.005);
        assert!((bounce.peak_force_n - 52.5).abs() < 1e-9);
        assert!((bounce.contact_s - PI / 21.0).abs() < 1e-12);
    }

    /// Compares force, time and speed with a fine integration.
    #[test]
    fn agrees_with_a_fine_integration() {
        for zeta in [0.0, 0.1, 0.3, 0.45, 0.55, 0.7] {
            let (m, k, v0) = (2.0, 50.0, 0.3);
            let c = 2.0 * zeta * f64::sqrt(k * m);
            let (h, mut x, mut v, mut t, mut peak) = (1e-6, 0.0, v0, 0.0, 0.0_f64);
            let bounce = Bounce::new(m, k, zeta, v0);
            loop {
                let force: f64 = k * x + c * v;
                if force <= 0.0 && t > 0.0 {
                    break;
                }
                assert!((bounce.rate_m_s(t) - v).abs() < 1e-5, "{zeta} {t}: {v}");
                let apart = bounce.force_n(t) - force;
                assert!(t == 0.0 || apart.abs() < 1e-4 * k, "{zeta} {t}: {force}");
                peak = peak.max(force);
                let middle = v - 0.5 * h * force / m;
                x += h * middle;
                v -= h * (k * (x - 0.5 * h * middle) + c * middle) / m;
                t += h;
            }
            assert_eq!((bounce.rate_m_s(0.0), bounce.force_n(0.0)), (v0, 0.0));
            assert_eq!(bounce.rate_m_s(t + 0.1), -bounce.restitution * v0);
            assert_eq!(bounce.force_n(t + 0.1), 0.0);
            assert!((bounce.restitution + v / v0).abs() < 1e-5, "{zeta} {v}");
            assert!(
                (bounce.peak_force_n / peak - 1.0).abs() < 1e-5,
                "{zeta} {peak}"
            );
            assert!((bounce.contact_s - t).abs() < 1e-4, "{zeta} {t}");
            assert!((bounce.displacement_m(t) - x).abs() < 1e-5, "{zeta} {x}");
            let displacement = bounce.displacement_m(t + 0.1) - bounce.displacement_m(t);
            assert!(
                (displacement - 0.1 * v).abs() < 1e-5,
                "{zeta} {displacement}"
            );
        }
    }
}
