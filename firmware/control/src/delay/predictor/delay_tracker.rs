//! The delay of the robot, tracked in the contacts after the approach, by the same equation
//!
//! ```text
//! z − ẑ = x₀ − d ẑ' Ts
//! ```
//!
//! Straight and uniform motion says nothing about a delay: a delay that is longer by d looks like an offset of d v Ts, and
//! offsets change, because a displacement is lost at each reversal. Only a change of velocity distinguishes them: x₀ is a
//! constant of an axis from one of its reversals to the next, while d is the same for all axes, for the braking before a reversal
//! and the motion after it. A pause of another length changes x₀ alone and causes no error of d. Near the reversal itself the
//! robot may reverse, or stand, while the model does not: those samples are left out.

use super::V6;
use super::least_squares::shrunk;
use super::robot_model::RobotState;
use super::tuning::*;

/// State of the tracking: running means of each axis, and the sums of products about them.
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
    /// Takes in a cycle: measured position minus that of the model without feedback (m), and the state of the robot model.
    #[inline(never)]
    pub(super) fn add(&mut self, residual: &V6, robot: &RobotState, cycle_s: f64) {
        for (i, mean) in self.means.iter_mut().enumerate() {
            let rate = robot.velocity[i] * cycle_s;
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

    /// By how many cycles the robot is later than believed, shrunk by the noise of a position (standard deviation, m); `None` if
    /// that is not significant. To be called once per contact, as each call discounts the sums.
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

    /// Adapts the sums to a robot model whose delay was increased by `later` cycles.
    pub(super) fn shift(&mut self, later: f64) {
        self.product += later * self.spread;
        for mean in &mut self.means {
            mean.residual += later * mean.rate;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::spacecraft::CYCLE_S;

    /// One bounce of an axis that brakes, reverses and leaves. The measured axis is `later` than its model; it has another offset
    /// on either side of the reversal, and is anywhere near it.
    fn bounce(tracker: &mut DelayTracker, later: f64, offsets: [f64; 2]) {
        let mut robot = RobotState::default();
        for n in 0..=40 {
            let rate = (f64::from(n) * core::f64::consts::PI / 40.0).cos();
            let mut residual = V6::zeros();
            for (i, speed) in [(0, 0.005), (4, -0.002)] {
                robot.velocity[i] = speed * rate;
                let apart = if rate.abs() < 0.25 {
                    1.0
                } else {
                    offsets[usize::from(rate < 0.0)] - later * speed * rate * CYCLE_S
                };
                residual[i] = apart;
            }
            tracker.add(&residual, &robot, CYCLE_S);
        }
    }

    #[test]
    fn a_delay_is_what_a_changing_velocity_tells_of_it() {
        for later in [0.7, -1.1, 0.06, 0.04, 5.0, -5.0] {
            let mut tracker = DelayTracker::default();
            assert_eq!(tracker.later(0.0), None);
            bounce(&mut tracker, later, [1e-5, -3e-5]);
            let found = tracker.later(0.0);
            let expected = f64::clamp(later, -2.0, 2.0);
            match found {
                Some(found) => assert!(
                    (found - expected).abs() < 1e-9 && later != 0.04,
                    "{later}: {found}"
                ),
                None => assert_eq!(later, 0.04),
            }
        }
    }

    /// The previous contact has 0.6 of the weight; the axis stands still in between.
    #[test]
    fn earlier_contacts_count_less() {
        let mut tracker = DelayTracker::default();
        bounce(&mut tracker, 1.0, [0.0, 0.0]);
        let first = 0.6 * tracker.spread;
        assert!((tracker.later(0.0).unwrap() - 1.0).abs() < 1e-9);
        tracker.add(&V6::zeros(), &RobotState::default(), CYCLE_S);
        bounce(&mut tracker, 0.2, [0.0, 0.0]);
        let second = tracker.spread - first;
        let found = tracker.later(0.0).unwrap();
        let expected = (first + 0.2 * second) / (first + second);
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        assert!((first / second - 0.6).abs() < 0.2, "{first} {second}");
    }

    /// The delay is changed in the middle of the motion; the estimate is then what is left of it.
    #[test]
    fn a_model_that_is_made_later_has_been_so_all_along() {
        for (all, shifted, left) in [
            (0.8, 0.3, Some(0.5)),
            (0.8, 0.8, None),
            (-0.4, 0.6, Some(-1.0)),
        ] {
            let mut tracker = DelayTracker::default();
            let mut robot = RobotState::default();
            for n in 0..16 {
                let rate = (f64::from(n) * core::f64::consts::PI / 40.0).cos();
                robot.velocity[2] = 0.005 * rate;
                let later = if n < 8 { all } else { all - shifted };
                if n == 8 {
                    tracker.shift(shifted);
                }
                let residual = 1e-5 - later * 0.005 * rate * CYCLE_S;
                tracker.add(&V6::new(0.0, 0.0, residual, 0.0, 0.0, 0.0), &robot, CYCLE_S);
            }
            match (tracker.later(0.0), left) {
                (Some(found), Some(left)) => assert!((found - left).abs() < 1e-9, "{found}"),
                (found, left) => assert_eq!(found, left),
            }
        }
    }

    /// Within two standard deviations it is zero; beyond, it is shrunk.
    #[test]
    fn a_delay_that_noise_may_have_made_is_none() {
        let tracker = || {
            let mut tracker = DelayTracker::default();
            bounce(&mut tracker, 0.8, [0.0, 0.0]);
            tracker
        };
        let spread = 0.6 * tracker().spread;
        for (deviations, found) in [(1.9, None), (4.0, Some(0.8 * (1.0 - 4.0 / 16.0)))] {
            let noise_m = 0.8 / deviations * spread.sqrt();
            let later = tracker().later(noise_m);
            match (later, found) {
                (Some(later), Some(found)) => assert!((later - found).abs() < 1e-9, "{later}"),
                _ => assert_eq!(later, found, "{deviations}"),
            }
        }
    }

    /// Running means with a memory of 64 cycles, and sums of products about them; an axis that stands still is left out.
    #[test]
    fn an_offset_is_forgotten_in_64_cycles() {
        let (mut tracker, mut robot) = (DelayTracker::default(), RobotState::default());
        let (mut weight, mut sums) = (0.0, [0.0; 2]);
        for n in 0..50 {
            let (rate, residual) = (1.0 + 0.1 * f64::from(n % 7), 1e-5 * f64::from(n % 5));
            robot.velocity[2] = rate / CYCLE_S;
            tracker.add(&V6::new(0.0, 0.0, residual, 0.0, 0.0, 0.0), &robot, CYCLE_S);
            weight = weight * (63.0 / 64.0) + 1.0;
            for (sum, value) in sums.iter_mut().zip([residual, rate]) {
                *sum = *sum * (63.0 / 64.0) + value;
            }
            let mean = tracker.means[2];
            assert!((mean.residual - sums[0] / weight).abs() < 1e-15, "{n}");
            assert!((mean.rate - sums[1] / weight).abs() < 1e-12, "{n}");
        }
    }

    /// The peak of an axis decays by 2 % per cycle: after a long slow motion it is that of the slow motion.
    #[test]
    fn an_axis_near_its_reversal_is_left_out_until_its_peak_is_forgotten() {
        let (mut tracker, mut robot) = (DelayTracker::default(), RobotState::default());
        let mut add = |rate: f64| {
            robot.velocity[0] = rate / CYCLE_S;
            tracker.add(&V6::zeros(), &robot, CYCLE_S);
            tracker.means[0].weight > 0.0
        };
        for (rate, counts) in [(1.0, true), (0.41, true), (-0.41, true), (0.36, false)] {
            assert_eq!(add(rate), counts, "{rate}");
        }
        // After 49 cycles: 0.4 of 0.98 to the 49th is 0.149.
        let first = (5..).find(|_| add(0.15)).unwrap();
        assert_eq!(first, 50);
    }
}
