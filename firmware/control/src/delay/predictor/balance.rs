//! Impulse balance: how far to lean into the contact, so that the impulse that is still to come
//! leaves the model with the momentum of the rebound.

use super::solver::Line;

/// Evaluations of the prediction in a cycle.
const EVALUATIONS: usize = 9;
/// A velocity error that is as good as none, as a part of the velocities before and after.
const EXACT: f64 = 1e-7;
/// A lean is worth this much of a velocity error of the same size.
const LEAN_COSTS: f64 = 0.002;

/// The contact to come, along its direction.
pub(super) struct Balance<'a> {
    /// Depth along the horizon without a lean, m; negative outside.
    pub(super) depth: &'a Line,
    /// Change of the depth by a lean of one way per cycle, in these ways.
    pub(super) lean: &'a Line,
    pub(super) stiffness: f64,
    pub(super) damping: f64,
    /// Velocity per impulse, 1/kg.
    pub(super) inverse_mass: f64,
    /// Velocity of the model now, and what it should have at the end of the horizon, m/s.
    pub(super) velocity: f64,
    pub(super) target: f64,
    pub(super) cycle_s: f64,
}

impl Balance<'_> {
    /// Velocity at the end of the horizon beyond the target, m/s.
    #[inline(never)]
    fn excess(&self, mu: f64) -> f64 {
        let drag = self.damping / self.cycle_s;
        let leaning = mu * self.cycle_s;
        let mut twice = 0.0;
        let ([depth, depths @ ..], [lean, leans @ ..]) = (self.depth, self.lean);
        let mut before = depth + leaning * lean;
        for (depth, lean) in depths.iter().zip(leans) {
            let now = depth + leaning * lean;
            if before > 0.0 || now > 0.0 {
                twice += self.force(before, now, drag * (now - before));
            }
            before = now;
        }
        let impulse = 0.5 * self.cycle_s * twice;
        self.velocity - impulse * self.inverse_mass - self.target
    }

    /// Twice the mean of max(0, k δ + c δ') over a cycle in which the depth goes straight, partly at
    /// least within the wall, N; `drag` is c δ'.
    #[inline]
    fn force(&self, before: f64, now: f64, drag: f64) -> f64 {
        let last = self.stiffness * now + drag;
        if before < 0.0 {
            // It begins within the cycle.
            return now / (now - before) * positive_part(drag, last);
        }
        positive_part(self.stiffness * before + drag, last)
    }

    /// The best lean within ± `most`, m/s.
    #[inline(never)]
    pub(super) fn solve(&self, most: f64) -> f64 {
        let mut best = (self.excess(0.0), 0.0);
        let mut left = EVALUATIONS;
        let better = |best: (f64, f64), new: (f64, f64)| {
            let cost = |(f, mu): (f64, f64)| f.abs() + LEAN_COSTS * mu.abs();
            if cost(new) < cost(best) { new } else { best }
        };
        // More lean, more impulse, less velocity. The first step as if that were linear.
        let mut low = best;
        let probe = (best.0 * 0.5).clamp(-most, most);
        let mut high = (self.excess(probe), probe);
        best = better(best, high);
        left -= 2;
        while low.0 * high.0 > 0.0 && left > 4 && high.1.abs() < most {
            let slope = (high.0 - low.0) / (high.1 - low.1);
            let linear = if slope < 0.0 {
                high.1 - high.0 / slope
            } else {
                0.0
            };
            let far = 2.5 * high.1;
            let next = if linear * high.1 > high.1 * high.1 && linear.abs() < far.abs() {
                linear * 1.05
            } else {
                far
            };
            low = high;
            let mu = next.clamp(-most, most);
            high = (self.excess(mu), mu);
            best = better(best, high);
            left -= 1;
        }
        if low.0 * high.0 > 0.0 {
            return best.1;
        }
        self.narrow(low, high, best, left)
    }

    /// False position with the stale end's value halved, within a sign change.
    fn narrow(
        &self,
        mut low: (f64, f64),
        mut high: (f64, f64),
        mut best: (f64, f64),
        evaluations: usize,
    ) -> f64 {
        for _ in 0..evaluations {
            let width = high.0 - low.0;
            if width == 0.0 {
                break;
            }
            let mu = (low.1 * high.0 - high.1 * low.0) / width;
            let new = (self.excess(mu), mu);
            let cost = |(f, mu): (f64, f64)| f.abs() + LEAN_COSTS * mu.abs();
            if cost(new) < cost(best) {
                best = new;
            }
            if new.0.abs() <= EXACT * (self.velocity.abs() + self.target.abs()) {
                break;
            }
            if new.0 * high.0 < 0.0 {
                low = high;
            } else {
                low.0 *= 0.5;
            }
            high = new;
        }
        best.1
    }
}

/// Twice the mean of the positive part of what goes straight from one value to another.
fn positive_part(first: f64, last: f64) -> f64 {
    match (first > 0.0, last > 0.0) {
        (true, true) => first + last,
        (true, false) => first * first / (first - last),
        (false, true) => last * last / (last - first),
        (false, false) => 0.0,
    }
}
