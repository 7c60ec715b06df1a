//! What the sensor does to its samples: rounding them, and repeating the last one.

use super::sheet_sigma;
use softdock_physics::model::Model;
use softdock_physics::model::log::Log;
use softdock_statistics::median;
use std::collections::BTreeMap;

/// Rounding below this share of the noise cannot be seen in the error, and is what any sensor does.
const VISIBLE: f64 = 0.35;
/// Samples are called repeated from this share on: by chance there are fewer.
const REPEATED: f64 = 0.004;
/// A step of the lattice is at least this many units of the last printed digit of the log.
const DIGITS: f64 = 20.0;

/// Rounding and repetition of the readings of one log.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sampling {
    /// Step of the readings: force (N), torque (N·m); 0 where no rounding is visible.
    pub lsb: [f64; 2],
    /// Readings are rounded down, not to the nearest step.
    pub rounds_down: bool,
    /// Share of samples that repeat the one before.
    pub held_share: f64,
    /// Variance of this share, times the number of samples.
    pub held_variance: f64,
    /// For each cycle: the sample is new, and no repetition.
    pub fresh: Vec<bool>,
}

impl Sampling {
    /// Examines the readings of a log.
    pub(crate) fn of(log: &Log, model: &Model) -> Self {
        let sigma = sheet_sigma(model);
        // What a drive was commanded comes from no sensor, and may have steps of any size.
        let drives = model.sensor.wrench.drives();
        let steps: [Option<f64>; 6] = std::array::from_fn(|axis| {
            let step = lattice(&log.wrench[axis]).filter(|_| !drives)?;
            Some(if step > VISIBLE * sigma[axis] {
                step
            } else {
                0.0
            })
        });
        let lsb = [common(&steps[..3]), common(&steps[3..])];
        let count = log.cycle_count().saturating_sub(1).max(1) as f64;
        let repeats = |n: &usize| log.wrench.iter().all(|axis| axis[*n] == axis[*n - 1]);
        let held: Vec<usize> = (1..log.cycle_count()).filter(repeats).collect();
        let by_chance: f64 = log
            .wrench
            .iter()
            .map(|axis| repeated_by_chance(axis))
            .product();
        let share = held.len() as f64 / count;
        // A command acts until the next one.
        let is_held =
            !drives && share > REPEATED && share > 5.0 * by_chance && moves_between(log, &held);
        let mut fresh = log.fresh.clone();
        if is_held {
            held.iter().for_each(|n| fresh[*n] = false);
        }
        Self {
            lsb,
            rounds_down: false,
            held_share: if is_held { share } else { 0.0 },
            held_variance: variance_of_share(&held, share),
            fresh,
        }
    }

    /// Decides from the mean of measured minus nominal readings whether they are rounded down: then the mean is half a step too
    /// low, on at least two thirds of the rounded axes.
    pub(crate) fn look_at_zero(&mut self, mean: &[f64; 6]) {
        let down = |axis: usize| {
            let step = self.lsb[axis / 3];
            step > 0.0 && (mean[axis] / step + 0.5).abs() < 0.25
        };
        let rounded = (0..6).filter(|axis| self.lsb[axis / 3] > 0.0).count();
        self.rounds_down =
            rounded > 0 && (0..6).filter(|axis| down(*axis)).count() * 3 >= rounded * 2;
    }

    /// What to add to readings so that each stands in the middle of its interval.
    pub(crate) fn centring(&self, axis: usize) -> f64 {
        if self.rounds_down {
            0.5 * self.lsb[axis / 3]
        } else {
            0.0
        }
    }

    /// Whether readings are visibly rounded.
    pub(crate) fn is_rounded(&self) -> bool {
        self.lsb.iter().any(|step| *step > 0.0)
    }
}

/// Share of readings of an axis that repeat the one before by chance. If most changes are larger than one step, it is half the
/// share of changes by one step (as one step up, one step down and no change are about equally likely there). Otherwise the axis
/// has coarse steps or changes slowly, and all repetitions are taken for chance.
fn repeated_by_chance(values: &[f64]) -> f64 {
    /// Changes below this share of the largest one are round-off.
    const ROUND_OFF: f64 = 1e-9;
    let changes: Vec<f64> = values.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    let largest = changes.iter().copied().fold(0.0, f64::max);
    let smallest = changes.iter().copied().filter(|c| *c > ROUND_OFF * largest);
    let smallest = smallest.fold(f64::INFINITY, f64::min);
    let share = |is_it: &dyn Fn(f64) -> bool| {
        let those = changes.iter().filter(|c| is_it(**c));
        those.count() as f64 / changes.len().max(1) as f64
    };
    let repeats = share(&|c| c == 0.0);
    let one_step = share(&|c| c > 0.0 && c < 1.5 * smallest);
    let is_fine = 1.0 - repeats - one_step > one_step;
    if is_fine { 0.5 * one_step } else { repeats }
}

/// Whether the readings that repeat differ: none makes up half of them. A signal that rests at a limit, or reads nothing, repeats
/// one value and was not held.
fn moves_between(log: &Log, held: &[usize]) -> bool {
    let mut counts: BTreeMap<[u64; 6], usize> = BTreeMap::new();
    for n in held {
        let reading = log.wrench.each_ref().map(|axis| axis[*n].to_bits());
        *counts.entry(reading).or_default() += 1;
    }
    2 * counts.values().copied().max().unwrap_or(0) < held.len()
}

/// Variance of a share p of samples times their number, p (1 − p) (1 + ρ)/(1 − ρ). Held samples come in runs; ρ is the
/// correlation of one sample with the next.
fn variance_of_share(held: &[usize], share: f64) -> f64 {
    let again = held
        .windows(2)
        .filter(|pair| pair[0] + 1 == pair[1])
        .count();
    let stays = again as f64 / held.len().max(1) as f64;
    let correlation = (stays - share) / (1.0 - share).max(f64::MIN_POSITIVE);
    let correlation = correlation.clamp(0.0, 0.99);
    share * (1.0 - share) * (1.0 + correlation) / (1.0 - correlation)
}

/// The step that several axes share (their median); 0 if at most half of the axes that are not constant have one.
fn common(steps: &[Option<f64>]) -> f64 {
    let mut found: Vec<f64> = steps
        .iter()
        .flatten()
        .copied()
        .filter(|s| *s > 0.0)
        .collect();
    if found.len() * 2 > steps.iter().flatten().count() {
        median(&mut found).unwrap_or(0.0)
    } else {
        0.0
    }
}

/// Step of the lattice on which nearly all values lie. 0 if there is none, or it is no coarser than the digits of the log; `None`
/// for a constant, which says nothing.
fn lattice(values: &[f64]) -> Option<f64> {
    let mut sorted: Vec<f64> = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    if sorted.len() < 2 {
        return None;
    }
    if sorted.len() * 10 > values.len() * 8 {
        return Some(0.0);
    }
    let digit = softdock_statistics::digit_of(&sorted);
    let gaps: Vec<f64> = sorted.windows(2).map(|w| w[1] - w[0]).collect();
    let smallest = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    let step = refined(&gaps, smallest);
    let on_lattice = |gap: &&f64| {
        let cells = **gap / step;
        (cells - cells.round()).abs() * step < 2.0 * digit + 0.01 * step
    };
    let fitting = gaps.iter().filter(on_lattice).count();
    let coarse = step > DIGITS * digit || sorted.len() * 4 < values.len();
    Some(if coarse && fitting * 50 >= gaps.len() * 49 {
        step
    } else {
        0.0
    })
}

/// The step as a mean over the gaps, which are whole multiples of it but for the digits of the log. Larger gaps are used as it
/// gets more exact.
fn refined(gaps: &[f64], smallest: f64) -> f64 {
    let mut step = smallest;
    for reach in [3.0, 10.0, 30.0] {
        let (mut sum, mut cells) = (0.0, 0.0);
        for gap in gaps.iter().filter(|g| **g < reach * smallest) {
            sum += gap;
            cells += (gap / step).round();
        }
        if cells > 0.0 {
            step = sum / cells;
        }
    }
    step
}

#[cfg(test)]
mod tests {
    use super::*;

    fn smooth(n: usize) -> f64 {
        40.0 * (n as f64 * 0.013).sin() + 3.0 * (n as f64 * 1.7).sin()
    }

    fn printed(value: f64) -> f64 {
        (value * 1e4).round() / 1e4
    }

    #[test]
    fn a_lattice_is_found_through_the_digits_of_the_log() {
        let step = 1.2345;
        let values: Vec<f64> = (0..2500)
            .map(|n| printed((smooth(n) / step).round() * step))
            .collect();
        let found = lattice(&values).unwrap();
        assert!((found / step - 1.0).abs() < 1e-3, "{found}");
    }

    /// Readings of one axis, updated in every tenth cycle or in each, in fine and in coarse steps.
    #[test]
    fn what_a_slow_sensor_repeats_is_no_chance() {
        let by_chance = |every: usize, step: f64| {
            let values = (0..2500).map(|n| (smooth(n - n % every) / step).round() * step);
            repeated_by_chance(&values.collect::<Vec<_>>())
        };
        for step in [1e-4, 0.1] {
            assert!(by_chance(10, step) < 0.05, "{}", by_chance(10, step));
            assert!(by_chance(1, step) < 0.05, "{}", by_chance(1, step));
        }
        assert!(by_chance(1, 10.0) > 0.5, "{}", by_chance(1, 10.0));
    }

    #[test]
    fn samples_that_are_held_in_runs_say_less_of_their_share() {
        let in_runs: Vec<usize> = (0..100).map(|n| 40 * (n / 4) + n % 4).collect();
        let apart: Vec<usize> = (0..100).map(|n| 10 * n).collect();
        // Runs of 4 of 40: three of four held samples are followed by another.
        let correlation: f64 = (0.75 - 0.1) / 0.9;
        let inflated = 0.09 * (1.0 + correlation) / (1.0 - correlation);
        assert!((variance_of_share(&in_runs, 0.1) - inflated).abs() < 1e-12);
        assert!((variance_of_share(&apart, 0.1) - 0.09).abs() < 1e-12);
    }

    #[test]
    fn the_digits_of_a_log_are_no_lattice() {
        let values: Vec<f64> = (0..2500).map(|n| printed(smooth(n))).collect();
        assert_eq!(lattice(&values), Some(0.0));
    }
}
