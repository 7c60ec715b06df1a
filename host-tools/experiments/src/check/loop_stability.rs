//! The linear theory of a contact behind a delay.
//!
//! A mass m whose spring k and damper b act late by h: m s² + (b s + k) e^(−h s) = 0. At the stability limit s = jω with
//!
//! ```text
//! ω_c² = (b² + √(b⁴ + 4 m² k²)) / (2 m²)        h_c = atan(b ω_c / k) / ω_c
//! ```
//!
//! Zebenay, Boge, Krenn and Choukroun, "Analytical and experimental stability investigation of a
//! hardware-in-the-loop satellite docking simulator", Proc. IMechE G 229 (2015) 666. For little
//! damping h_c is b/k: with an elastic contact no delay is stable.

use crate::one_contact::Contact;

/// Range of the searches for critical stiffness, mass and damping.
const SMALLEST: f64 = 1e-6;
const LARGEST: f64 = 1e12;
/// Steps of a search over that range, a tenth of a decade each, and bisections of a step.
const STEPS: i32 = 180;
const HALVINGS: u32 = 60;

impl Contact {
    /// h_c, s: the longest delay with which a lasting contact is stable.
    pub fn critical_delay_s(&self) -> f64 {
        let (m, k, b) = (self.mass_kg, self.stiffness_n_per_m, self.damping_n_s_per_m);
        // Scaled by m, so that no power overflows.
        let (k, b) = (k / m, b / m);
        let square = 0.5 * (b * b + (b.powi(4) + 4.0 * k * k).sqrt());
        let omega = square.sqrt();
        (b * omega / k).atan() / omega
    }
}

/// Values at which the loop with a given delay is just stable, one quantity changed at a time; None where no value is stable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Critical {
    /// Largest stiffness, N/m.
    pub stiffness_n_per_m: Option<f64>,
    /// Smallest mass, kg.
    pub mass_kg: Option<f64>,
    /// Smallest damping, N·s/m.
    pub damping_n_s_per_m: Option<f64>,
}

impl Critical {
    /// The critical values of a contact with a delay, s.
    pub fn new(contact: &Contact, delay_s: f64) -> Self {
        let margin = |contact: Contact| contact.critical_delay_s() - delay_s;
        let stiffness = |k: f64| {
            margin(Contact {
                stiffness_n_per_m: k,
                ..*contact
            })
        };
        let mass = |m: f64| {
            margin(Contact {
                mass_kg: m,
                ..*contact
            })
        };
        let damping = |b: f64| {
            margin(Contact {
                damping_n_s_per_m: b,
                ..*contact
            })
        };
        Self {
            stiffness_n_per_m: border(|x| stiffness(1.0 / x)).map(|x| 1.0 / x),
            mass_kg: border(mass),
            damping_n_s_per_m: border(damping),
        }
    }
}

/// Smallest argument for which `margin` is not negative; None if it is negative everywhere.
fn border(margin: impl Fn(f64) -> f64) -> Option<f64> {
    let at = |step: i32| SMALLEST * (LARGEST / SMALLEST).powf(f64::from(step) / f64::from(STEPS));
    let first = (0..=STEPS).find(|step| margin(at(*step)) >= 0.0)?;
    if first == 0 {
        return Some(0.0);
    }
    let (mut low, mut high) = (at(first - 1), at(first));
    for _ in 0..HALVINGS {
        let middle = (low * high).sqrt();
        if margin(middle) >= 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    Some(high)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONTACT: Contact = Contact {
        mass_kg: 500.0,
        stiffness_n_per_m: 220_500.0,
        damping_n_s_per_m: 4200.0,
    };

    /// At the limit m s² + (b s + k) e^(−h s) vanishes at s = jω, in its real and its imaginary part.
    #[test]
    fn the_characteristic_equation_holds_on_the_border() {
        for damping_n_s_per_m in [10.0, 4200.0, 3e4, 3e5] {
            let contact = Contact {
                damping_n_s_per_m,
                ..CONTACT
            };
            let (m, k, b) = (500.0, 220_500.0, damping_n_s_per_m);
            let h = contact.critical_delay_s();
            let w = ((b * b + f64::sqrt(b.powi(4) + 4.0 * m * m * k * k)) / (2.0 * m * m)).sqrt();
            let (sin, cos) = (w * h).sin_cos();
            let real = -m * w * w + k * cos + b * w * sin;
            let imaginary = b * w * cos - k * sin;
            assert!(real.abs() < 1e-9 * m * w * w, "{real}");
            assert!(imaginary.abs() < 1e-9 * m * w * w, "{imaginary}");
        }
    }

    #[test]
    fn an_elastic_contact_bears_no_delay_and_a_little_damping_bears_b_over_k() {
        let with = |damping_n_s_per_m| Contact {
            damping_n_s_per_m,
            ..CONTACT
        };
        assert_eq!(with(0.0).critical_delay_s(), 0.0);
        let h = with(100.0).critical_delay_s();
        assert!((h * 220_500.0 / 100.0 - 1.0).abs() < 1e-3, "{h}");
    }

    #[test]
    fn what_is_critical_has_the_delay_as_critical_delay() {
        let delay_s = 0.012;
        let critical = Critical::new(&CONTACT, delay_s);
        let contacts = [
            Contact {
                stiffness_n_per_m: critical.stiffness_n_per_m.unwrap(),
                ..CONTACT
            },
            Contact {
                mass_kg: critical.mass_kg.unwrap(),
                ..CONTACT
            },
            Contact {
                damping_n_s_per_m: critical.damping_n_s_per_m.unwrap(),
                ..CONTACT
            },
        ];
        for contact in contacts {
            let h = contact.critical_delay_s();
            assert!((h / delay_s - 1.0).abs() < 1e-9, "{contact:?} {h}");
        }
        // A stiffer, lighter or less damped contact is stable with less delay.
        let worse = Contact {
            stiffness_n_per_m: 1.1 * contacts[0].stiffness_n_per_m,
            ..CONTACT
        };
        assert!(worse.critical_delay_s() < delay_s);
        let elastic = Contact {
            damping_n_s_per_m: 0.0,
            ..CONTACT
        };
        assert_eq!(Critical::new(&elastic, delay_s).mass_kg, None);
    }

    /// ζ .1, .3, .6: known values; the formula is continuous at ζ = 1.
    #[test]
    fn restitution_of_the_contact_itself() {
        let at = |zeta: f64| Contact {
            damping_n_s_per_m: zeta * 2.0 * f64::sqrt(500.0 * 220_500.0),
            ..CONTACT
        };
        for (zeta, e) in [(0.0, 1.0), (0.1, 0.744), (0.3, 0.451), (0.6, 0.249)] {
            assert!((at(zeta).restitution() - e).abs() < 1e-3, "{zeta}");
        }
        let (below, above) = (at(0.999).restitution(), at(1.001).restitution());
        assert!((below - above).abs() < 1e-3 && above < below);
        assert!((at(0.0).peak_force_n(0.005) - 52.5).abs() < 1e-9);
        assert!((at(0.4999).peak_force_n(1.0) / at(0.5).peak_force_n(1.0) - 1.0).abs() < 1e-3);
    }
}
