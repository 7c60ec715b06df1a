//! The delay of the robot: identified on the approach, tracked in the contacts that follow.
//!
//! Both fit the same equation: with z the measured motion and ẑ that of the robot model without any feedback,
//!
//! ```text
//! z − ẑ = x₀ − d ẑ' Ts
//! ```
//!
//! is solved by least squares for an offset x₀ and d, the cycles by which the robot is later than believed.
//!
//! On the **approach** all motion is a ramp and then straight, so that z is one number, the progress along the
//! velocity. What remains is noise, or another structure than the one believed.
//!
//! **Afterwards** straight and uniform motion says nothing about a delay: d more of it looks like an offset of
//! d v Ts, and offsets change, because a displacement is lost at each reversal. Only a velocity that changes
//! tells them apart: x₀ is a constant of an axis from one of its reversals to the next, and d is one number for
//! the braking before it and the motion after it, of all axes. A pause of another length moves x₀ alone and is
//! no error of d. Near the reversal itself the robot may turn, or stand, while the model does not: those
//! samples are left out.

use super::V6;
use super::least_squares::shrunk;
use super::robot_model::{AxisState, RobotModel, RobotState};
use super::tuning::*;
use nalgebra::ComplexField;

/// What the approach has shown.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Findings {
    /// Delay beyond the configured one, cycles.
    pub(super) extra_delay: f64,
    /// Its standard deviation by noise, cycles.
    pub(super) deviation: f64,
    /// It was at the end of its range.
    pub(super) at_bound: bool,
    /// Standard deviation of a measured progress, m.
    pub(super) noise_m: f64,
    /// Misfit, as a part of the displacement in a delay.
    pub(super) misfit: f64,
    /// The fit is made of the whole window.
    pub(super) complete: bool,
}

/// Identification on the approach to the first contact.
#[derive(Clone, Debug)]
pub(super) struct Approach {
    /// Unit vector of the motion, and its speed, m/s.
    along: V6,
    pub(super) speed: f64,
    start: V6,
    /// Measured progress and commanded rate, in units of the speed: cycles, 1.
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

    /// Whether nothing more is to be learned.
    pub(super) fn is_over(&self) -> bool {
        self.cycles >= APPROACH_WINDOW || self.speed < SLOWEST_APPROACH
    }

    /// A cycle: the position at its end, the command of its beginning. Answers by how many cycles
    /// the delay is to be changed.
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

    /// A change of the delay that was found later: how much of it is within the range in which the delay is
    /// followed, cycles.
    pub(super) fn bounded_change(&mut self, later: f64) -> f64 {
        let findings = &mut self.findings;
        let wanted = findings.extra_delay + later;
        let within = wanted.clamp(DELAY_RANGE[0], DELAY_RANGE[1]);
        findings.at_bound = within != wanted;
        within - core::mem::replace(&mut findings.extra_delay, within)
    }

    /// One step of the fit.
    fn fit(&mut self, model: &RobotModel) -> Option<f64> {
        let mut sums = OffsetAndDelay::default();
        self.simulate(model, |residual, rate| sums.add(residual, rate));
        let (offset, step) = sums.solve()?;
        let (mut squares, mut noise) = (0.0, Noise::default());
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
        // The settings say where the delay is; what is seen counts as far as it is more than noise.
        let seen = shrunk(findings.extra_delay + step, variance, APPROACH_SIGNIFICANCE);
        let wanted = seen.clamp(DELAY_RANGE[0], DELAY_RANGE[1]);
        findings.at_bound = wanted != seen;
        let step = wanted - findings.extra_delay;
        let significant = step.abs() > APPROACH_DELAY_STEP;
        if significant {
            findings.extra_delay = wanted;
        }
        significant.then_some(step)
    }

    /// Runs the robot model through the commands: measured less model, and the model's rate.
    fn simulate(&self, model: &RobotModel, mut see: impl FnMut(f64, f64)) {
        let mut axis = AxisState::default();
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
            axis.step(&unit, of(k, whole + 1), of(k, whole));
            see(self.measured[k] - axis.position, axis.velocity);
        }
    }
}

/// Noise of what a fit leaves, from its second differences: another structure leaves what is smooth.
#[derive(Clone, Copy, Debug, Default)]
struct Noise {
    last: [f64; 2],
    squares: f64,
    count: f64,
}

impl Noise {
    fn add(&mut self, rest: f64) {
        let [before, earlier] = self.last;
        if self.count >= 2.0 {
            let second = rest - 2.0 * before + earlier;
            self.squares += second * second;
        }
        self.count += 1.0;
        self.last = [rest, before];
    }

    /// Standard deviation.
    fn deviation(&self) -> f64 {
        ComplexField::sqrt(self.squares / (6.0 * (self.count - 2.0).max(1.0)))
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

    /// Noise of d is that of a residual over this.
    fn leverage(&self) -> f64 {
        ComplexField::sqrt(self.spread().max(1e-6))
    }

    /// x₀ and d; none if the robot has hardly moved.
    fn solve(&self) -> Option<(f64, f64)> {
        let spread = self.spread();
        if spread < 1.0 {
            return None;
        }
        let slope = (self.product - self.residual * self.rate / self.count) / spread;
        Some(((self.residual - slope * self.rate) / self.count, -slope))
    }
}

/// Tracking after the approach: running means of each axis, and the products about them.
#[derive(Clone, Debug, Default)]
pub(super) struct DelayTracker {
    means: [AxisMean; 6],
    /// Σ (residual · rate) and Σ rate², m² and m².
    product: f64,
    spread: f64,
}

#[derive(Clone, Copy, Debug, Default)]
struct AxisMean {
    peak: f64,
    weight: f64,
    residual: f64,
    rate: f64,
}

impl DelayTracker {
    /// A cycle: measured position less the model's without feedback (m), and the robot model.
    #[inline(never)]
    pub(super) fn add(&mut self, residual: &V6, robot: &RobotState, cycle_s: f64) {
        for (i, (mean, axis)) in self.means.iter_mut().zip(&robot.0).enumerate() {
            let rate = axis.velocity * cycle_s;
            mean.peak = (mean.peak * PEAK_FORGETTING).max(rate.abs());
            if rate.abs() < REVERSAL_BAND * mean.peak {
                mean.weight = 0.0;
                continue;
            }
            mean.weight = mean.weight * OFFSET_FORGETTING + 1.0;
            let (off, faster) = (residual[i] - mean.residual, rate - mean.rate);
            if mean.weight <= 1.0 {
                (mean.residual, mean.rate) = (residual[i], rate);
                continue;
            }
            mean.residual += off / mean.weight;
            mean.rate += faster / mean.weight;
            self.product += off * (rate - mean.rate);
            self.spread += faster * (rate - mean.rate);
        }
    }

    /// By how many cycles the robot is later than believed, as far as that is significant against the noise
    /// of a position (standard deviation, m). Asked once for each contact.
    pub(super) fn later(&mut self, noise_m: f64) -> Option<f64> {
        self.product *= CONTACT_FORGETTING;
        self.spread *= CONTACT_FORGETTING;
        if self.spread <= 0.0 {
            return None;
        }
        let later = -self.product / self.spread;
        let variance = noise_m * noise_m / self.spread;
        let later = shrunk(later, variance, TRACKED_DELAY_SIGNIFICANCE);
        let later = later.clamp(-TRACKED_DELAY_LIMIT, TRACKED_DELAY_LIMIT);
        (later.abs() > TRACKED_DELAY_STEP).then_some(later)
    }

    /// The robot model is so many cycles later now.
    pub(super) fn shift(&mut self, later: f64) {
        self.product += later * self.spread;
        for mean in &mut self.means {
            mean.residual += later * mean.rate;
        }
    }
}
