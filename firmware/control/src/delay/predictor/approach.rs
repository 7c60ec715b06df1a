//! The delay of the robot, its noise and its structure, identified on the approach to the first contact.
//!
//! With z the measured motion and ẑ that of the robot model without any feedback,
//!
//! ```text
//! z − ẑ = x₀ − d ẑ' Ts
//! ```
//!
//! is solved by least squares for an offset x₀ and d, the cycles by which the robot is later than believed. The motion is a ramp
//! and then straight, so that z is a scalar, the progress along the velocity. The residual is noise, or shows that the structure
//! of the robot is another one than believed.

use super::V6;
use super::least_squares::shrunk;
use super::noise::ResidualNoise;
use super::robot_model::{AxisState, RobotModel};
use super::tuning::*;
use nalgebra::ComplexField;

/// Results of the identification.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Findings {
    /// Delay beyond the configured one, cycles.
    pub(super) extra_delay: f64,
    /// Its standard deviation by noise, cycles.
    pub(super) deviation: f64,
    /// The delay was clamped to its range.
    pub(super) at_bound: bool,
    /// The extra delay without clamping, cycles.
    wanted: f64,
    /// Standard deviation of a measured progress, m.
    pub(super) noise_m: f64,
    /// Misfit beyond noise, as a fraction of the displacement in a delay.
    pub(super) misfit: f64,
    /// The fit is made of the whole window.
    pub(super) complete: bool,
}

impl Findings {
    /// How far beyond its range the delay is, cycles.
    pub(super) fn beyond(&self) -> f64 {
        (self.wanted - self.extra_delay).abs()
    }

    /// Clamps an extra delay to the range in which the delay is followed, cycles; records whether that changed it.
    fn bounded(&mut self, wanted: f64) -> f64 {
        let within = wanted.clamp(DELAY_RANGE[0], DELAY_RANGE[1]);
        (self.at_bound, self.wanted) = (within != wanted, wanted);
        within
    }
}

/// Identification on the approach to the first contact.
#[derive(Clone, Debug)]
pub(super) struct Approach {
    /// Unit vector of the motion, and its speed, m/s.
    along: V6,
    pub(super) speed: f64,
    start: V6,
    /// Measured progress (in cycles) and commanded rate (dimensionless), both in units of the speed.
    measured: [f64; APPROACH_WINDOW],
    commanded: [f64; APPROACH_WINDOW],
    cycles: usize,
    pub(super) findings: Findings,
}

impl Approach {
    /// At rest at a position, about to move with a velocity.
    pub(super) fn new(start: V6, velocity: &V6) -> Self {
        let speed = velocity.norm();
        Self {
            along: velocity / speed.max(SLOWEST_APPROACH),
            speed,
            start,
            measured: [0.0; APPROACH_WINDOW],
            commanded: [0.0; APPROACH_WINDOW],
            cycles: 0,
            findings: Findings::default(),
        }
    }

    /// Whether the identification has ended: the window is full, or the approach too slow.
    pub(super) fn is_over(&self) -> bool {
        self.cycles >= APPROACH_WINDOW || self.speed < SLOWEST_APPROACH
    }

    /// A contact begins: the identification ends with what it has, as the motion is not straight any more.
    pub(super) fn end(&mut self) {
        self.cycles = APPROACH_WINDOW;
    }

    /// Takes in a cycle: the position at its end and the command of its beginning. Returns by how many cycles the delay is to be
    /// changed; `None` if it is not.
    pub(super) fn take(&mut self, position: &V6, command: &V6, model: &RobotModel) -> Option<f64> {
        if self.is_over() {
            return None;
        }
        let scale = 1.0 / (self.speed * model.cycle_s);
        if let (Some(z), Some(u)) = (
            self.measured.get_mut(self.cycles),
            self.commanded.get_mut(self.cycles),
        ) {
            *z = (position - self.start).dot(&self.along) * scale;
            *u = command.dot(&self.along) / self.speed;
        }
        self.cycles += 1;
        let left = APPROACH_WINDOW - self.cycles;
        let due = self.cycles >= APPROACH_FIRST_FIT && left.is_multiple_of(APPROACH_FIT_PERIOD);
        due.then(|| self.fit(model)).flatten()
    }

    /// Takes in a change of the delay that was found later. Returns the part of it that stays within the range in which the delay
    /// is followed, cycles.
    pub(super) fn bounded_change(&mut self, later: f64) -> f64 {
        let findings = &mut self.findings;
        let within = findings.bounded(findings.extra_delay + later);
        within - core::mem::replace(&mut findings.extra_delay, within)
    }

    /// Fits offset and delay. Returns the change of the delay, cycles; `None` if it is not significant or the robot has hardly
    /// moved.
    fn fit(&mut self, model: &RobotModel) -> Option<f64> {
        let mut sums = OffsetAndDelay::default();
        self.simulate(model, |residual, rate| sums.add(residual, rate));
        let (offset, step) = sums.solve()?;
        let (mut squares, mut noise) = (0.0, ResidualNoise::default());
        self.simulate(model, |residual, rate| {
            let rest = residual - offset + step * rate;
            squares += rest * rest;
            noise.add(rest);
        });
        let rms = ComplexField::sqrt(squares / self.cycles as f64);
        let noise = noise.deviation();
        let findings = &mut self.findings;
        let beyond = ComplexField::sqrt((rms * rms - noise * noise).max(0.0));
        findings.misfit = beyond / model.linear.mean_delay.max(1.0);
        findings.noise_m = noise * self.speed * model.cycle_s;
        findings.complete = self.cycles >= APPROACH_WINDOW;
        findings.deviation = noise / sums.leverage();
        let unlike = (beyond / sums.leverage()).min(APPROACH_DEVIATION_LIMIT);
        let variance = findings.deviation * findings.deviation + unlike * unlike;
        // The delay of the settings is the prior: a deviation from it counts as far as it exceeds noise.
        let seen = shrunk(findings.extra_delay + step, variance, APPROACH_SIGNIFICANCE);
        let wanted = findings.bounded(seen);
        let step = wanted - findings.extra_delay;
        let significant = step.abs() > APPROACH_DELAY_STEP;
        if significant {
            findings.extra_delay = wanted;
        }
        significant.then_some(step)
    }

    /// Runs the robot model with the commands; passes measured minus model, and the rate of the model, to `see`.
    fn simulate(&self, model: &RobotModel, mut see: impl FnMut(f64, f64)) {
        let (mut axis, mut position) = (AxisState::default(), 0.0);
        let unit = RobotModel {
            cycle_s: 1.0,
            ..model.clone()
        };
        let of = |k: usize, delay: usize| {
            let command = k.checked_sub(delay).and_then(|k| self.commanded.get(k));
            command.copied().unwrap_or(0.0)
        };
        let whole = model.linear.whole;
        for k in 0..self.cycles {
            let (displacement, velocity) = axis.step(&unit, of(k, whole + 1), of(k, whole));
            position += displacement;
            see(self.measured[k] - position, velocity);
        }
    }
}

/// Sums for residual = x₀ − d · rate.
#[derive(Clone, Copy, Debug, Default)]
struct OffsetAndDelay {
    count: f64,
    rate: f64,
    rate_squared: f64,
    residual: f64,
    product: f64,
}

impl OffsetAndDelay {
    fn add(&mut self, residual: f64, rate: f64) {
        self.count += 1.0;
        self.rate += rate;
        self.rate_squared += rate * rate;
        self.residual += residual;
        self.product += residual * rate;
    }

    /// Variance of the rate times the count.
    fn spread(&self) -> f64 {
        self.rate_squared - self.rate * self.rate / self.count.max(1.0)
    }

    /// √ of the spread: the standard deviation of d is that of a residual over this.
    fn leverage(&self) -> f64 {
        ComplexField::sqrt(self.spread().max(1e-6))
    }

    /// x₀ and d; `None` if the robot has hardly moved.
    fn solve(&self) -> Option<(f64, f64)> {
        let spread = self.spread();
        if spread < 1.0 {
            return None;
        }
        let slope = (self.product - self.residual * self.rate / self.count) / spread;
        Some(((self.residual - slope * self.rate) / self.count, -slope))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::predictor::scene;
    use crate::delay::spacecraft::CYCLE_S;

    fn robot(delay_cycles: f64, servo_hz: f64) -> RobotModel {
        RobotModel::new(
            &scene::robot(delay_cycles, 0.0, 0.0, servo_hz),
            CYCLE_S,
            0.0,
        )
    }

    /// Towards a contact at 5 mm/s, oblique to the axes.
    fn velocity() -> V6 {
        V6::new(0.003, 0.0, -0.004, 0.0, 0.0, 0.0)
    }

    /// Identifies a robot with noise of this size (m) for so many cycles, with a model that is corrected as it goes. Returns how
    /// the delay was changed, and in which cycles. The motion began 2 µm from the measured start.
    fn follow(
        truth: &RobotModel,
        believed: &mut RobotModel,
        noise: f64,
        cycles: usize,
    ) -> (Approach, Vec<(usize, f64)>) {
        let start = V6::repeat(0.5) - velocity() * (2e-6 / velocity().norm());
        let mut approach = Approach::new(start, &velocity());
        let (mut axis, mut moved) = (AxisState::default(), 0.0);
        let (mut commands, mut changes) = (Vec::new(), Vec::new());
        for k in 0..cycles {
            assert!(!approach.is_over());
            let command = (k as f64 / 20.0).min(1.0);
            commands.push(command);
            let of = |delay: usize| k.checked_sub(delay).map_or(0.0, |k| commands[k]);
            let whole = truth.linear.whole;
            moved += axis.step(truth, of(whole + 1), of(whole)).0;
            let wave = (k as f64 * 12.9898).sin() * 43_758.545_3;
            let white = (wave - wave.floor() - 0.5) * 12.0_f64.sqrt();
            let along = velocity() * (moved + noise * white / velocity().norm());
            let position = V6::repeat(0.5) + along + V6::new(4.0, 0.0, 3.0, 1.0, 0.0, 0.0) * 1e-3;
            if let Some(later) = approach.take(&position, &(velocity() * command), believed) {
                believed.linear.shift(later);
                changes.push((k + 1, later));
            }
        }
        (approach, changes)
    }

    /// The identification over the whole window.
    fn identify(
        truth: &RobotModel,
        believed: &mut RobotModel,
        noise: f64,
    ) -> (Approach, Vec<(usize, f64)>) {
        let (mut approach, changes) = follow(truth, believed, noise, APPROACH_WINDOW);
        assert!(approach.is_over());
        assert_eq!(approach.take(&V6::zeros(), &velocity(), believed), None);
        (approach, changes)
    }

    /// Motion across the approach, and the start, do not matter.
    #[test]
    fn the_delay_of_the_robot_is_found_in_the_first_fit() {
        for delay in [9.3, 8.0, 6.5, 4.0] {
            let mut believed = robot(8.0, 0.0);
            let (approach, changes) = identify(&robot(delay, 0.0), &mut believed, 0.0);
            let findings = approach.findings;
            assert!((believed.linear.mean_delay - delay).abs() < 2e-3, "{delay}");
            assert!(
                (findings.extra_delay - (delay - 8.0)).abs() < 2e-3,
                "{findings:?}"
            );
            assert!(
                findings.misfit < 1e-4 && findings.noise_m < 1e-9,
                "{findings:?}"
            );
            assert!(findings.complete && !findings.at_bound);
            assert!(delay == 8.0 || changes[0].0 == 48, "{changes:?}");
        }
    }

    #[test]
    fn the_delay_is_followed_to_the_end_of_its_range() {
        for (delay, found) in [(1.0, 2.0), (19.0, 18.0)] {
            let mut believed = robot(8.0, 0.0);
            let (approach, _) = identify(&robot(delay, 0.0), &mut believed, 0.0);
            assert!(approach.findings.at_bound);
            assert!((believed.linear.mean_delay - found).abs() < 1e-9, "{delay}");
        }
    }

    /// A robot whose noise is a micrometre: known to a fifth, no misfit, and no delay that is not there.
    #[test]
    fn noise_is_neither_a_delay_nor_another_robot() {
        let mut believed = robot(8.0, 0.0);
        let (approach, changes) = identify(&robot(8.0, 0.0), &mut believed, 1e-6);
        let findings = approach.findings;
        assert!((findings.noise_m / 1e-6 - 1.0).abs() < 0.2, "{findings:?}");
        assert_eq!(changes, []);
        // 20 µm in a cycle, and a rate that grows from 0 to 1 within 20 of 88 cycles.
        let rates = (0..88).map(|k: usize| (k.saturating_sub(8) as f64 / 20.0).min(1.0));
        let mean = rates.clone().sum::<f64>() / 88.0;
        let spread: f64 = rates.map(|rate| (rate - mean) * (rate - mean)).sum();
        let expected = findings.noise_m / (0.005 * CYCLE_S) / spread.sqrt();
        assert!(
            (findings.deviation / expected - 1.0).abs() < 0.02,
            "{findings:?} {expected}"
        );
        assert!(findings.misfit < 0.003, "{findings:?}");
    }

    /// A servo of the same mean delay leaves a smooth residual, which is not noise, and which a dead time does not explain.
    #[test]
    fn another_structure_is_a_misfit() {
        let servo = robot(3.0, 10.0);
        let mut believed = robot(servo.linear.mean_delay, 0.0);
        let (approach, _) = identify(&servo, &mut believed, 0.0);
        let findings = approach.findings;
        assert!(
            findings.misfit > 0.002 && findings.misfit < 0.02,
            "{findings:?}"
        );
        assert!(findings.noise_m < 0.05e-6, "{findings:?}");
        assert!(findings.extra_delay.abs() < 0.3, "{findings:?}");
    }

    /// In the first fit: shrunk by twice the deviation from noise, and by that from another structure, a third of a cycle at
    /// most.
    #[test]
    fn a_delay_counts_as_far_as_it_is_significant() {
        let servo = robot(3.0, 10.0);
        for (truth, believed, noise) in [
            (robot(8.4, 0.0), 8.0, 0.0),
            (robot(8.4, 0.0), 8.0, 2e-6),
            (robot(8.4, 0.0), 8.0, 1e-5),
            (servo.clone(), 8.0, 0.0),
            (servo.clone(), 6.5, 0.0),
            (servo, 2.0, 1e-6),
        ] {
            let believed = robot(believed, 0.0);
            let (approach, changes) = follow(&truth, &mut believed.clone(), noise, 48);
            let mut sums = OffsetAndDelay::default();
            approach.simulate(&believed, |residual, rate| sums.add(residual, rate));
            let (_, seen) = sums.solve().unwrap();
            let findings = approach.findings;
            let leverage = findings.noise_m / (0.005 * CYCLE_S) / findings.deviation;
            let beyond = findings.misfit * believed.linear.mean_delay;
            let unlike = (beyond / leverage).min(0.3);
            let variance = findings.deviation * findings.deviation + unlike * unlike;
            let expected = shrunk(seen, variance, 2.0);
            let found = changes.first().map_or(0.0, |(_, later)| *later);
            let small = expected.abs() < 2e-3 && found == 0.0;
            assert!(
                small || (found - expected).abs() < 1e-6,
                "{noise}: {found} {expected}"
            );
            assert!(!findings.complete);
        }
    }

    #[test]
    fn an_approach_that_is_too_slow_tells_nothing() {
        for (speed, over) in [(0.9e-5, true), (1.1e-5, false)] {
            let approach = Approach::new(V6::zeros(), &V6::new(0.0, speed, 0.0, 0.0, 0.0, 0.0));
            assert_eq!(approach.is_over(), over, "{speed}");
        }
    }

    /// -6 to 10 cycles around the settings.
    #[test]
    fn a_later_change_stays_within_the_range() {
        let mut approach = Approach::new(V6::zeros(), &velocity());
        for (later, within, at_bound) in [
            (3.0, 3.0, false),
            (4.0, 4.0, false),
            (4.0, 3.0, true),
            (-1.0, -1.0, false),
            (-20.0, -15.0, true),
        ] {
            assert_eq!(approach.bounded_change(later), within, "{later}");
            assert_eq!(approach.findings.at_bound, at_bound, "{later}");
        }
        assert_eq!(approach.findings.extra_delay, -6.0);
    }

    #[test]
    fn offset_and_delay_are_those_of_a_straight_line() {
        let mut sums = OffsetAndDelay::default();
        assert_eq!(sums.solve(), None);
        for rate in [0.0, 1.0, 2.0, 3.0, 4.0] {
            sums.add(0.7 - 1.3 * rate, rate);
        }
        let (offset, delay) = sums.solve().unwrap();
        assert!((offset - 0.7).abs() < 1e-12 && (delay - 1.3).abs() < 1e-12);
        assert!((sums.leverage() - 10.0_f64.sqrt()).abs() < 1e-12);
        // Nearly the same rate throughout.
        for (last, some) in [(0.8, false), (0.83, true)] {
            let mut sums = OffsetAndDelay::default();
            for rate in [0.0, 0.0, 0.0, last, last, last] {
                sums.add(1.0, rate);
            }
            assert_eq!(sums.solve().is_some(), some, "{last}");
        }
    }
}
