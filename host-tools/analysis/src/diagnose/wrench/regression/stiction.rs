//! Finds where a spacecraft sticks to its guide: the log does not show the direction of friction there.
//!
//! A rig with dry friction ends a slow motion by holding. The velocity alternates around zero, by as little as friction changes
//! it in one delay of the loop, and the reading takes whatever value keeps the spacecraft in place. No model can predict that
//! value, so such cycles say nothing about any effect.

use softdock_physics::model::load::Scene;

/// So many reversals in a row are no motion.
const REVERSALS: usize = 4;
/// The reversals follow each other within this time, s: a jog to and fro is slower.
const WITHIN_S: f64 = 0.1;
/// The velocity between them is below this share of its rms over the whole log.
const SLOW: f64 = 0.05;
/// Cycles on both sides that are left out as well, as whitening mixes them in.
const MARGIN: usize = 6;
/// Choices of [`Scene::point_of_action`].
const POINTS: [f64; 3] = [0.0, 1.0, 2.0];

/// The cycles that counted before, without those in which the spacecraft sticks at any of the points where a guide may act.
pub(crate) fn without_stiction(scene: &Scene, counts: &[bool]) -> Vec<bool> {
    let mut counts = counts.to_vec();
    let last = counts.len().saturating_sub(1);
    for point in POINTS {
        let along: Vec<f64> = (0..scene.len()).map(|n| scene.along(n, point)).collect();
        for (from, to) in stuck(&along, scene.cycle_s) {
            let cycles = from.saturating_sub(MARGIN)..=(to + MARGIN).min(last);
            if let Some(cycles) = counts.get_mut(cycles) {
                cycles.fill(false);
            }
        }
    }
    counts
}

/// First and last cycle of each time in which a velocity sticks to zero.
fn stuck(velocity: &[f64], cycle_s: f64) -> Vec<(usize, usize)> {
    let square: f64 = velocity.iter().map(|v| v * v).sum();
    let slow = SLOW * (square / velocity.len().max(1) as f64).sqrt();
    let is_slow = |from: usize, to: usize| velocity[from..to].iter().all(|v| v.abs() < slow);
    let reversals: Vec<usize> = (1..velocity.len())
        .filter(|&n| velocity[n] * velocity[n - 1] < 0.0)
        .collect();
    let longest = (WITHIN_S / cycle_s) as usize;
    reversals
        .chunk_by(|a, b| b - a <= longest && is_slow(*a, *b))
        .filter(|row| row.len() >= REVERSALS)
        .map(|row| (row[0], row[row.len() - 1]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE_S: f64 = 0.004;

    #[test]
    fn going_to_and_fro_around_zero_sticks() {
        let velocity = |n: usize| match n {
            0..500 => 0.04 - 8e-5 * n as f64,
            _ => 1e-4 * (n as f64 * 0.3).sin(),
        };
        let velocity: Vec<f64> = (0..1000).map(velocity).collect();
        let [(from, to)] = stuck(&velocity, CYCLE_S)[..] else {
            panic!("{:?}", stuck(&velocity, CYCLE_S));
        };
        assert!((498..515).contains(&from) && to > 980, "{from} {to}");
    }

    #[test]
    fn a_jog_to_and_fro_and_a_rest_do_not() {
        let jog: Vec<f64> = (0..2500)
            .map(|n| 0.02 * (f64::from(n) * 0.1).sin())
            .collect();
        assert!(stuck(&jog, CYCLE_S).is_empty());
        assert!(stuck(&[0.0; 100], CYCLE_S).is_empty());
    }
}
