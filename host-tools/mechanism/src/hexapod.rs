//! A ring on six legs with load cells.

use crate::Joint;
use nalgebra::{ComplexField, Matrix6, RealField, Vector3, Vector6};
use serde::{Deserialize, Serialize};
use softdock_control::frames::{Pose, Twist, Wrench};
use softdock_control::range::{SettingsError, in_range};

/// Six springs with dampers and load cells, in pairs, from a base at x = `height_m` of P to a ring about P. The joints on the
/// base lie in pairs beside three places at 120°, those on the ring beside three places between them. Each leg connects
/// neighbouring places, as in Stewart's platform.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hexapod {
    /// Radius of the joints on the base, m.
    pub base_radius_m: f64,
    /// Radius of the joints on the ring, m.
    pub ring_radius_m: f64,
    /// Distance from ring to base, m.
    pub height_m: f64,
    /// Half of the angle between the two joints of a pair, rad.
    pub spread_rad: f64,
    /// Stiffness of a leg along itself, N/m.
    pub stiffness_n_per_m: f64,
    /// Damping of a leg along itself, N·s/m.
    pub damping_n_s_per_m: f64,
    /// Factors on the stiffness of each leg: 1, or less for a soft one.
    #[serde(default = "alike", skip_serializing_if = "are_alike")]
    pub leg_factors: [f64; 6],
}

fn alike() -> [f64; 6] {
    [1.0; 6]
}

fn are_alike(factors: &[f64; 6]) -> bool {
    *factors == alike()
}

/// State of a leg.
#[derive(Clone, Copy, Debug)]
struct Leg {
    /// Unit vector from base to ring, in P.
    direction: Vector3<f64>,
    /// Vector from the ring's centre to the joint, m, axes of P.
    lever: Vector3<f64>,
    length_m: f64,
}

impl Leg {
    /// Row of the Jacobian: rate of the length for a unit of each component of the ring's twist (linear, angular; in P).
    fn jacobian_row(&self) -> Vector6<f64> {
        let turning = self.lever.cross(&self.direction);
        let (d, t) = (self.direction, turning);
        Vector6::new(d.x, d.y, d.z, t.x, t.y, t.z)
    }
}

impl Hexapod {
    pub(crate) fn validate(&self) -> Result<(), SettingsError> {
        in_range("legs.base_radius_m", self.base_radius_m, 0.01, 10.0)?;
        in_range("legs.ring_radius_m", self.ring_radius_m, 0.01, 10.0)?;
        in_range("legs.height_m", self.height_m, 0.01, 10.0)?;
        in_range("legs.spread_rad", self.spread_rad, 0.01, 0.9)?;
        in_range("legs.stiffness_n_per_m", self.stiffness_n_per_m, 1.0, 1e9)?;
        in_range("legs.damping_n_s_per_m", self.damping_n_s_per_m, 1.0, 1e7)?;
        let factors = self.leg_factors.iter();
        factors
            .copied()
            .try_for_each(|factor| in_range("legs.leg_factors", factor, 1e-3, 10.0))
    }

    fn stiffness(&self, leg: usize) -> f64 {
        self.stiffness_n_per_m * self.leg_factors[leg]
    }

    /// The legs for a pose of the ring in P.
    fn legs(&self, ring: &Pose<f64>) -> [Leg; 6] {
        let place = |angle: f64, radius: f64, x: f64| {
            let (sin, cos) = ComplexField::sin_cos(angle);
            Vector3::new(x, radius * cos, radius * sin)
        };
        std::array::from_fn(|i| {
            let pair = (i / 2) as f64 * f64::two_pi() / 3.0;
            let side = if i % 2 == 0 { -1.0 } else { 1.0 };
            let on_base = pair + side * self.spread_rad;
            let on_ring = pair + side * (f64::frac_pi_3() - self.spread_rad);
            let base = place(on_base, self.base_radius_m, self.height_m);
            let lever = ring.rotation * place(on_ring, self.ring_radius_m, 0.0);
            let along = ring.translation.vector + lever - base;
            let length_m = along.norm();
            Leg {
                direction: along / length_m,
                lever,
                length_m,
            }
        })
    }

    /// Deflections of the legs from their rest, m.
    fn deflections(&self, ring: &Pose<f64>) -> [f64; 6] {
        let rest = self.legs(&Pose::identity());
        let now = self.legs(ring);
        std::array::from_fn(|i| now[i].length_m - rest[i].length_m)
    }

    /// Readings of the load cells, N (pull is positive), for a pose and a twist of the ring in P.
    pub(crate) fn cells(&self, ring: &Pose<f64>, twist: &Twist<f64>) -> [f64; 6] {
        let (legs, deflections) = (self.legs(ring), self.deflections(ring));
        let twist = Vector6::from(twist.get());
        std::array::from_fn(|i| {
            self.stiffness(i) * deflections[i]
                + self.damping_n_s_per_m * legs[i].jacobian_row().dot(&twist)
        })
    }

    /// Wrench on the ring, about its centre in axes of P, that corresponds to these load cells.
    pub(crate) fn wrench(&self, ring: &Pose<f64>, cells: &[f64; 6]) -> Wrench<f64> {
        let legs = self.legs(ring);
        let sum = legs
            .iter()
            .zip(cells)
            .fold(Vector6::zeros(), |sum, (leg, n)| {
                sum - leg.jacobian_row() * *n
            });
        Wrench::of(&sum.into())
    }

    /// Energy in the springs, J.
    pub(crate) fn stored_j(&self, ring: &Pose<f64>) -> f64 {
        let deflections = self.deflections(ring);
        (0..6)
            .map(|i| 0.5 * self.stiffness(i) * deflections[i] * deflections[i])
            .sum()
    }

    /// Power that the dampers dissipate, W.
    pub(crate) fn loss_w(&self, ring: &Pose<f64>, twist: &Twist<f64>) -> f64 {
        let twist = Vector6::from(twist.get());
        let rates = self.legs(ring).map(|leg| leg.jacobian_row().dot(&twist));
        rates
            .iter()
            .map(|rate| self.damping_n_s_per_m * rate * rate)
            .sum()
    }

    /// `Jᵀ (c + k step) J`: resistance of the legs to a twist of the ring that lasts for a step, N·s/m.
    pub(crate) fn resistance(&self, ring: &Pose<f64>, step_s: f64) -> Matrix6<f64> {
        let legs = self.legs(ring);
        (0..6).fold(Matrix6::zeros(), |sum, i| {
            let row = legs[i].jacobian_row();
            sum + row * row.transpose() * (self.damping_n_s_per_m + self.stiffness(i) * step_s)
        })
    }

    /// Stiffness and damping along x, with the ring at rest.
    pub(crate) fn axial(&self) -> Joint {
        let legs = self.legs(&Pose::identity());
        let sum = |each: &dyn Fn(usize) -> f64| {
            (0..6)
                .map(|i| each(i) * legs[i].direction.x.powi(2))
                .sum::<f64>()
        };
        Joint {
            stiffness_n_per_m: sum(&|i| self.stiffness(i)),
            damping_n_s_per_m: sum(&|_| self.damping_n_s_per_m),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use softdock_control::frames::orientation_from_abc;

    pub(crate) const LEGS: Hexapod = Hexapod {
        base_radius_m: 0.7,
        ring_radius_m: 0.65,
        height_m: 0.5,
        spread_rad: 0.15,
        stiffness_n_per_m: 2e4,
        damping_n_s_per_m: 1e3,
        leg_factors: [1.0; 6],
    };

    /// The springs alone have the stiffness `Jᵀ K J` for small displacements. With three-fold symmetry it has equal entries
    /// for y and z, and couples only y with the angle about z, and z with the angle about y.
    #[test]
    fn stiffness_is_that_of_the_jacobian() {
        let tensor =
            LEGS.resistance(&Pose::identity(), 1.0) - LEGS.resistance(&Pose::identity(), 0.0);
        let scale = tensor.amax();
        let coupled =
            |r: usize, c: usize| r == c || matches!((r, c), (1, 5) | (5, 1) | (2, 4) | (4, 2));
        for (r, c) in (0..6).flat_map(|r| (0..6).map(move |c| (r, c))) {
            assert!(
                coupled(r, c) || tensor[(r, c)].abs() < 1e-9 * scale,
                "{r} {c} {tensor}"
            );
        }
        assert!((tensor[(1, 1)] - tensor[(2, 2)]).abs() < 1e-9 * scale);
        assert!((tensor[(4, 4)] - tensor[(5, 5)]).abs() < 1e-9 * scale);
        assert!((tensor[(0, 0)] - LEGS.axial().stiffness_n_per_m).abs() < 1e-6);
        for axis in 0..6 {
            let mut small = [0.0; 6];
            small[axis] = 1e-6;
            let ring = Pose::from_parts(
                Vector3::new(small[0], small[1], small[2]).into(),
                nalgebra::UnitQuaternion::from_scaled_axis(Vector3::new(
                    small[3], small[4], small[5],
                )),
            );
            let wrench = LEGS.wrench(&ring, &LEGS.cells(&ring, &Twist::zero())).get();
            for (row, value) in wrench.iter().enumerate() {
                assert!(
                    (value + tensor[(row, axis)] * 1e-6).abs() < 1e-4,
                    "{row} {axis}"
                );
            }
        }
    }

    /// The load cells of a pose and those computed with `(Jᵀ)⁻¹` correspond to the same wrench.
    #[test]
    fn the_load_cells_weigh_any_wrench() {
        let ring = Pose::from_parts(
            Vector3::new(0.02, -0.05, 0.03).into(),
            orientation_from_abc(&[0.03, -0.05, 0.02]),
        );
        let applied = Vector6::new(300.0, -200.0, 100.0, 40.0, -60.0, 20.0);
        let legs = LEGS.legs(&ring);
        let columns = Matrix6::from_columns(&legs.map(|leg| leg.jacobian_row()));
        let cells = columns.lu().solve(&-applied).unwrap();
        let found = LEGS.wrench(&ring, &cells.into()).get();
        for (found, applied) in found.iter().zip(applied.iter()) {
            assert!((found - applied).abs() < 1e-9, "{found} {applied}");
        }
    }

    /// One soft leg has a smaller force than its neighbours at the same deflection, and only that leg.
    #[test]
    fn a_soft_leg_is_seen_by_its_own_cell() {
        let mut soft = LEGS;
        soft.leg_factors[3] = 0.5;
        let ring = Pose::translation(0.01, 0.0, 0.0);
        let cells = soft.cells(&ring, &Twist::zero());
        let all = LEGS.cells(&ring, &Twist::zero());
        for leg in 0..6 {
            let factor = if leg == 3 { 0.5 } else { 1.0 };
            assert!((cells[leg] - factor * all[leg]).abs() < 1e-9);
        }
    }
}
