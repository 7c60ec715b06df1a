//! The law learns the delay of robots that are later or earlier than believed.

use super::*;
use crate::delay::SentHistory;
use crate::dynamics::{BodyState, TwoBody, TwoBodyState};
use crate::frames::{Twist, Wrench};
use crate::scalar::Fixed;
use crate::settings::BodySettings;
use nalgebra::UnitQuaternion;

/// Flies to and fro in front of a robot that is late by whole cycles; the delay that was learned, s.
fn learned<S: Scalar>(believed_s: f64, true_cycles: usize, latency: u8) -> f64 {
    let ts = 0.004;
    let mut settings = DelaySettings::default();
    settings.actuator.delay_s = believed_s;
    settings.actuator.feedback_latency_cycles = latency;
    let mut law = Ats::<S>::new(&settings, ts);
    let body = BodySettings::default();
    let bodies = TwoBody::new(&body, &body, ts);
    let at_rest = BodyState::initial(&body);
    let state = TwoBodyState {
        k: at_rest,
        q: at_rest,
    };
    let mut sent = SentHistory::new();
    let mut positions = vec![0.0];
    let mut answer = 0.0;
    for n in 0..750 {
        let t = f64::from(n) * ts;
        let model = Twist::of(&[0.01 * (8.0 * t).sin(), 0.0, 0.0, 0.0, 0.0, 0.0]);
        let at = |back: usize| positions[positions.len().saturating_sub(1 + back)];
        let pose = |x: f64| {
            Pose::from_parts(
                nalgebra::Vector3::new(S::of(x), S::zero(), S::zero()).into(),
                UnitQuaternion::identity(),
            )
        };
        let input = LawInput {
            model,
            model_end: model,
            wrench: &Wrench::zero(),
            measured: &pose(at(true_cycles + usize::from(latency))),
            commanded: &pose(at(0)),
            sent: &sent,
            bodies: &bodies,
            state: &state,
            c_from_q: UnitQuaternion::identity(),
            released: true,
            frozen: false,
        };
        let output = law.step(&input);
        answer = output.status.delay_s;
        sent.write(output.command);
        positions.push(at(0) + output.command.linear.x.get() * ts);
    }
    answer
}

#[test]
fn the_delay_of_the_robot_is_learned() {
    for (believed, cycles) in [(0.032, 8), (0.032, 10), (0.032, 6), (0.024, 8)] {
        let wanted = cycles as f64 * 0.004;
        let found = learned::<f64>(believed, cycles, 0);
        assert!(
            (found - wanted).abs() < 1.5e-3,
            "{believed} {cycles}: {found}"
        );
        let found = learned::<Fixed>(believed, cycles, 0);
        assert!(
            (found - wanted).abs() < 1.5e-3,
            "{believed} {cycles}: {found}"
        );
    }
}

#[test]
fn a_known_latency_of_the_pose_is_no_delay_of_the_robot() {
    let found = learned::<f64>(0.032, 8, 3);
    assert!((found - 0.032).abs() < 1.5e-3, "{found}");
}

#[test]
fn what_is_learned_stays_within_its_bounds() {
    let found = learned::<f64>(0.016, 30, 0);
    assert!(found <= 0.016 * 1.5 / 0.95 + 1e-9, "{found}");
}
