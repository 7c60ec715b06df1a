//! Limits of the robot, set so that the jog shows an effect of the wanted size.
//!
//! The residual of a limit depends on how often the jog reaches it, for which there is no formula. So the limited robot is
//! simulated over the jog, and the limit is found by bisection.

use nalgebra::Vector6;

use crate::actuator::{Actuator, ActuatorEffect};
use crate::jog::Jog;
use crate::meta::Meta;

/// Bisections of the bracket.
const HALVINGS: usize = 9;

/// Factor f for which `limited(f)` changes the executed jog velocity by `target_z` sigma rms, in the log with the smaller
/// change.
pub(crate) fn factor(
    meta: &Meta,
    jogs: &[Jog; 2],
    target_z: f64,
    limited: impl Fn(f64) -> ActuatorEffect,
) -> f64 {
    let free = [0, 1].map(|i| execute(meta, &jogs[i], None));
    let (mut low, mut high) = (0.3, 3.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        let effect = limited(middle);
        let shown = [0, 1].map(|i| {
            let executed = execute(meta, &jogs[i], Some(&effect));
            distance_z(meta, &executed, &free[i])
        });
        if shown[0].min(shown[1]) > target_z {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

fn execute(meta: &Meta, jog: &Jog, effect: Option<&ActuatorEffect>) -> Vec<Vector6<f64>> {
    let moves = core::array::from_fn(|axis| meta.moves(axis));
    let effects: Vec<&ActuatorEffect> = effect.into_iter().collect();
    let mut actuator = Actuator::new(&meta.actuator, meta.sample_time_s, moves, &effects);
    jog.iter()
        .enumerate()
        .map(|(n, command)| {
            let t_s = n as f64 * meta.sample_time_s;
            actuator.advance(t_s, |_, _, _| ());
            actuator.send(t_s, *command);
            actuator.velocity()
        })
        .collect()
}

/// RMS difference over the moving axes, in units of the data-sheet noise.
fn distance_z(meta: &Meta, one: &[Vector6<f64>], other: &[Vector6<f64>]) -> f64 {
    let sigma = &meta.noise_sigma;
    let mut sum = 0.0;
    for (a, b) in one.iter().zip(other) {
        for axis in 0..6 {
            let scale = if axis < 3 {
                sigma.velocity_m_s
            } else {
                sigma.rate_rad_s
            };
            sum += ((a[axis] - b[axis]) / scale).powi(2);
        }
    }
    let active = (0..6).filter(|axis| meta.moves(*axis)).count().max(1);
    (sum / (active * one.len().max(1)) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuator::Location;
    use crate::jog;
    use crate::noise::Noise;
    use crate::rig;

    #[test]
    fn limit_leaves_what_was_asked_for() {
        let mut noise = Noise::new(1, 0);
        let meta = rig::draw("x", false, &mut noise);
        let jogs = jog::draw(&meta, [0.03, 0.042], &mut noise);
        let limited = |f: f64| ActuatorEffect::Saturation {
            linear: 0.04 * f,
            angular: 0.4 * f,
            place: Location::Output,
        };
        let effect = limited(factor(&meta, &jogs, 5.0, limited));
        let shown = [0, 1].map(|i| {
            let free = execute(&meta, &jogs[i], None);
            distance_z(&meta, &execute(&meta, &jogs[i], Some(&effect)), &free)
        });
        assert!((shown[0].min(shown[1]) - 5.0).abs() < 1.0, "{shown:?}");
    }
}
