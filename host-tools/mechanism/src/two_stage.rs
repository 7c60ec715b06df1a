//! A preloaded two-stage spring with a friction brake, as in shock absorbers of docking probes (Syromiatnikov, Spacecraft
//! Docking Devices).

use crate::{Mechanism, Reaction, Relative};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use softdock_control::range::{SettingsError, in_range};

/// The absorber does not move below `F0 + Ff`. Moving inwards it pushes with `F0 + Ff + k x`, moving back with `F0 − Ff + k
/// x`. From `second_stage_m` on k is that of the stiffer second stage. The head rests on the absorber with a separate
/// stiffness.
///
/// For a mass that arrives with v and leaves with v': `½ m v² = (F0 + Ff) X + ½ k X²`, `½ m v'² = (F0 − Ff) X + ½ k X²`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TwoStage {
    /// F0, preload, N.
    pub preload_n: f64,
    /// k of the first stage, N/m.
    pub stiffness_n_per_m: f64,
    /// Deflection at which the second stage begins, m.
    pub second_stage_m: f64,
    /// k of the second stage, N/m.
    pub second_stiffness_n_per_m: f64,
    /// Ff, friction of the brake, N.
    #[serde(default)]
    pub brake_n: f64,
    /// Stiffness of the head on the absorber, N/m.
    pub seat_stiffness_n_per_m: f64,
    /// Deflection of the absorber, m.
    #[serde(skip)]
    deflection_m: f64,
}

impl TwoStage {
    pub(crate) fn validate(&self) -> Result<(), SettingsError> {
        in_range("preload_n", self.preload_n, 0.0, 1e6)?;
        in_range("stiffness_n_per_m", self.stiffness_n_per_m, 0.0, 1e8)?;
        in_range("second_stage_m", self.second_stage_m, 0.0, 10.0)?;
        in_range(
            "second_stiffness_n_per_m",
            self.second_stiffness_n_per_m,
            0.0,
            1e8,
        )?;
        in_range("brake_n", self.brake_n, 0.0, 1e6)?;
        in_range(
            "seat_stiffness_n_per_m",
            self.seat_stiffness_n_per_m,
            1.0,
            1e9,
        )
    }

    /// Force of the springs at a deflection, N.
    fn spring_n(&self, deflection_m: f64) -> f64 {
        let beyond = (deflection_m - self.second_stage_m).max(0.0);
        let first = deflection_m - beyond;
        self.preload_n + self.stiffness_n_per_m * first + self.second_stiffness_n_per_m * beyond
    }

    /// Energy in the springs, J, without that of the preload at rest.
    fn spring_j(&self, deflection_m: f64) -> f64 {
        let beyond = (deflection_m - self.second_stage_m).max(0.0);
        let first = deflection_m - beyond;
        let at_stage = self.preload_n + self.stiffness_n_per_m * first;
        (self.preload_n + 0.5 * self.stiffness_n_per_m * first) * first
            + (at_stage + 0.5 * self.second_stiffness_n_per_m * beyond) * beyond
    }

    /// Deflection of the absorber while it moves against this friction: solves `k_seat (x − d) = spring(d) + friction`.
    fn yielding(&self, depth_m: f64, friction_n: f64) -> f64 {
        let pressed = self.seat_stiffness_n_per_m * depth_m - self.preload_n - friction_n;
        let first = pressed / (self.seat_stiffness_n_per_m + self.stiffness_n_per_m);
        if first <= self.second_stage_m {
            return first;
        }
        let step = self.stiffness_n_per_m - self.second_stiffness_n_per_m;
        (pressed - step * self.second_stage_m)
            / (self.seat_stiffness_n_per_m + self.second_stiffness_n_per_m)
    }

    /// Deflection at which the brake holds the springs without a push, m: they return the absorber no farther.
    fn stuck_m(&self) -> f64 {
        let held_n = (self.brake_n - self.preload_n).max(0.0);
        let stage_n = self.stiffness_n_per_m * self.second_stage_m;
        if held_n == 0.0 {
            0.0
        } else if held_n <= stage_n {
            held_n / self.stiffness_n_per_m
        } else {
            self.second_stage_m + (held_n - stage_n) / self.second_stiffness_n_per_m
        }
    }

    /// Deflection of the absorber after its head was moved to a depth, m.
    fn settled(&self, depth_m: f64) -> f64 {
        let held = self.deflection_m;
        // The seat cannot pull.
        let push = self.seat_stiffness_n_per_m * (depth_m - held).max(0.0);
        let spring = self.spring_n(held);
        if push > spring + self.brake_n {
            self.yielding(depth_m, self.brake_n).max(held)
        } else if push < spring - self.brake_n && held > 0.0 {
            let yielding = self.yielding(depth_m, -self.brake_n);
            yielding.max(self.stuck_m()).min(held)
        } else {
            held
        }
    }
}

impl Mechanism for TwoStage {
    fn reaction(&self, at: &Relative) -> Reaction {
        let position = at.p_from_j.translation.vector;
        let deflection = self.settled(position.x);
        let seat = (position.x - deflection).max(0.0);
        let push = self.seat_stiffness_n_per_m * seat;
        Reaction {
            wrench: at.push(&position, &Vector3::new(-push, 0.0, 0.0)),
            stored_j: 0.5 * push * seat + self.spring_j(deflection),
            loss_w: 0.0,
        }
    }

    fn advance(&mut self, at: &Relative, _step_s: f64) -> f64 {
        let before = self.deflection_m;
        self.deflection_m = self.settled(at.p_from_j.translation.vector.x);
        self.brake_n * (self.deflection_m - before).abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Kind;
    use crate::testing::bounce;

    fn absorber(brake_n: f64) -> TwoStage {
        TwoStage {
            preload_n: 300.0,
            stiffness_n_per_m: 5e3,
            second_stage_m: 0.05,
            second_stiffness_n_per_m: 4e4,
            brake_n,
            seat_stiffness_n_per_m: 1e8,
            deflection_m: 0.0,
        }
    }

    /// Depth and restitution from the two energy equations, within the first stage and beyond.
    #[test]
    fn depth_and_restitution_follow_from_the_energies() {
        let mass = 5000.0;
        for (speed, brake) in [(0.05, 0.0), (0.05, 100.0), (0.15, 100.0), (0.05, 250.0)] {
            let bounce = bounce(absorber(brake), mass, speed, 2e-6);
            let energy = |x: f64, friction: f64| absorber(0.0).spring_j(x) + friction * x;
            let kinetic = 0.5 * mass * speed * speed;
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if energy(middle, brake) < kinetic {
                    low = middle
                } else {
                    high = middle
                }
            }
            let back = (energy(low, -brake) / kinetic).sqrt();
            assert!(
                (bounce.depth_m / low - 1.0).abs() < 2e-3,
                "{speed} {brake}: {bounce:?} {low}"
            );
            assert!(
                (bounce.restitution - back).abs() < 2e-3,
                "{speed} {brake}: {bounce:?} {back}"
            );
            bounce.assert_balanced(mass, speed, 1e-3);
        }
    }

    /// Up to preload and brake force the head is a wall, beyond it a constant force: there is no linear spring for a critical
    /// delay.
    #[test]
    fn an_absorber_that_stands_on_its_preload_is_no_spring() {
        let met = |preload_n: f64, brake_n: f64| {
            let absorber = TwoStage {
                preload_n,
                ..absorber(brake_n)
            };
            Kind::TwoStage(absorber)
                .first_contact()
                .map(|joint| joint.stiffness_n_per_m)
        };
        assert_eq!(met(300.0, 0.0), None);
        assert_eq!(met(0.0, 100.0), None);
        assert_eq!(met(0.0, 0.0), Some(5e3));
    }

    /// A brake that is stronger than the preload keeps the absorber pressed in as far as the spring is too weak. No seat
    /// pulls it home, and the brake dissipates no more than the spring gives.
    #[test]
    fn a_strong_brake_keeps_it_pressed() {
        for (pressed_m, left_m) in [(0.01, 0.01), (0.03, 0.02), (0.07, 0.02)] {
            let mut absorber = TwoStage {
                preload_n: 0.0,
                ..absorber(100.0)
            };
            absorber.advance(&Relative::along_x(pressed_m, 0.0), 1e-3);
            let stored_j = absorber.spring_j(absorber.deflection_m);
            let heat_j = absorber.advance(&Relative::along_x(-0.1, 0.0), 1e-3);
            assert!(
                (absorber.deflection_m - left_m).abs() < 1e-4,
                "{absorber:?}"
            );
            let given_j = stored_j - absorber.spring_j(absorber.deflection_m);
            assert!(heat_j <= given_j, "{pressed_m}: {heat_j} {given_j}");
        }
    }

    /// Below preload plus brake force only the seat of the head yields.
    #[test]
    fn nothing_moves_below_preload_and_brake() {
        let mut absorber = absorber(100.0);
        for push_n in [100.0, 399.0] {
            let at = Relative::along_x(push_n / 1e8, 0.0);
            assert_eq!(absorber.advance(&at, 1e-3), 0.0);
            assert_eq!(absorber.deflection_m, 0.0);
            assert!((absorber.reaction(&at).wrench.force.x + push_n).abs() < 1e-6);
        }
        absorber.advance(&Relative::along_x(401.0 / 1e8, 0.0), 1e-3);
        assert!(absorber.deflection_m > 0.0);
    }
}
