//! Adaptive time series: the lead finds its own coefficients from what the robot did.
//!
//! ```text
//! x_cmd = a₀ x + a₁ x' + a₂ x''       a by least squares from  u = a₀ x_m + a₁ x_m' + a₂ x_m''
//! ```
//!
//! Chae, Kazemibidokhti and Ricles, "Adaptive time series compensator for delay compensation of
//! servo-hydraulic actuator systems for real-time hybrid simulation", Earthquake Engng Struct. Dyn.
//! 42 (2013) 1697. u is the commanded, x_m the measured position: the coefficients invert the robot
//! as it is, and the model's motion goes through the inverse. For a pure delay τ they are 1, τ, τ²/2.
//! The law needs position feedback.
//!
//! Choices that the equation leaves open:
//! - Command and measurement pass the same low-pass (`estimator`), which gives the derivatives of
//!   the measurement and leaves the relation between the two as it is.
//! - The window is exponential (`window_s`). A ridge draws the coefficients to the believed 1, τ, τ²/2, as an approach at
//!   constant speed says nothing about a₂.
//! - Coefficients stay within `bounds` around the believed values; the bounds are fractions of 1, τ and τ²/2.
//! - The command is sent as a velocity with the present coefficients, so that neither the start nor
//!   a changed coefficient is a jump. The derivatives of the model are those of
//!   [`super::lead`].
//! - In each cycle one of the six components solves its equations, in turns, as a solution takes a dozen divisions.
//!
//! The displacement that is lost in a pause at a reversal is not a delay, but is identified as one until it is forgotten.

mod estimator;

use super::axes::{components, saturated, twist};
use super::contact::step;
use super::status::LawStatus;
use super::{DelaySettings, LawInput, LawOutput};
use crate::frames::Pose;
use crate::scalar::Scalar;
use estimator::{Gains, LowPass, Regression};

crate::described! {
/// Settings of the adaptive time series.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct AtsSettings: "delay.ats" {
    /// Time in which a sample's weight falls to 1/e, s.
    pub window_s: f64 = 1.0 => 0.1..=10.0,
    /// Corner of the low-pass on command and measurement, Hz.
    pub filter_hz: f64 = 10.0 => 1.0..=50.0,
    /// Strength of the belief: motion, m, at which data and belief weigh the same. In rad for the
    /// rotations.
    pub ridge_m: f64 = 2e-5 => 1e-6..=1e-2,
    /// Largest deviation of the three coefficients from 1, τ and τ²/2, as a part of these.
    pub bounds: [f64; 3] = [0.05, 0.5, 1.0] => 0.0..=1.0,
}
}

/// Motion, mm or mrad from the start, beyond which a component does not learn: there the sums would
/// leave fixed point.
const FARTHEST_MM: f64 = 1e3;

/// The law on six components.
#[derive(Clone, Debug)]
pub struct Ats<S: Scalar> {
    shared: Shared<S>,
    axes: [Axis<S>; 6],
    /// Commanded pose when the law began; none before.
    start: Option<Pose<S>>,
    /// Component that learns next.
    turn: usize,
    latency_cycles: usize,
}

/// What all components use. Coefficients are in units of `scale`, and derivatives are multiplied by it accordingly.
#[derive(Clone, Copy, Debug)]
struct Shared<S> {
    ts: S,
    per_s: S,
    filter: Gains<S>,
    /// Part of the sums that is kept in a cycle.
    kept: S,
    ridge: S,
    /// Units of the derivatives, s and s²: powers of the believed delay, or of a cycle if longer.
    scale: [S; 3],
    /// Believed coefficients in these units, and how far they may move.
    belief: [S; 3],
    bounds: [S; 3],
    /// Half a cycle by which the model's velocity is late, s.
    model_late: S,
}

/// One component, in mm or mrad.
#[derive(Clone, Copy, Debug)]
struct Axis<S: Scalar> {
    commanded: LowPass<S>,
    measured: LowPass<S>,
    regression: Regression<S>,
    /// Coefficients less the belief.
    learned: [S; 3],
    /// Model velocity of the last cycle and the change before that; none before the first.
    last: Option<S>,
    slope: S,
}

impl<S: Scalar> Ats<S> {
    /// The initial state; `cycle_s` in s.
    pub fn new(settings: &DelaySettings, cycle_s: f64) -> Self {
        let own = &settings.ats;
        let tau = settings.actuator.mean_delay_s();
        let scale = tau.max(cycle_s);
        let ratio = tau / scale;
        let belief = [1.0, ratio, ratio * ratio];
        let kept = nalgebra::ComplexField::exp(-cycle_s / own.window_s);
        // The belief weighs as much as a window full of samples of `ridge_m`.
        let ridge_mm = own.ridge_m * 1e3;
        Self {
            shared: Shared {
                ts: S::of(cycle_s),
                per_s: S::of(1.0 / cycle_s),
                filter: Gains::new(own.filter_hz, cycle_s),
                kept: S::of(kept),
                ridge: S::of(ridge_mm * ridge_mm / (1.0 - kept)),
                scale: [1.0, scale, 0.5 * scale * scale].map(S::of),
                belief: belief.map(S::of),
                bounds: core::array::from_fn(|i| S::of(own.bounds[i] * belief[i])),
                model_late: S::of(settings.half_cycle_s(cycle_s)),
            },
            axes: [Axis::new(); 6],
            start: None,
            turn: 0,
            latency_cycles: settings.actuator.feedback_latency_cycles.into(),
        }
    }

    /// One cycle. Parts: (a₀ − 1) v, the term of v', the term of v''. The status reports the delay that was learned along the
    /// axis that moves fastest.
    pub fn step(&mut self, input: &LawInput<'_, S>) -> LawOutput<S> {
        self.learn(input);
        let mut command = components(&input.model);
        let fastest = fastest(&command);
        let mut parts = [[S::zero(); 6]; 3];
        for (i, (axis, v)) in self.axes.iter_mut().zip(&mut command).enumerate() {
            let added = axis.lead(*v, &self.shared);
            for (part, added) in parts.iter_mut().zip(added) {
                part[i] = added;
                *v += added;
            }
            *v = saturated(*v);
        }
        let mut output = LawOutput::of(twist(command));
        for (part, components) in output.parts.iter_mut().zip(parts) {
            *part = twist(components);
        }
        output.status = LawStatus {
            delay_s: self.delay_s(fastest),
            latency_cycles: self.latency_cycles as u16,
            ..LawStatus::default()
        };
        output
    }

    /// Delay that a component has learned, a₁ / a₀, s.
    fn delay_s(&self, axis: usize) -> f64 {
        let [a0, a1, _] = self.axes[axis].coefficients(&self.shared);
        (a1 / a0 * self.shared.scale[1]).get()
    }

    fn learn(&mut self, input: &LawInput<'_, S>) {
        let start = *self.start.get_or_insert(*input.commanded);
        // The commanded pose at the time of the reported pose.
        let mut commanded = components(&step(&start, input.commanded));
        let recent = input.sent.oldest_ordered().rev().take(self.latency_cycles);
        for sent in recent.map(components) {
            commanded = core::array::from_fn(|i| commanded[i] - sent[i] * self.shared.ts);
        }
        let measured = components(&step(&start, input.measured));
        for (i, axis) in self.axes.iter_mut().enumerate() {
            let to_mm = S::of(1e3);
            axis.observe(commanded[i] * to_mm, measured[i] * to_mm, &self.shared);
        }
        self.turn = (self.turn + 1) % self.axes.len();
        self.axes[self.turn].solve(&self.shared);
    }
}

impl<S: Scalar> Axis<S> {
    fn new() -> Self {
        Self {
            commanded: LowPass::new(),
            measured: LowPass::new(),
            regression: Regression::new(),
            learned: [S::zero(); 3],
            last: None,
            slope: S::zero(),
        }
    }

    /// a₀, a₁, a₂ in units of the scale.
    fn coefficients(&self, shared: &Shared<S>) -> [S; 3] {
        core::array::from_fn(|i| shared.belief[i] + self.learned[i])
    }

    /// Takes commanded and measured motion, mm, into the sums.
    fn observe(&mut self, commanded: S, measured: S, shared: &Shared<S>) {
        let limit = S::of(FARTHEST_MM);
        let clamp = |v: S| v.clamp(-limit, limit);
        self.commanded
            .step(clamp(commanded), &shared.filter, shared.ts);
        self.measured
            .step(clamp(measured), &shared.filter, shared.ts);
        if commanded.abs().max(measured.abs()) >= limit {
            return;
        }
        let [x, dx, ddx] = self.measured.derivatives();
        // The first difference is half a cycle late.
        let dx = dx + ddx * shared.ts * S::of(0.5);
        let [_, one, two] = shared.scale;
        let row = [x, clamp(dx * one), clamp(ddx * two)];
        let believed = row
            .iter()
            .zip(shared.belief)
            .fold(S::zero(), |sum, (z, b)| sum + *z * b);
        let [u, ..] = self.commanded.derivatives();
        self.regression.push(&row, clamp(u - believed), shared.kept);
    }

    fn solve(&mut self, shared: &Shared<S>) {
        let found = self.regression.solve(shared.ridge);
        self.learned =
            core::array::from_fn(|i| found[i].clamp(-shared.bounds[i], shared.bounds[i]));
    }

    /// The terms that are added to the model's velocity: of a₀ − 1, of v', of v''.
    fn lead(&mut self, v: S, shared: &Shared<S>) -> [S; 3] {
        let slope = v - self.last.unwrap_or(v);
        let curvature = slope - self.slope;
        (self.last, self.slope) = (Some(v), slope);
        let [a0, a1, a2] = self.coefficients(shared);
        let [_, one, two] = shared.scale;
        // In cycles: the robot's coefficients, then the model's own delay on top of them.
        let late = shared.model_late * shared.per_s;
        let first = a1 * one * shared.per_s;
        let half = S::of(0.5);
        let second = a2 * two * shared.per_s * shared.per_s + first * late + late * late * half;
        let first = first + late;
        [
            (a0 - S::one()) * v,
            first * slope,
            (second + first * half) * curvature,
        ]
        .map(saturated)
    }
}

fn fastest<S: Scalar>(velocity: &[S; 6]) -> usize {
    (1..6).fold(0, |best, i| {
        if velocity[i].abs() > velocity[best].abs() {
            i
        } else {
            best
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::spacecraft::{CYCLE_S, Spacecraft};
    use crate::delay::{ModelVelocity, SentHistory};
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

    /// Without anything learned it is a second-order lead, which continues a parabola by the delay, and by half a cycle if the
    /// model's velocity is that much late.
    #[test]
    fn a_parabola_of_velocity_is_continued_by_the_believed_delay() {
        for (model_velocity, later_s) in [(ModelVelocity::End, 0.0), (ModelVelocity::Mean, 0.002)] {
            for delay_s in [0.0, 0.002, 0.032] {
                let mut settings = DelaySettings {
                    model_velocity,
                    ..DelaySettings::default()
                };
                settings.actuator.delay_s = delay_s;
                let mut law = Ats::<f64>::new(&settings, CYCLE_S);
                let v = |t: f64| 0.003 - 0.02 * t + 0.05 * t * t;
                let spacecraft = Spacecraft::before_a_wall([0.0; 3]);
                for n in 0..12 {
                    let t = f64::from(n) * CYCLE_S;
                    let parts = [1.0, 0.0, -2.0, 0.5, 0.0, 3.0];
                    let model = Twist::of(&parts.map(|part| part * v(t)));
                    let output = law.step(&spacecraft.asked(&Wrench::zero(), model));
                    let wanted = v(t + delay_s + later_s);
                    for (found, part) in output.command.get().into_iter().zip(parts) {
                        let apart = found - part * wanted;
                        assert!(n < 2 || apart.abs() < 1e-12, "{delay_s} {n}: {found}");
                    }
                    let sum = output.parts.iter().fold(model, |sum, part| sum + *part);
                    let apart = (sum - output.command).get();
                    assert!(apart.iter().all(|apart| apart.abs() < 1e-15));
                    assert!((output.status.delay_s - delay_s).abs() < 1e-12);
                }
            }
        }
    }

    /// Each of the six components moves fastest in turn; the status reports the delay of that one.
    #[test]
    fn the_delay_that_is_told_is_that_of_the_fastest_component() {
        let mut law = Ats::<f64>::new(&DelaySettings::default(), CYCLE_S);
        for (i, axis) in law.axes.iter_mut().enumerate() {
            axis.learned[0] = 0.05;
            axis.learned[1] = 0.1 * i as f64;
        }
        for (velocity, i) in [
            ([0.5, 0.1, 0.1, 0.1, 0.1, 0.1], 0),
            ([0.1, -0.5, 0.1, 0.1, 0.1, 0.1], 1),
            ([0.1, 0.1, 0.1, 0.1, 0.1, -0.5], 5),
            ([0.1, 0.1, 0.1, 0.4, 0.3, 0.2], 3),
        ] {
            let found = law.delay_s(fastest(&velocity));
            assert!(
                (found - 0.032 * (1.0 + 0.1 * i as f64) / 1.05).abs() < 1e-12,
                "{velocity:?}"
            );
        }
    }

    /// u = z + τ z' + ½ τ² z'' of a parabola in mm, whose derivatives the low-pass leaves exact; checked for each component in
    /// its turn.
    #[test]
    fn the_coefficients_of_a_robot_are_learned_by_every_component() {
        for (believed_s, true_s) in [(0.030, 0.032), (0.032, 0.028)] {
            let mut settings = DelaySettings::default();
            (settings.actuator.delay_s, settings.ats.ridge_m) = (believed_s, 1e-6);
            let mut law = Ats::<f64>::new(&settings, CYCLE_S);
            let z = |t: f64| [300.0 * t * t, 600.0 * t, 600.0];
            for n in 0..400 {
                let [x, dx, ddx] = z(f64::from(n) * CYCLE_S);
                let u = x + true_s * dx + 0.5 * true_s * true_s * ddx;
                let at = |mm: f64| {
                    let position = nalgebra::Vector3::repeat(1e-3 * mm);
                    let turn =
                        nalgebra::Quaternion::new(1.0, 0.5e-3 * mm, 0.5e-3 * mm, 0.5e-3 * mm);
                    Pose::from_parts(position.into(), UnitQuaternion::new_unchecked(turn))
                };
                let mut spacecraft = Spacecraft::before_a_wall([0.0; 3]);
                spacecraft.measured = at(x);
                let (wrench, commanded) = (Wrench::zero(), at(u));
                let mut input = spacecraft.input(&wrench);
                input.commanded = &commanded;
                law.start = Some(Pose::identity());
                law.learn(&input);
            }
            for i in 0..6 {
                let [a0, _, a2] = law.axes[i].coefficients(&law.shared);
                let found = law.delay_s(i);
                assert!((found - true_s).abs() < 3e-5, "{i}: {found}");
                assert!((a0 - 1.0).abs() < 1e-3, "{i}: {a0}");
                let half_squared = a2 * law.shared.scale[2] / (0.5 * true_s * true_s);
                assert!((half_squared - 1.0).abs() < 0.1, "{i}: {half_squared}");
            }
        }
    }

    /// A window of 1.5 s of samples of 20 µm weighs as much as the prior.
    #[test]
    fn the_belief_weighs_as_much_as_a_window_of_small_samples() {
        let mut settings = DelaySettings::default();
        (settings.ats.window_s, settings.ats.ridge_m) = (1.5, 2e-5);
        let law = Ats::<f64>::new(&settings, CYCLE_S);
        let mut sum = 0.0;
        for _ in 0..10_000 {
            sum = sum * (-CYCLE_S / 1.5).exp() + 0.02 * 0.02;
        }
        assert!((law.shared.ridge / sum - 1.0).abs() < 1e-9);
        assert!((law.shared.kept - (-CYCLE_S / 1.5).exp()).abs() < 1e-15);
        // The bounds are fractions of the believed coefficients, which a delay of half a cycle makes 1, ½ and ¼ in units of a
        // cycle.
        settings.actuator.delay_s = 0.002;
        let bounds = Ats::<f64>::new(&settings, CYCLE_S).shared.bounds;
        assert_eq!(bounds, [0.05, 0.5 * 0.5, 0.25]);
    }
}
