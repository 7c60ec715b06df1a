//! Result of an ideal test: the bounce in closed form, or a simulation of two free spacecraft.

use super::case::Case;
use super::scene::{APART_M, End, Shape};
use nalgebra::Vector3;
use softdock_delay_plants::truth::{Bounce, Outcome};

/// Result of an ideal test.
#[derive(Clone, Debug, PartialEq)]
pub struct Ideal {
    /// Speed after over speed before, along the normal at the probe. Where the normal changes, the root of the ratio of
    /// energies: see [`restitution`].
    pub restitution: f64,
    /// Kinetic energy after over energy before.
    pub energy: f64,
    /// Largest force, N.
    pub peak_force_n: f64,
    /// Total time with contact force, s.
    pub contact_s: f64,
    /// Motion of K and Q after the test, as in [`super::trial::Moment`].
    pub after: [[Vector3<f64>; 2]; 2],
    /// The bounce in closed form; None where there is none.
    pub bounce: Option<Bounce>,
}

/// Motion of both spacecraft: K and Q, each linear (C) and angular (body axes).
pub type Motion = [[Vector3<f64>; 2]; 2];

impl Ideal {
    /// The ideal result of a case at a speed; `flight_s` is the time of flight before the touch.
    pub fn new(case: &Case, speed_m_s: f64, flight_s: f64) -> Self {
        let scene = &case.scene;
        let test = scene.free_test(speed_m_s, flight_s);
        let before = [
            [test.k.velocity.linear, test.k.velocity.angular],
            [test.q.velocity.linear, test.q.velocity.angular],
        ];
        if scene.is_straight() {
            return Self::straight(case, speed_m_s, before);
        }
        let outcome = match scene.end {
            End::Impacts(n) => test.run(60.0, n),
            End::After(s) => test.run(flight_s + s, usize::MAX),
        };
        let Outcome { k, q, contacts, .. } = &outcome;
        let after = [[k.linear, k.angular], [q.linear, q.angular]];
        Self {
            restitution: restitution(case, contacts.len(), &before, &after),
            energy: energy(case, &after) / energy(case, &before),
            peak_force_n: contacts.iter().map(|c| c.peak_force_n).fold(0.0, f64::max),
            contact_s: contacts.iter().filter_map(|c| c.duration_s()).sum(),
            after,
            bounce: None,
        }
    }

    fn straight(case: &Case, speed_m_s: f64, before: Motion) -> Self {
        let scene = &case.scene;
        let count = match scene.end {
            End::Impacts(n) => n,
            End::After(_) => 1,
        };
        let bounce = Bounce::new(scene.mass_kg, scene.law.stiffness, scene.zeta(), speed_m_s);
        let restitution = bounce.restitution.powi(count as i32);
        let sign = if count % 2 == 0 { 1.0 } else { -1.0 };
        let mut after = before;
        after[0][0] *= sign * restitution;
        Self {
            restitution,
            energy: restitution * restitution,
            peak_force_n: bounce.peak_force_n,
            contact_s: bounce.contact_s * count as f64,
            after,
            bounce: Some(bounce),
        }
    }
}

/// Speed after over speed before, of the probe along the first normal, relative to Q. It is positive when the probe comes
/// back, or, after an even number of impacts between two walls, when it goes on. Where the normal changes, it is the root of
/// the ratio of energies.
pub fn restitution(case: &Case, impacts: usize, before: &Motion, after: &Motion) -> f64 {
    let Some(normal) = case.scene.normal() else {
        return (energy(case, after) / energy(case, before)).max(0.0).sqrt();
    };
    let closing = |motion: &Motion| {
        let [k, q] = motion;
        // Orientations change by less than a degree during a test, so body axes are those of the laboratory.
        let turned = (k[1] - q[1]).cross(&Vector3::from(case.scene.probe));
        (k[0] - q[0] + turned - q[1].cross(&-apart())).dot(&Vector3::from(normal))
    };
    rebound_sign(case, impacts) * closing(after) / closing(before)
}

/// −1 where the velocity is expected to change its sign; 1 after an even number of impacts between two walls.
pub fn rebound_sign(case: &Case, impacts: usize) -> f64 {
    let goes_on = case.scene.shape == Shape::TwoWalls && impacts.is_multiple_of(2);
    if goes_on { 1.0 } else { -1.0 }
}

/// Vector from K to Q, m.
fn apart() -> Vector3<f64> {
    Vector3::new(APART_M, 0.0, 0.0)
}

/// Kinetic energy of both spacecraft, J.
pub fn energy(case: &Case, motion: &Motion) -> f64 {
    let scene = &case.scene;
    let of = |mass: f64, [v, w]: &[Vector3<f64>; 2], inertia: [f64; 3]| {
        let spun = w.component_mul(&Vector3::from(inertia)).dot(w);
        0.5 * (mass * v.norm_squared() + spun)
    };
    let k = of(scene.mass_kg, &motion[0], scene.inertia());
    if scene.other_mass_kg.is_infinite() {
        return k;
    }
    k + of(scene.other_mass_kg, &motion[1], scene.other_inertia())
}
