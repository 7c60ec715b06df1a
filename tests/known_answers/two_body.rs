//! Two free spacecraft: what the pair of contact wrenches conserves, and how the docking surface of one, J (= N) on K,
//! moves as seen from that of the other, P on Q.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use softdock_control::dynamics::{BodyState, ObservationFrames, TwoBody, TwoBodyState};
use softdock_control::frames::{Twist, Wrench, components, pose};
use softdock_control::scalar::{Fixed, Scalar};
use softdock_control::settings::{BodySettings, FrameSettings, Settings};
use softdock_tests::driver::idle;

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

    fn orientation_wxyz(&self) -> [f64; 4] {
        let q = self.rotation();
        [q.w, q.i, q.j, q.k]
    }

    fn settings(&self, mass_kg: f64) -> BodySettings {
        BodySettings {
            mass_kg,
            inertia_kg_m2: [[80.0, 5.0, 0.0], [5.0, 150.0, -3.0], [0.0, -3.0, 210.0]],
            position_m: self.position,
            orientation_wxyz: self.orientation_wxyz(),
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
        BodyState {
            c_from_body: pose(&self.position, &self.orientation_wxyz()),
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

/// v_J − v_P − ω_P × p and ω_J − ω_P against the difference of two exact relative poses; `j` and `p` are where the surfaces
/// stand on K and Q.
fn relative_motion_is_the_derivative<S: Scalar>(
    [k, q, j, p]: [&Motion; 4],
    tolerance: f64,
) -> Result<(), TestCaseError> {
    let h = 1e-4;
    let p_from_j = |t: f64| {
        let [j, p] = [j, p].map(|surface| surface.pose_after(0.0));
        (q.pose_after(t) * p).inverse() * k.pose_after(t) * j
    };
    let (before, now, after) = (p_from_j(-h), p_from_j(0.0), p_from_j(h));
    let linear = (after.translation.vector - before.translation.vector) / (2.0 * h);
    let turned = (before.rotation.inverse() * after.rotation).scaled_axis() / (2.0 * h);
    let frames = ObservationFrames::<S>::new(&FrameSettings {
        j_position_m: j.position,
        j_orientation_wxyz: j.orientation_wxyz(),
        p_position_m: p.position,
        p_orientation_wxyz: p.orientation_wxyz(),
    });
    let state = TwoBodyState {
        k: k.state(),
        q: q.state(),
    };
    let found = frames.observe(&state).relative_velocity;
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

    /// f64: a central difference over 0.1 ms errs by h² ω² v/6 and 1e-15 m / h. f32: 1 m/s ×
    /// 6e-8 × some thirty operations. Fixed: some ten times 2.3e-10, times a lever of 14 m.
    #[test]
    fn relative_velocity_is_the_derivative_of_the_relative_pose(
        k in any_motion(), q in any_motion(), j in any_motion(), p in any_motion(),
    ) {
        let moved = [&k, &q, &j, &p];
        relative_motion_is_the_derivative::<f64>(moved, 1e-9)?;
        relative_motion_is_the_derivative::<f32>(moved, 4e-6)?;
        relative_motion_is_the_derivative::<Fixed>(moved, 4e-8)?;
    }
}

/// Before the start the surfaces stand where the operator has put them.
#[test]
fn before_the_start_the_initial_conditions_are_seen() {
    let mut settings = Settings::default();
    settings.body_q.position_m = [1.0, 0.0, 0.0];
    settings.frames.j_position_m = [0.25, 0.0, 0.0];
    settings.frames.p_position_m = [-0.25, 0.0, 0.0];
    let driver = idle::<f64>(&settings);
    let seen = driver.cycle.cycle().observe().p_from_j.translation.vector;
    assert!(
        (seen - Vector::new(-0.5, 0.0, 0.0)).norm() < 1e-12,
        "{seen}"
    );
}
