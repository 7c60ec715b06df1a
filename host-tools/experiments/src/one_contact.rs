//! The contact of two spacecraft at one point, reduced to one mass on one wall, without any delay.
//!
//! An impact of two spacecraft at one point with stiffness k and damping c along a normal n is that of
//! one mass m, with `1/m = n·(1/m_K + 1/m_Q) n + (r_K × n)·I_K⁻¹(r_K × n) + (r_Q × n)·I_Q⁻¹(…)`,
//! r from each centre of mass to the point. With ω = √(k/m) and ζ = c/(2√(km)): contact time
//! `(π − 2 asin ζ)/(ω√(1−ζ²))` (the contact cannot pull, so it ends where k x + c v = 0),
//! restitution `exp(−ζ/√(1−ζ²) (π − 2 asin ζ))`, elastic peak force v√(km).

use super::scenario::Scenario;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use softdock_control::frames;
use softdock_control::settings::BodySettings;
use softdock_rig::rig::settings::WallSettings;

/// Number of standard deviations at which the predictor finds a damping as likely as none: √(2 ln 1000).
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
    /// The contact of a scenario's bodies with a wall.
    pub fn new(scenario: &Scenario, wall: &WallSettings) -> Self {
        let control = &scenario.board.control;
        let normal = Vector3::from(wall.normal).normalize();
        let start = frames::orientation_from_abc::<f64>(&scenario.start_abc_rad);
        // The laboratory is the simulated world, rotated such that K has the orientation of M at the start. The point of
        // contact is the tip on K; Q's lever leads to the same point.
        let body_pose =
            |body: &BodySettings| frames::pose::<f64>(&body.position_m, &body.orientation_wxyz);
        let (k, q) = (body_pose(&control.body_k), body_pose(&control.body_q));
        let lab_from_c = start * k.rotation.inverse();
        let tip = start * Vector3::from(wall.tip_m);
        let q_to_tip = lab_from_c * (k.translation.vector - q.translation.vector) + tip;
        let inverse = inverse_mass(&control.body_k, &normal, &tip, &start)
            + inverse_mass(
                &control.body_q,
                &normal,
                &q_to_tip,
                &(lab_from_c * q.rotation),
            );
        Self {
            mass_kg: 1.0 / inverse,
            stiffness_n_per_m: wall.stiffness_n_per_m,
            damping_n_s_per_m: wall.damping_n_s_per_m,
        }
    }

    /// ω = √(k/m), rad/s.
    pub fn frequency_rad_s(&self) -> f64 {
        (self.stiffness_n_per_m / self.mass_kg).sqrt()
    }

    /// ζ = b / (2 √(k m)).
    pub fn damping_ratio(&self) -> f64 {
        self.damping_n_s_per_m / (2.0 * (self.stiffness_n_per_m * self.mass_kg).sqrt())
    }

    /// Phase angle at which the contact ends, divided by √|1 − ζ²|. The wall never pulls, so the contact ends where k x + b v
    /// = 0. For ζ > 1 the arc sine continues as a logarithm.
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

    /// Smallest damping that one contact distinguishes from none, N·s/m, at a speed (m/s), with the noise of the force (N) in
    /// each cycle (s). Depth and speed of an elastic contact are orthogonal, so the standard error of least squares is σ/v
    /// √(2 Ts/T). An estimator that knows less of the motion needs more.
    pub fn damping_in_noise(&self, noise_n: f64, speed_m_s: f64, cycle_s: f64) -> f64 {
        let elastic_s = std::f64::consts::PI / self.frequency_rad_s();
        SEEN * noise_n / speed_m_s * (2.0 * cycle_s / elastic_s).sqrt()
    }
}

fn inverse_mass(
    body: &BodySettings,
    normal: &Vector3<f64>,
    lever: &Vector3<f64>,
    lab_from_body: &UnitQuaternion<f64>,
) -> f64 {
    if body.fixed {
        return 0.0;
    }
    let turn = lab_from_body.inverse() * lever.cross(normal);
    let inertia = Matrix3::from_fn(|r, c| body.inertia_kg_m2[r][c]);
    let response = inertia.lu().solve(&turn).unwrap_or_else(Vector3::zeros);
    1.0 / body.mass_kg + turn.dot(&response)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known answer: the analytic bounce equals a fine integration of m x'' = -k x - c x', clipped.
    #[test]
    fn analytic_bounce_equals_its_integration() {
        for zeta in [0.0, 0.1, 0.4, 0.7, 1.0, 1.2, 3.0] {
            let bounce = Contact {
                mass_kg: 400.0,
                stiffness_n_per_m: 400.0 * 21.0 * 21.0,
                damping_n_s_per_m: 2.0 * zeta * 21.0 * 400.0,
            };
            let (mut x, mut v, mut t, mut peak) = (0.0_f64, 0.01_f64, 0.0, 0.0_f64);
            let h = 1e-6;
            loop {
                let load = 21.0 * 21.0 * x + 2.0 * zeta * 21.0 * v;
                if t > 0.0 && load <= 0.0 {
                    break;
                }
                peak = peak.max(load * 400.0);
                v -= load * h;
                x += v * h;
                t += h;
            }
            assert!((t - bounce.contact_time_s()).abs() < 1e-4, "{zeta}: {t}");
            assert!(
                (-v / 0.01 - bounce.restitution()).abs() < 1e-4,
                "{zeta}: {v}"
            );
            assert!(
                (peak / bounce.peak_force_n(0.01) - 1.0).abs() < 1e-4,
                "{zeta}: {peak}"
            );
        }
    }

    /// Compares with the normal equations of a force with stiffness, onset and damping.
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
}
