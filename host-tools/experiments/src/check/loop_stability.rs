//! The linear theory of a contact behind a delay.
//!
//! A mass m whose spring k and damper b answer late by h: m s² + (b s + k) e^(−h s) = 0. On the
//! border of stability s = jω with
//!
//! ```text
//! ω_c² = (b² + √(b⁴ + 4 m² k²)) / (2 m²)        h_c = atan(b ω_c / k) / ω_c
//! ```
//!
//! Zebenay, Boge, Krenn and Choukroun, "Analytical and experimental stability investigation of a
//! hardware-in-the-loop satellite docking simulator", Proc. IMechE G 229 (2015) 666. For little
//! damping h_c is b/k: an elastic contact bears no delay at all.

/// Ends of the searches for critical stiffness, mass and damping.
const SMALLEST: f64 = 1e-6;
const LARGEST: f64 = 1e12;
/// Steps of the search over that range, a tenth of a decade each, and halvings of a step.
const STEPS: i32 = 180;
const HALVINGS: u32 = 60;

/// Standard deviations at which the predictor takes a damping for as likely as none: √(2 ln 1000).
const SEEN: f64 = 3.717;

/// One mass on one wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Mass that the contact feels, kg.
    pub mass_kg: f64,
    /// Stiffness, N/m.
    pub stiffness_n_per_m: f64,
    /// Damping, N·s/m.
    pub damping_n_s_per_m: f64,
}

impl Contact {
    /// ω = √(k/m), rad/s.
    pub fn frequency_rad_s(&self) -> f64 {
        (self.stiffness_n_per_m / self.mass_kg).sqrt()
    }

    /// ζ = b / (2 √(k m)).
    pub fn damping_ratio(&self) -> f64 {
        self.damping_n_s_per_m / (2.0 * (self.stiffness_n_per_m * self.mass_kg).sqrt())
    }

    /// Phase angle at which the contact ends, over √|1 − ζ²|: the wall never pulls, so that is where
    /// k x + b v = 0. Beyond ζ = 1 the arc sine continues as a logarithm.
    fn end(&self) -> f64 {
        let zeta = self.damping_ratio();
        let root = (1.0 - zeta * zeta).abs().sqrt();
        if root < 1e-6 {
            2.0
        } else if zeta < 1.0 {
            (std::f64::consts::PI - 2.0 * zeta.asin()) / root
        } else {
            2.0 * zeta.acosh() / root
        }
    }

    /// Restitution without any delay: exp(−ζ (π − 2 asin ζ) / √(1 − ζ²)).
    pub fn restitution(&self) -> f64 {
        (-self.damping_ratio() * self.end()).exp()
    }

    /// Time in contact without any delay, s.
    pub fn contact_time_s(&self) -> f64 {
        self.end() / self.frequency_rad_s()
    }

    /// Largest force at a speed (m/s) without any delay, N.
    pub fn peak_force_n(&self, speed_m_s: f64) -> f64 {
        let (w, z) = (self.frequency_rad_s(), self.damping_ratio());
        let scale = speed_m_s * w * self.mass_kg;
        // From ζ = 1/2 on the force is largest at the touch, b v.
        if z >= 0.5 {
            return scale * 2.0 * z;
        }
        let root = (1.0 - z * z).sqrt();
        let top = (root * (1.0 - 4.0 * z * z)).atan2(z * (3.0 - 4.0 * z * z));
        let pulse = top.sin() * (1.0 - 2.0 * z * z) / root + 2.0 * z * top.cos();
        scale * (-z * top / root).exp() * pulse
    }

    /// Smallest damping that one contact tells from none, N·s/m, at a speed (m/s), with a noise of the force (N) in each
    /// cycle (s). Depth and speed of an elastic contact are orthogonal, so least squares leave σ/v √(2 Ts/T) of it;
    /// whoever knows less of the motion sees less.
    pub fn damping_in_noise(&self, noise_n: f64, speed_m_s: f64, cycle_s: f64) -> f64 {
        let elastic_s = std::f64::consts::PI / self.frequency_rad_s();
        SEEN * noise_n / speed_m_s * (2.0 * cycle_s / elastic_s).sqrt()
    }

    /// h_c, s: the longest delay with which a lasting contact is stable.
    pub fn critical_delay_s(&self) -> f64 {
        let (m, k, b) = (self.mass_kg, self.stiffness_n_per_m, self.damping_n_s_per_m);
        // Scaled by m, so that no power leaves the range of numbers.
        let (k, b) = (k / m, b / m);
        let square = 0.5 * (b * b + (b.powi(4) + 4.0 * k * k).sqrt());
        let omega = square.sqrt();
        (b * omega / k).atan() / omega
    }
}

/// What would be just stable at a given delay, one quantity changed at a time.
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
    /// For a contact behind a delay, s.
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

/// Smallest argument with which `margin` is not negative; none if there is none.
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

    /// On the border m s² + (b s + k) e^(−h s) vanishes at s = jω: both parts of it.
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

    /// Against the normal equations of a force of stiffness, onset and damping.
    #[test]
    fn noise_hides_what_least_squares_do_not_see() {
        let elastic = Contact {
            mass_kg: 500.0,
            stiffness_n_per_m: 220_500.0,
            damping_n_s_per_m: 0.0,
        };
        let (noise_n, speed_m_s, cycle_s) = (0.5, 0.005, 0.004);
        let omega = elastic.frequency_rad_s();
        let rows = (0..).map(|n| omega * cycle_s * (f64::from(n) + 0.5));
        let rows = rows.take_while(|phase| *phase < std::f64::consts::PI);
        let rows = rows.map(|phase| {
            nalgebra::Vector3::new(
                speed_m_s / omega * phase.sin(),
                1.0,
                speed_m_s * phase.cos(),
            )
        });
        let information: nalgebra::Matrix3<f64> = rows.map(|row| row * row.transpose()).sum();
        let deviation = noise_n * information.try_inverse().unwrap()[(2, 2)].sqrt();
        let hidden = elastic.damping_in_noise(noise_n, speed_m_s, cycle_s);
        assert!((hidden / (SEEN * deviation) - 1.0).abs() < 0.02, "{hidden}");
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
        // Stiffer, lighter or less damped is worse.
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

    /// ζ .1, .3, .6: known values; beyond 1 the formula goes on without a step.
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
