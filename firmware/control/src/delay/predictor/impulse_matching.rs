//! Impulse matching: how far to press into the contact, so that the impulse that is still to come leaves the
//! model with the momentum of the rebound.
//!
//! For a dead time after the onset the robot goes straight on, and the model loses more momentum than the contact would have
//! taken. That impulse has to be given back while the contact lasts. A preload, a multiple μ of the moves 1, ½, ¼ ... along the
//! contact on top of the tracking moves, changes the depth from then on; μ is chosen such that
//!
//! ```text
//! v − (1/m) Σ ∫ max(0, k δ + q δ² + c δ') dt  =  velocity of the reference at the end of the horizon
//! ```
//!
//! along the predicted depth δ, with the displacement δ' Ts of each cycle as the trapezoidal sum of its samples gives it, because
//! the model feels samples of the force. The earlier the preload, the less displacement it takes.

use super::dynamic_matrix::Trajectory;
use super::tuning::*;

/// The contact to come, along its direction.
pub(super) struct ImpulseMatching<'a> {
    /// Depth along the horizon without a preload, m; negative outside.
    pub(super) depth: &'a Trajectory,
    /// Displacement in the cycle that ends then, as the trapezoidal sum of the sampled velocities gives it, m.
    pub(super) sampled: &'a Trajectory,
    /// Change of the depth by a preload of 1, cycles.
    pub(super) preload: &'a Trajectory,
    /// Change of `sampled` by a preload of 1, cycles.
    pub(super) sampled_preload: &'a Trajectory,
    /// k and q, N/m and N/m².
    pub(super) stiffness: f64,
    pub(super) stiffening: f64,
    pub(super) damping: f64,
    /// Velocity per impulse, 1/kg.
    pub(super) inverse_mass: f64,
    /// Velocity of the model now, and what it should have at the end of the horizon, m/s.
    pub(super) velocity: f64,
    pub(super) target: f64,
    pub(super) cycle_s: f64,
}

/// A preload that was tried, m/s, and the resulting excess of the final velocity over the target, m/s.
#[derive(Clone, Copy)]
struct Trial {
    excess: f64,
    preload: f64,
}

impl Trial {
    /// The better of two trials, by the error and a small cost of the preload's size.
    fn better(self, new: Self) -> Self {
        let cost = |trial: Self| trial.excess.abs() + PRELOAD_COST * trial.preload.abs();
        if cost(new) < cost(self) { new } else { self }
    }
}

impl ImpulseMatching<'_> {
    /// Evaluates a preload: the excess of the velocity at the end of the horizon over the target.
    #[inline(never)]
    fn trial(&self, preload: f64) -> Trial {
        // Nearly always a linear spring, whose loop needs one product less.
        let impulse = if self.stiffening == 0.0 {
            self.impulse::<false>(preload)
        } else {
            self.impulse::<true>(preload)
        };
        Trial {
            excess: self.velocity - impulse * self.inverse_mass - self.target,
            preload,
        }
    }

    /// Impulse to come, N·s.
    #[inline]
    fn impulse<const STIFFENING: bool>(&self, preload: f64) -> f64 {
        let drag = self.damping / self.cycle_s;
        let per_cycle = preload * self.cycle_s;
        let mut twice = 0.0;
        let ([depth, depths @ ..], [change, changes @ ..]) = (self.depth, self.preload);
        let ([_, sampled @ ..], [_, more @ ..]) = (self.sampled, self.sampled_preload);
        let mut before = depth + per_cycle * change;
        let sampled = sampled.iter().zip(more);
        for ((depth, change), (sampled, more)) in depths.iter().zip(changes).zip(sampled) {
            let now = depth + per_cycle * change;
            if before > 0.0 || now > 0.0 {
                let drag = drag * (sampled + per_cycle * more);
                twice += self.force::<STIFFENING>(before, now, drag);
            }
            before = now;
        }
        0.5 * self.cycle_s * twice
    }

    /// Twice the mean of max(0, k δ + q δ² + c δ') over a cycle in which the depth changes linearly and which is at least partly
    /// in contact, N; `drag` is c δ'.
    #[inline]
    fn force<const STIFFENING: bool>(&self, before: f64, now: f64, drag: f64) -> f64 {
        let spring = |depth: f64| {
            if STIFFENING {
                (self.stiffness + self.stiffening * depth) * depth
            } else {
                self.stiffness * depth
            }
        };
        let last = spring(now) + drag;
        if before < 0.0 {
            // It begins within the cycle.
            return now / (now - before) * positive_part(drag, last);
        }
        positive_part(spring(before) + drag, last)
    }

    /// The best preload within ± `most`, m/s.
    #[inline(never)]
    pub(super) fn solve(&self, most: f64) -> f64 {
        let matched = MATCHED * (self.velocity.abs() + self.target.abs());
        search(|preload| self.trial(preload), most, matched)
    }
}

/// The best preload within ± `most`, m/s. A larger preload gives more impulse and thus a smaller velocity; the sign change of the
/// excess is bracketed with growing steps. An excess up to `matched` (m/s) counts as zero.
#[inline]
fn search(trial: impl Fn(f64) -> Trial, most: f64, matched: f64) -> f64 {
    // The first step takes the excess as linear.
    let mut low = trial(0.0);
    let mut high = trial((low.excess * FIRST_STEP).clamp(-most, most));
    let mut best = low.better(high);
    let mut left = EVALUATIONS - 2;
    while low.excess * high.excess > 0.0 && left > ROOT_EVALUATIONS && high.preload.abs() < most {
        let slope = (high.excess - low.excess) / (high.preload - low.preload);
        let linear = if slope < 0.0 {
            high.preload - high.excess / slope
        } else {
            0.0
        };
        let far = STEP_GROWTH * high.preload;
        let onward = linear * high.preload > high.preload * high.preload;
        let next = if onward && linear.abs() < far.abs() {
            linear * STEP_MARGIN
        } else {
            far
        };
        low = high;
        high = trial(next.clamp(-most, most));
        best = best.better(high);
        left -= 1;
    }
    if low.excess * high.excess > 0.0 {
        return best.preload;
    }
    // Regula falsi within the bracket, with the value of the end that stays halved (Illinois method).
    for _ in 0..left {
        let width = high.excess - low.excess;
        if width == 0.0 {
            break;
        }
        let root = (low.preload * high.excess - high.preload * low.excess) / width;
        let new = trial(root);
        best = best.better(new);
        if new.excess.abs() <= matched {
            break;
        }
        if new.excess * high.excess < 0.0 {
            low = high;
        } else {
            low.excess *= 0.5;
        }
        high = new;
    }
    best.preload
}

/// Twice the mean of the positive part of a function that goes linearly from `first` to `last`.
fn positive_part(first: f64, last: f64) -> f64 {
    match (first > 0.0, last > 0.0) {
        (true, true) => first + last,
        (true, false) => first * first / (first - last),
        (false, true) => last * last / (last - first),
        (false, false) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE_S: f64 = 0.004;
    const MASS: f64 = 500.0;
    const CLOSING: f64 = 0.005;
    /// Cycles until the robot responds to a preload.
    const DELAY: usize = 8;

    /// What samples show of a velocity that is constant within each cycle and changes just after they are taken: the mean of the
    /// displacements of a cycle and of the one before it.
    fn late(of: &Trajectory) -> Trajectory {
        core::array::from_fn(|t| 0.5 * (of[t] - of[t.saturating_sub(2)]))
    }

    /// A contact that has just begun: k, q and c.
    struct Contact {
        depth: Trajectory,
        sampled: Trajectory,
        preload: Trajectory,
        sampled_preload: Trajectory,
        load: [f64; 3],
    }

    impl Contact {
        /// Depth along half a sine of the spring's own frequency, then out again at constant speed; moves of 1, ½, ¼ ... after
        /// the delay.
        fn new(load: [f64; 3]) -> Self {
            let omega = (load[0] / MASS).sqrt();
            let end = core::f64::consts::PI / omega;
            let depth = |t: f64| match t - end {
                after if after > 0.0 => -CLOSING * after,
                _ => CLOSING / omega * (omega * t).sin(),
            };
            let moved = |t: usize| 2.0 - 0.5_f64.powi(t.saturating_sub(DELAY) as i32 - 1);
            let depth = core::array::from_fn(|t| depth(CYCLE_S * (t as f64 - 0.3)));
            let preload = core::array::from_fn(|t| if t > DELAY { moved(t) } else { 0.0 });
            Self {
                depth,
                sampled: late(&depth),
                preload,
                sampled_preload: late(&preload),
                load,
            }
        }

        fn matching(&self, velocity: f64, target: f64) -> ImpulseMatching<'_> {
            let [stiffness, stiffening, damping] = self.load;
            ImpulseMatching {
                depth: &self.depth,
                sampled: &self.sampled,
                preload: &self.preload,
                sampled_preload: &self.sampled_preload,
                stiffness,
                stiffening,
                damping,
                inverse_mass: 1.0 / MASS,
                velocity,
                target,
                cycle_s: CYCLE_S,
            }
        }

        /// Impulse of a force that never pulls, by depth and rate in 500 steps of each cycle, N·s.
        fn impulse(&self, preload: f64) -> f64 {
            let [k, q, c] = self.load;
            let at = |t: usize| self.depth[t] + preload * CYCLE_S * self.preload[t];
            let mut impulse = 0.0;
            for t in 0..PREDICTION_HORIZON {
                let (before, now) = (at(t), at(t + 1));
                let sampled = self.sampled[t + 1] + preload * CYCLE_S * self.sampled_preload[t + 1];
                for n in 0..500 {
                    let depth = before + (now - before) * (f64::from(n) + 0.5) / 500.0;
                    let rate = sampled / CYCLE_S;
                    if depth > 0.0 {
                        let force = k * depth + q * depth * depth + c * rate;
                        impulse += force.max(0.0) * CYCLE_S / 500.0;
                    }
                }
            }
            impulse
        }
    }

    /// A spring, a damper with it, and a spring that hardens or softens with its depth.
    fn contacts() -> [Contact; 4] {
        [
            Contact::new([220_500.0, 0.0, 0.0]),
            Contact::new([220_500.0, 0.0, 4000.0]),
            Contact::new([220_500.0, 3e8, 0.0]),
            Contact::new([220_500.0, -2e8, 4000.0]),
        ]
    }

    #[test]
    fn the_predicted_impulse_is_that_of_a_force_that_never_pulls() {
        for contact in contacts() {
            for preload in [-0.004, -0.001, 0.0, 0.002, 0.01] {
                let impulse = contact.impulse(preload);
                let excess = contact.matching(0.004, -0.005).trial(preload).excess;
                let error = excess - (0.009 - impulse / MASS);
                // The parabola is a trapezoid within a cycle.
                let bound = if contact.load[1] == 0.0 { 1e-6 } else { 1e-4 };
                let load = contact.load;
                assert!(error.abs() < bound, "{load:?} {preload}: {error:e}");
            }
        }
    }

    /// Targets that need more impulse, or less, than the motion without a preload gives.
    #[test]
    fn the_preload_leaves_the_velocity_that_is_asked() {
        for contact in contacts() {
            for part in [-0.2, -0.05, -0.01, 0.01, 0.05, 0.2] {
                let free = contact.matching(CLOSING, 0.0).trial(0.0).excess;
                let target = free + part * CLOSING;
                let matching = contact.matching(CLOSING, target);
                let preload = matching.solve(4.0 * CLOSING);
                let excess = matching.trial(preload).excess;
                let most = 1e-5 * CLOSING;
                let load = contact.load;
                assert!(excess.abs() < most, "{load:?} {part}: {preload} {excess:e}");
                // More impulse is less velocity.
                assert!(preload * part < 0.0, "{load:?} {part}: {preload}");
            }
        }
    }

    #[test]
    fn what_leaves_as_it_should_needs_no_preload() {
        for contact in contacts() {
            let target = contact.matching(CLOSING, 0.0).trial(0.0).excess;
            assert_eq!(contact.matching(CLOSING, target).solve(0.02), 0.0);
        }
    }

    #[test]
    fn a_preload_that_cannot_be_enough_is_the_largest() {
        for contact in contacts() {
            for most in [1e-5, 1e-4, 1e-3] {
                for (target, preload) in [(-10.0 * CLOSING, most), (10.0 * CLOSING, -most)] {
                    let found = contact.matching(CLOSING, target).solve(most);
                    assert_eq!(found, preload);
                }
            }
        }
    }

    /// Searches for the root of this excess. Returns the preload, and all preloads that were tried.
    fn searched(excess: impl Fn(f64) -> f64, most: f64) -> (f64, Vec<f64>) {
        let tried = core::cell::RefCell::new(Vec::new());
        let trial = |preload: f64| {
            tried.borrow_mut().push(preload);
            let excess = excess(preload);
            Trial { excess, preload }
        };
        let found = search(trial, most, 1e-9);
        (found, tried.into_inner())
    }

    fn assert_tried(excess: impl Fn(f64) -> f64, most: f64, expected: &[f64]) {
        let (found, tried) = searched(excess, most);
        assert_eq!(tried.len(), expected.len(), "{tried:?}");
        for (tried, expected) in tried.iter().zip(expected) {
            assert!((tried - expected).abs() < 1e-12, "{tried} {expected}");
        }
        assert!(
            (found - expected[expected.len() - 1]).abs() < 1e-12,
            "{found}"
        );
    }

    /// Half of the excess is tried first. If the root lies within, linear interpolation finds it; if not, the next trial goes 5 %
    /// beyond the linear extrapolation.
    #[test]
    fn a_straight_line_takes_as_few_trials_as_it_can() {
        for sign in [1.0, -1.0] {
            let line = |slope: f64| move |preload: f64| sign * 0.01 - slope * preload;
            let root = |slope: f64| sign * 0.01 / slope;
            let first = sign * 0.005;
            assert_tried(line(5.0), 1.0, &[0.0, first, root(5.0)]);
            assert_tried(line(1.0), 1.0, &[0.0, first, root(1.0) * 1.05, root(1.0)]);
            // No step reaches more than two and a half times as far.
            let far = first * 2.5;
            assert_tried(
                line(0.5),
                1.0,
                &[0.0, first, far, root(0.5) * 1.05, root(0.5)],
            );
            // The root lies beyond the largest preload, or just there.
            assert_tried(line(0.5), 0.015, &[0.0, first, far, sign * 0.015]);
            assert_tried(line(0.5), 0.003, &[0.0, sign * 0.003]);
            assert_tried(line(2.0), 1.0, &[0.0, first, root(2.0)]);
        }
    }

    /// Where a step changes nothing, or makes the excess larger, there is no linear extrapolation.
    #[test]
    fn a_plateau_is_left_by_growing_steps() {
        for before in [1e-2, 1.1e-2] {
            let plateau = |preload: f64| match preload {
                p if p <= 0.0 => 1e-2,
                p if p < 0.02 => before,
                p => 0.5 * (0.03 - p),
            };
            let (found, tried) = searched(plateau, 1.0);
            for (tried, expected) in tried.iter().zip([0.0, 0.005, 0.0125, 0.03125]) {
                assert!((tried - expected).abs() < 1e-12, "{tried} {expected}");
            }
            assert!(
                tried.len() <= EVALUATIONS && (found - 0.03).abs() < 1e-4,
                "{tried:?}"
            );
        }
    }

    /// Nine trials, of which four are kept for the root.
    #[test]
    fn a_search_ends_after_its_trials_with_the_best_of_them() {
        let (found, tried) = searched(|preload| 1e-2 - 1e-9 * preload, 1e9);
        assert_eq!(tried.len(), EVALUATIONS - ROOT_EVALUATIONS);
        // The preload costs more than it gains.
        assert_eq!(found, 0.0);
        let steep = |preload: f64| if preload < 0.00497 { 0.01 } else { -0.01 };
        let (found, tried) = searched(steep, 1.0);
        assert_eq!(tried.len(), EVALUATIONS);
        assert_eq!(found, 0.0);
    }

    /// Convex and concave: each trial leaves a small part of what the one before left.
    #[test]
    fn a_bent_line_is_followed_to_its_root() {
        for bend in [0.6, -0.2] {
            let bent = |preload: f64| 0.01 - preload - bend * preload * preload / 0.01;
            let (found, tried) = searched(bent, 1.0);
            assert!(bent(found).abs() < 1e-5, "{bend}: {found} {tried:?}");
        }
    }

    /// However bent it is in between.
    #[test]
    fn once_the_sign_has_changed_the_root_is_sought_in_between() {
        let cubic = |preload: f64| 0.01 - 0.01 * (preload / 0.0046).powi(3);
        let (found, tried) = searched(cubic, 1.0);
        assert!(
            tried[2..].iter().all(|p| (0.0..=0.005).contains(p)),
            "{tried:?}"
        );
        assert!(cubic(found).abs() < 1e-5, "{found} {tried:?}");
    }

    /// The excess is small enough, so that no further trial is made.
    #[test]
    fn what_matches_is_not_searched_any_further() {
        let (_, tried) = searched(|preload| 0.01 - preload * (1.0 + 1e-9 * preload), 1.0);
        assert_eq!(tried.len(), 4, "{tried:?}");
    }

    #[test]
    fn of_two_equal_errors_the_smaller_preload_is_better() {
        let trial = |excess, preload| Trial { excess, preload };
        for (one, other, better) in [
            (trial(1e-4, 0.01), trial(-1e-4, -0.005), -0.005),
            (trial(1e-4, -0.005), trial(1e-4, 0.01), -0.005),
            (trial(1e-4, 0.005), trial(5e-5, 0.01), 0.01),
            // 0.04 m/s more of preload cost 8e-5 m/s.
            (trial(1e-4, 0.01), trial(5e-5, 0.05), 0.01),
        ] {
            assert_eq!(one.better(other).preload, better);
        }
    }

    /// In thousands of steps.
    #[test]
    fn the_positive_part_of_a_straight_line_is_its_mean() {
        for (first, last) in [
            (1.0, 2.0),
            (2.0, -1.0),
            (-1.0, 3.0),
            (-1.0, -2.0),
            (0.0, 1.0),
        ] {
            let at = |n: i32| first + (last - first) * (f64::from(n) + 0.5) / 3000.0;
            let mean = (0..3000).map(|n| at(n).max(0.0)).sum::<f64>() / 3000.0;
            let error = positive_part(first, last) - 2.0 * mean;
            assert!(error.abs() < 1e-5, "{first} {last}: {error:e}");
        }
    }
}
