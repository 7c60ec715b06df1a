//! Soft capture: a ring on six legs, three petals that guide it home, and latches that hold it there.

use crate::contact::{Surface, Touch};
use crate::petals::{Petals, TOUCHES};
use crate::{Hexapod, Joint, Mechanism, Reaction, Relative};
use nalgebra::{Matrix6, UnitQuaternion, Vector3, Vector6};
use serde::{Deserialize, Serialize};
use softdock_control::frames::{Pose, Twist, Wrench};
use softdock_control::range::{SettingsError, in_range};

/// The ring has no mass: its legs balance the contact forces at any time, so it yields as fast as petals and face press it.
/// The latches lock it to the face of J as soon as the face is near the ring all around. From then on only the legs yield.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SoftCapture {
    /// Legs of the ring.
    pub legs: Hexapod,
    /// Petals on the other side.
    pub petals: Petals,
    /// Contact of petals and face with the ring.
    pub surface: Surface,
    /// Widest gap between face and ring at which the latches close, m.
    pub capture_gap_m: f64,
    /// State of the mechanism.
    #[serde(skip)]
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    /// Pose of the ring in P, and its twist (both parts in axes of P).
    ring: Pose<f64>,
    twist: Twist<f64>,
    /// Deflection of the friction spring at each touch of petals and face, m in P.
    friction_m: [Vector3<f64>; TOUCHES],
    /// Force and torque of petals and face on the ring at the end of the last step, about its centre, axes of P.
    pressed: Vector6<f64>,
    /// Pose of the ring in J, once the latches hold it.
    held: Option<Pose<f64>>,
}

impl Default for State {
    fn default() -> Self {
        Self {
            ring: Pose::identity(),
            twist: Twist::zero(),
            friction_m: [Vector3::zeros(); TOUCHES],
            pressed: Vector6::zeros(),
            held: None,
        }
    }
}

impl SoftCapture {
    pub(crate) fn validate(&self) -> Result<(), SettingsError> {
        self.legs.validate()?;
        self.petals.validate()?;
        self.surface.validate()?;
        in_range("capture_gap_m", self.capture_gap_m, 1e-5, 0.1)
    }

    /// Stiffness and damping along x of the face on the ring, in series with the legs.
    pub(crate) fn first_contact(&self) -> Joint {
        let (legs, face) = (self.legs.axial(), 3.0 * self.surface.stiffness_n_per_m);
        Joint {
            stiffness_n_per_m: face * legs.stiffness_n_per_m / (face + legs.stiffness_n_per_m),
            ..legs
        }
    }

    /// Readings of the load cells of the legs, N; pull is positive.
    pub fn load_cells(&self, at: &Relative) -> [f64; 6] {
        let (ring, twist) = self.ring(at);
        self.legs.cells(&ring, &twist)
    }

    /// Pose and twist of the ring: those at the end of the last step, or, once latched, those that follow from J.
    fn ring(&self, at: &Relative) -> (Pose<f64>, Twist<f64>) {
        let Some(held) = &self.state.held else {
            return (self.state.ring, self.state.twist);
        };
        let ring = at.p_from_j * held;
        let twist = Twist {
            linear: at.velocity_at(&ring.translation.vector),
            angular: at.p_from_j.rotation * at.twist.angular,
        };
        (ring, twist)
    }

    /// Velocity of J relative to the ring at a point, both in P, m/s.
    fn sliding(&self, at: &Relative, point: &Vector3<f64>, ring: &Twist<f64>) -> Vector3<f64> {
        let lever = point - self.state.ring.translation.vector;
        at.velocity_at(point) - ring.linear - ring.angular.cross(&lever)
    }

    /// Twist of the ring over a step that ends here. With it the legs balance the mean of the contact forces at both ends of
    /// the step (trapezoidal rule, so that the integration loses no energy).
    fn yielding(&self, at: &Relative, touches: &[Touch; TOUCHES], step_s: f64) -> Twist<f64> {
        let State {
            ring,
            friction_m,
            pressed,
            ..
        } = &self.state;
        let still = self.legs.cells(ring, &Twist::zero());
        let mut push = Vector6::from(self.legs.wrench(ring, &still).get()) + pressed * 0.5;
        let mut resistance = self.legs.resistance(ring, 0.5 * step_s);
        for (touch, friction_m) in touches
            .iter()
            .zip(friction_m)
            .filter(|(t, _)| t.depth_m > 0.0)
        {
            let stretched = friction_m + at.velocity_at(&touch.point) * step_s;
            let force = self
                .surface
                .push(touch, &Vector3::zeros(), &stretched)
                .force;
            push -= on_ring(ring, &touch.point, &force) * 0.5;
            let mut stiffen = |direction: &Vector3<f64>| {
                let along = on_ring(ring, &touch.point, direction);
                resistance +=
                    along * along.transpose() * (0.5 * self.surface.stiffness_n_per_m * step_s);
            };
            if self.surface.sticks(touch, &stretched) {
                (0..3).for_each(|axis| stiffen(&Vector3::ith(axis, 1.0)));
            } else {
                stiffen(&touch.normal);
            }
        }
        Twist::of(&solved(&resistance, &push).into())
    }

    /// Force and torque of petals and face on the ring.
    fn pressing(&self, touches: &[Touch; TOUCHES]) -> Vector6<f64> {
        let ring = &self.state.ring;
        let each = touches
            .iter()
            .zip(&self.state.friction_m)
            .map(|(touch, friction_m)| {
                let push = self.surface.push(touch, &Vector3::zeros(), friction_m);
                -on_ring(ring, &touch.point, &push.force)
            });
        each.sum()
    }

    /// Reaction of petals and face on J.
    fn pushes(&self, at: &Relative, touches: &[Touch; TOUCHES]) -> Reaction {
        let mut sum = Reaction::none();
        for (touch, friction_m) in touches.iter().zip(&self.state.friction_m) {
            let sliding = self.sliding(at, &touch.point, &self.state.twist);
            let push = self.surface.push(touch, &sliding, friction_m);
            sum = sum
                + Reaction {
                    wrench: at.push(&touch.point, &push.force),
                    stored_j: push.stored_j,
                    loss_w: push.loss_w,
                };
        }
        sum
    }
}

/// A force at a point as force and torque about the ring's centre, all in axes of P.
fn on_ring(ring: &Pose<f64>, point: &Vector3<f64>, force: &Vector3<f64>) -> Vector6<f64> {
    let torque = (point - ring.translation.vector).cross(force);
    Vector6::new(force.x, force.y, force.z, torque.x, torque.y, torque.z)
}

/// Solves `resistance · twist = push`. The resistance of six legs that are not in one line is positive definite; zero
/// otherwise.
fn solved(resistance: &Matrix6<f64>, push: &Vector6<f64>) -> Vector6<f64> {
    match resistance.cholesky() {
        Some(factors) => factors.solve(push),
        None => Vector6::zeros(),
    }
}

impl Mechanism for SoftCapture {
    fn reaction(&self, at: &Relative) -> Reaction {
        let (ring, twist) = self.ring(at);
        let stored_j = self.legs.stored_j(&ring);
        let loss_w = self.legs.loss_w(&ring, &twist);
        if self.state.held.is_none() {
            let pushes = self.pushes(at, &self.petals.touches(&at.p_from_j, &ring));
            return pushes
                + Reaction {
                    wrench: Wrench::zero(),
                    stored_j,
                    loss_w,
                };
        }
        let on_ring = self.legs.wrench(&ring, &self.legs.cells(&ring, &twist));
        let mut wrench = at.push(&ring.translation.vector, &on_ring.force);
        wrench.torque += at.p_from_j.rotation.inverse() * on_ring.torque;
        Reaction {
            wrench,
            stored_j,
            loss_w,
        }
    }

    fn advance(&mut self, at: &Relative, step_s: f64) -> f64 {
        if self.state.held.is_some() {
            return 0.0;
        }
        let touches = self.petals.touches(&at.p_from_j, &self.state.ring);
        let twist = self.yielding(at, &touches, step_s);
        let mut lost_j = 0.0;
        for (i, touch) in touches.iter().enumerate() {
            let sliding = self.sliding(at, &touch.point, &twist);
            let (held, lost) =
                self.surface
                    .slide(touch, &sliding, &self.state.friction_m[i], step_s);
            self.state.friction_m[i] = held;
            lost_j += lost;
        }
        let ring = &mut self.state.ring;
        ring.translation.vector += twist.linear * step_s;
        ring.rotation = UnitQuaternion::from_scaled_axis(twist.angular * step_s) * ring.rotation;
        self.state.twist = twist;
        let touches = self.petals.touches(&at.p_from_j, &self.state.ring);
        self.state.pressed = self.pressing(&touches);
        let gap_m = self.petals.gap_m(&at.p_from_j, &self.state.ring);
        if gap_m.is_some_and(|gap_m| gap_m <= self.capture_gap_m) {
            lost_j += self.pushes(at, &touches).stored_j; // what petals and face stored is locked in
            self.state.held = Some(at.p_from_j.inverse() * self.state.ring);
        }
        lost_j
    }

    fn captured(&self) -> bool {
        self.state.held.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::EnergyTracked;
    use crate::hexapod::tests::LEGS;
    use crate::testing::{Body, Pair};

    fn ring(friction_coefficient: f64) -> SoftCapture {
        SoftCapture {
            legs: LEGS,
            petals: Petals {
                angle_rad: 0.7,
                length_m: 0.2,
                clearance_m: 0.003,
                edge_radius_m: 0.6,
            },
            surface: Surface {
                stiffness_n_per_m: 5e5,
                damping_n_s_per_m: 0.0,
                friction_coefficient,
            },
            capture_gap_m: 0.002,
            state: State::default(),
        }
    }

    /// A mass of 15 t that flies at 0.1 m/s towards 350 t, `offset_m` off the axis.
    fn pair(offset_m: f64) -> Pair {
        let (k, q) = ([2.0e4, 5.0e4, 5.0e4], [1e7, 3e7, 3e7]);
        Pair {
            k: Body::new(15e3, k, [-2.25, offset_m, 0.0], 0.1),
            q: Body::new(350e3, q, [10.0, 0.0, 0.0], 0.0),
            k_from_j: [2.0, 0.0, 0.0].into(),
            q_from_p: [-10.0, 0.0, 0.0].into(),
        }
    }

    /// Pressed without offset, the petals act as the wall of a cone, with k sin²γ each along x. The face acts with k at each
    /// of the same three places. The legs are in series with both.
    #[test]
    fn the_symmetric_case_is_a_cone_on_legs() {
        let mut mechanism = ring(0.0);
        (mechanism.petals.clearance_m, mechanism.capture_gap_m) = (0.0, -1.0);
        let surface = 3.0 * 5e5 * (1.0 + 0.7_f64.sin().powi(2));
        let legs = LEGS.axial().stiffness_n_per_m;
        let first = surface * legs / (surface + legs);
        let at = Relative::along_x(1e-3, 0.0);
        for _ in 0..20_000 {
            mechanism.advance(&at, 1e-3);
        }
        let push = mechanism.reaction(&at).wrench.force;
        assert!(
            (push.x / (-first * 1e-3) - 1.0).abs() < 1e-2,
            "{push} {first}"
        );
        assert!(push.y.abs() + push.z.abs() < 1e-6, "{push}");
        // The load cells give the same force.
        let weighed = mechanism
            .legs
            .wrench(&mechanism.state.ring, &mechanism.load_cells(&at));
        assert!(
            (weighed.force.x - push.x).abs() < 1e-6 * push.x.abs(),
            "{weighed:?} {push}"
        );
    }

    /// From 0.10 m beside the axis the petals guide the ring home and the latches close, unless the friction coefficient is
    /// above cot γ. Momentum is conserved, and the energy balance holds.
    #[test]
    fn petals_centre_a_lateral_offset() {
        for (friction, home) in [(0.0, true), (0.2, true), (1.3, false)] {
            let mut pair = pair(0.1);
            let (before, energy) = (pair.momentum(), pair.kinetic_j());
            let mut tracked = EnergyTracked::new(ring(friction));
            for _ in 0..60_000 {
                let at = pair.relative();
                let wrench = tracked.advance(&at, 2e-4).wrench;
                pair.step(&wrench, 2e-4);
            }
            assert_eq!(
                tracked.mechanism.captured(),
                home,
                "{friction}: {:?}",
                pair.relative()
            );
            let after = pair.momentum();
            assert!((after.0 - before.0).norm() < 1e-7 && (after.1 - before.1).norm() < 1e-6);
            let balance = tracked.balance();
            assert!(
                balance.imbalance_j().abs() < 0.01 * energy,
                "{friction}: {balance:?}"
            );
            let left = pair.kinetic_j() + balance.stored_j + balance.dissipated_j;
            assert!(
                (left / energy - 1.0).abs() < 0.01,
                "{friction}: {left} of {energy}, {balance:?}"
            );
        }
    }

    /// Once latched, J moves against the legs alone.
    #[test]
    fn a_locked_ring_is_rigid() {
        let mut mechanism = ring(0.2);
        mechanism.state.held = Some(Pose::identity());
        let at = Relative {
            p_from_j: Pose::translation(0.01, -0.005, 0.002),
            twist: Twist::zero(),
        };
        let cells = mechanism.load_cells(&at);
        let of_cells = LEGS.wrench(&at.p_from_j, &cells);
        let wrench = mechanism.reaction(&at).wrench;
        for (a, b) in wrench.get().iter().zip(of_cells.get()) {
            assert!((a - b).abs() < 1e-9, "{wrench:?} {of_cells:?}");
        }
    }
}
