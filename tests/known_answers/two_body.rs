//! Two free spacecraft: what the pair of contact wrenches conserves, and how one spacecraft moves as seen
//! from the other.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use softdock_control::dynamics::{BodyState, TwoBody, TwoBodyState, relative_velocity};
use softdock_control::frames::{Twist, Wrench, components, pose};
use softdock_control::scalar::{Fixed, Scalar};
use softdock_control::settings::BodySettings;

const CYCLE_S: f64 = 0.004;
const CYCLES: u32 = 250;

type Vector = Vector3<f64>;

/// Motion of a spacecraft as plain numbers.
#[derive(Clone, Copy, Debug)]
struct Motion {
    position: [f64; 3],
    turn: [f64; 3],
    velocity: [f64; 3],
    spin: [f64; 3],
}

fn any_motion() -> impl Strategy<Value = Motion> {
    use prop::array::uniform3 as three;
    let (far, turn) = (three(-2.0..2.0f64), three(-2.0..2.0f64));
    (far, turn, three(-0.05..0.05f64), three(-0.1..0.1f64)).prop_map(
        |(position, turn, velocity, spin)| Motion {
            position,
            turn,
            velocity,
            spin,
        },
    )
}

impl Motion {
    fn rotation(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_scaled_axis(Vector::from(self.turn))
    }

    fn settings(&self, mass_kg: f64) -> BodySettings {
        let q = self.rotation();
        BodySettings {
            mass_kg,
            inertia_kg_m2: [[80.0, 5.0, 0.0], [5.0, 150.0, -3.0], [0.0, -3.0, 210.0]],
            position_m: self.position,
            orientation_wxyz: [q.w, q.i, q.j, q.k],
            velocity_m_s: self.velocity,
            angular_velocity_rad_s: self.spin,
            ..BodySettings::default()
        }
    }

    /// The exact pose after a (small or negative) time of constant velocity and spin.
    fn pose_after(&self, time_s: f64) -> Isometry3<f64> {
        let position = Vector::from(self.position) + Vector::from(self.velocity) * time_s;
        let turn = UnitQuaternion::from_scaled_axis(Vector::from(self.spin) * time_s);
        Isometry3::from_parts(position.into(), self.rotation() * turn)
    }

    fn state<S: Scalar>(&self) -> BodyState<S> {
        let q = self.rotation();
        BodyState {
            c_from_body: pose(&self.position, &[q.w, q.i, q.j, q.k]),
            velocity: Twist {
                linear: softdock_control::frames::vector(&self.velocity),
                angular: softdock_control::frames::vector(&self.spin),
            },
        }
    }
}

/// Linear and angular momentum of both spacecraft about the origin of C.
fn momentum<S: Scalar>(bodies: &TwoBody<S>, state: &TwoBodyState<S>) -> (Vector, Vector) {
    let (k, q) = (bodies.k.momentum(&state.k), bodies.q.momentum(&state.q));
    let sum =
        |a: &Vector3<S>, b: &Vector3<S>| Vector::from(components(a)) + Vector::from(components(b));
    (sum(&k.0, &q.0), sum(&k.1, &q.1))
}

/// A second under a wrench that is fixed to K. An explicit step holds each wrench while levers
/// and axes move on, which costs no more than Ts²/2 (|v_K − v_Q| |F| + |ω| |T|) of angular
/// momentum per cycle; `rounding` (linear, angular) is what the scalar type adds.
fn momentum_stays<S: Scalar>(
    k: &Motion,
    q: &Motion,
    wrench: &[f64; 6],
    rounding: (f64, f64),
) -> Result<(), TestCaseError> {
    let bodies = TwoBody::<S>::new(&k.settings(500.0), &q.settings(2000.0), CYCLE_S);
    let on_k = Wrench::of(wrench);
    let mut state = TwoBodyState {
        k: k.state(),
        q: q.state(),
    };
    let before = momentum(&bodies, &state);
    let mut bound = 0.0;
    for _ in 0..CYCLES {
        let (next, on_q) = bodies.step(&state, &on_k);
        state = next;
        let (k, q) = (&state.k.velocity, &state.q.velocity);
        let rate = (k.linear - q.linear).norm() * on_k.force.norm()
            + k.angular.norm() * on_k.torque.norm()
            + q.angular.norm() * on_q.torque.norm();
        bound += 0.5 * CYCLE_S * CYCLE_S * rate.get();
    }
    let after = momentum(&bodies, &state);
    let change = ((after.0 - before.0).norm(), (after.1 - before.1).norm());
    prop_assert!(change.0 < rounding.0, "linear {change:?}");
    prop_assert!(
        change.1 < bound + rounding.1,
        "angular {change:?}, bound {bound}"
    );
    Ok(())
}

/// The two wrenches of one step, taken to one point, cancel.
fn pair_cancels<S: Scalar>(
    k: &Motion,
    q: &Motion,
    wrench: &[f64; 6],
    about: &[f64; 3],
    tolerance: f64,
) -> Result<(), TestCaseError> {
    let bodies = TwoBody::<S>::new(&k.settings(500.0), &q.settings(2000.0), CYCLE_S);
    let state = TwoBodyState {
        k: k.state(),
        q: q.state(),
    };
    let (_, on_q) = bodies.step(&state, &Wrench::of(wrench));
    let in_c = |motion: &Motion, [fx, fy, fz, tx, ty, tz]: [f64; 6]| {
        let turn = motion.rotation();
        let (force, torque) = (
            turn * Vector::new(fx, fy, fz),
            turn * Vector::new(tx, ty, tz),
        );
        let lever = Vector::from(motion.position) - Vector::from(*about);
        (force, torque + lever.cross(&force))
    };
    let (a, b) = (in_c(k, *wrench), in_c(q, on_q.get()));
    prop_assert!((a.0 + b.0).norm() < tolerance, "force {a:?} {b:?}");
    prop_assert!((a.1 + b.1).norm() < tolerance, "moment {a:?} {b:?}");
    Ok(())
}

/// v_K − v_Q − ω_Q × p and ω_K − ω_Q against the difference of two exact relative poses.
fn relative_motion_is_the_derivative<S: Scalar>(
    k: &Motion,
    q: &Motion,
    tolerance: f64,
) -> Result<(), TestCaseError> {
    let h = 1e-4;
    let q_from_k = |t: f64| q.pose_after(t).inverse() * k.pose_after(t);
    let (before, now, after) = (q_from_k(-h), q_from_k(0.0), q_from_k(h));
    let linear = (after.translation.vector - before.translation.vector) / (2.0 * h);
    let turned = (before.rotation.inverse() * after.rotation).scaled_axis() / (2.0 * h);
    let found = relative_velocity(&k.state::<S>(), &q.state::<S>());
    let error = Vector::from(components(&found.linear)) - linear;
    prop_assert!(error.norm() < tolerance, "{found:?} {linear}");
    let error = Vector::from(components(&found.angular)) - turned;
    prop_assert!(error.norm() < tolerance, "{found:?} {turned} at {now}");
    Ok(())
}

fn any_wrench() -> impl Strategy<Value = [f64; 6]> {
    prop::array::uniform6(-50.0..50.0f64)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// f64: rounding of 250 steps. f32: 4e-5 kg·m/s per addition to a momentum of 500, levers of
    /// 3 m. Fixed: 2000 kg × 0.23 nm/s × 250, likewise.
    #[test]
    fn action_and_reaction_conserve_momentum(
        k in any_motion(), q in any_motion(), wrench in any_wrench(),
    ) {
        momentum_stays::<f64>(&k, &q, &wrench, (1e-10, 1e-9))?;
        momentum_stays::<f32>(&k, &q, &wrench, (1e-2, 3e-2))?;
        momentum_stays::<Fixed>(&k, &q, &wrench, (3e-4, 1e-3))?;
    }

    /// f64: rounding of 300 N·m. f32: 300 N·m × 6e-8 × some twenty operations. Fixed: a unit
    /// quaternion is good to 1e-9, times 300 N·m.
    #[test]
    fn a_pair_of_wrenches_cancels_about_any_point(
        k in any_motion(), q in any_motion(), wrench in any_wrench(),
        about in prop::array::uniform3(-3.0..3.0f64),
    ) {
        pair_cancels::<f64>(&k, &q, &wrench, &about, 1e-11)?;
        pair_cancels::<f32>(&k, &q, &wrench, &about, 5e-4)?;
        pair_cancels::<Fixed>(&k, &q, &wrench, &about, 5e-6)?;
    }

    /// f64: a central difference over 0.1 ms errs by h² ω² v/6 and 1e-15 m / h. f32: 0.6 m/s ×
    /// 6e-8 × some ten operations. Fixed: some ten times 2.3e-10, times a lever of 7 m.
    #[test]
    fn relative_velocity_is_the_derivative_of_the_relative_pose(
        k in any_motion(), q in any_motion(),
    ) {
        relative_motion_is_the_derivative::<f64>(&k, &q, 1e-9)?;
        relative_motion_is_the_derivative::<f32>(&k, &q, 2e-6)?;
        relative_motion_is_the_derivative::<Fixed>(&k, &q, 2e-8)?;
    }
}
