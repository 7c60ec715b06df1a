//! The approach: how late the robot really is, how noisy its pose, and whether it moves as believed.
//!
//! Up to the first contact the motion is a ramp and then straight, so that all of it is one number:
//! the progress along the velocity. The twin's progress without any feedback is compared with the
//! measured one, by least squares for a place x₀ and a delay d: z − ẑ = x₀ − d ẑ' Ts. What remains
//! is noise, or another structure than the one believed.

use super::V6;
use super::twin::{Axis, Plan};
use nalgebra::ComplexField;

/// Cycles that are kept: a ramp, the robot's delay and a straight part.
const WINDOW: usize = 88;
/// First fit, and cycles between fits.
const FIRST_FIT: usize = 44;
const BETWEEN_FITS: usize = 8;
/// Cycles at the end of the window in which the motion is as good as straight.
const STRAIGHT: usize = 72;
/// Range of the delay around the believed one, cycles.
const RANGE: [f64; 2] = [-6.0, 10.0];
/// A change of the delay below this is not worth it, cycles.
const WORTH: f64 = 0.002;
/// Slowest approach that tells anything, m/s.
const SLOWEST: f64 = 1e-5;

/// What the approach has shown.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Findings {
    /// Delay beyond the believed one, cycles.
    pub(super) late: f64,
    /// It was at the end of its range.
    pub(super) at_bound: bool,
    /// Standard deviation of a measured progress, m.
    pub(super) noise_m: f64,
    /// Misfit, as a part of the way that the robot is late.
    pub(super) misfit: f64,
    /// The fit is made of the whole window.
    pub(super) complete: bool,
}

/// The approach so far.
#[derive(Clone, Debug)]
pub(super) struct Approach {
    /// Unit vector of the motion, and its speed, m/s.
    along: V6,
    speed: f64,
    start: V6,
    /// Measured progress and commanded rate, in units of the speed: cycles, 1.
    measured: [f64; WINDOW],
    commanded: [f64; WINDOW],
    cycles: usize,
    pub(super) findings: Findings,
}

impl Approach {
    /// At rest at a position, about to move with a velocity.
    pub(super) fn new(start: V6, velocity: &V6) -> Self {
        let speed = velocity.norm();
        Self {
            along: velocity / speed.max(SLOWEST),
            speed,
            start,
            measured: [0.0; WINDOW],
            commanded: [0.0; WINDOW],
            cycles: 0,
            findings: Findings::default(),
        }
    }

    /// Whether nothing more is to be learned.
    pub(super) fn is_over(&self) -> bool {
        self.cycles >= WINDOW || self.speed < SLOWEST
    }

    /// Speed of the approach, m/s.
    pub(super) fn speed(&self) -> f64 {
        self.speed
    }

    /// A cycle: the position at its end, the command of its beginning. Answers by how many cycles
    /// the delay is to be changed.
    pub(super) fn take(&mut self, position: &V6, command: &V6, plan: &Plan) -> Option<f64> {
        if self.is_over() {
            return None;
        }
        let scale = 1.0 / (self.speed * plan.cycle_s);
        if let (Some(z), Some(u)) = (
            self.measured.get_mut(self.cycles),
            self.commanded.get_mut(self.cycles),
        ) {
            *z = (position - self.start).dot(&self.along) * scale;
            *u = command.dot(&self.along) / self.speed;
        }
        self.cycles += 1;
        let due = self.cycles >= FIRST_FIT && (WINDOW - self.cycles).is_multiple_of(BETWEEN_FITS);
        due.then(|| self.fit(plan)).flatten()
    }

    /// A delay that was found later: how much of the change is within the range in which it is
    /// followed, cycles.
    pub(super) fn follow(&mut self, late: f64) -> f64 {
        let findings = &mut self.findings;
        let wanted = findings.late + late;
        let within = wanted.clamp(RANGE[0], RANGE[1]);
        findings.at_bound = within != wanted;
        within - core::mem::replace(&mut findings.late, within)
    }

    /// One step of the fit.
    fn fit(&mut self, plan: &Plan) -> Option<f64> {
        let mut sums = Sums::default();
        self.replay(plan, |residual, rate| sums.add(residual, rate));
        let (place, step) = sums.solve()?;
        let wanted = (self.findings.late + step).clamp(RANGE[0], RANGE[1]);
        let step = wanted - self.findings.late;
        let mut squares = 0.0;
        self.replay(plan, |residual, rate| {
            let rest = residual - place + step * rate;
            squares += rest * rest;
        });
        let rms = ComplexField::sqrt(squares / self.cycles as f64);
        let noise = self.noise();
        let findings = &mut self.findings;
        findings.at_bound = wanted <= RANGE[0] || wanted >= RANGE[1];
        let beyond = ComplexField::sqrt((rms * rms - noise * noise).max(0.0));
        findings.misfit = beyond / plan.chain.mean.max(1.0);
        findings.noise_m = noise * self.speed * plan.cycle_s;
        findings.complete = self.cycles >= WINDOW;
        let deviation = rms / sums.leverage();
        let counts = step.abs() > WORTH + 1.5 * deviation.min(0.3);
        if counts || findings.at_bound {
            findings.late = wanted;
        }
        counts.then_some(step)
    }

    /// Noise of the progress, cycles: from its second differences where it is straight.
    fn noise(&self) -> f64 {
        let straight = self.measured.get(..self.cycles).unwrap_or_default();
        let straight = straight
            .get(straight.len().saturating_sub(STRAIGHT)..)
            .unwrap_or_default();
        let (mut squares, mut count) = (0.0, 0.0);
        for pair in straight.windows(3) {
            if let [a, b, c] = pair {
                let second = a - 2.0 * b + c;
                squares += second * second;
                count += 6.0;
            }
        }
        ComplexField::sqrt(squares / f64::max(count, 6.0))
    }

    /// Runs the twin through the commands: measured less twin, and the twin's rate.
    fn replay(&self, plan: &Plan, mut see: impl FnMut(f64, f64)) {
        let mut axis = Axis::default();
        let unit = Plan {
            cycle_s: 1.0,
            ..plan.clone()
        };
        let of = |k: usize, delay: usize| {
            let command = k.checked_sub(delay).and_then(|k| self.commanded.get(k));
            command.copied().unwrap_or(0.0)
        };
        let whole = plan.chain.whole;
        for k in 0..self.cycles {
            axis.step(&unit, of(k, whole + 1), of(k, whole));
            see(self.measured[k] - axis.position, axis.velocity);
        }
    }
}

/// Sums for residual = x₀ − d · rate.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: f64,
    rate: f64,
    rate_squared: f64,
    residual: f64,
    product: f64,
}

impl Sums {
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
