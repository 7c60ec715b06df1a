//! Contacts, found from the measured force: no model of a wall is needed.

use nalgebra::Vector3;
use softdock_control::modes::Mode;
use softdock_physics::model::Model;
use softdock_physics::model::prediction::signals::Signals;
use softdock_physics::model::prediction::wrench::measured_contact_force;

/// A contact begins above this multiple of the force's noise ...
const NOISE_FACTOR: f64 = 8.0;
/// ... and above this share of the largest force, so that friction and errors of the zero are
/// no contact.
const PEAK_SHARE: f64 = 0.08;
/// It ends below this share of the threshold. A much lower share would let friction prolong it.
const RELEASE_SHARE: f64 = 0.8;
/// Cycles in a row above the threshold that make a contact, or below it that end one.
const CONFIRM_CYCLES: usize = 3;

/// A contact: cycles `from..to`.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// First cycle.
    pub from: usize,
    /// Cycle after the last.
    pub to: usize,
    /// Direction of the largest force on M, in C, length 1.
    pub direction: Vector3<f64>,
}

/// All contacts of a recording.
#[derive(Clone, Debug)]
pub struct Contacts {
    /// In their order.
    pub list: Vec<Contact>,
    /// Force above which a contact begins, N.
    pub threshold_n: f64,
    /// Largest force without spikes of a single cycle, N.
    pub peak_n: f64,
    /// Whether the log has a force that may be that of a contact.
    pub looked_for: bool,
}

/// Finds the contacts of the closed loop (of the whole recording if the loop was never closed).
pub(super) fn find(model: &Model, signals: &Signals<'_>) -> Contacts {
    let mut force = measured_contact_force(model, signals);
    let knows_any = !model.contact.walls.is_empty() || !model.contact.docking.is_empty();
    if model.sensor.wrench.drives() || !(signals.is_of_a_rig() || knows_any) {
        // A force that drives an axis is no contact, nor is one on a machine whose model has nothing to touch.
        force.fill(None);
    }
    let running = |n: usize| signals.cycles[n].trace.mode == Mode::Running;
    if (0..signals.len()).any(running) {
        for (n, f) in force.iter_mut().enumerate() {
            *f = f.filter(|_| running(n));
        }
    }
    let zero = median_force(&force);
    let known: Vec<(usize, Vector3<f64>)> = force
        .iter()
        .enumerate()
        .filter_map(|(n, f)| Some((n, (*f)? - zero)))
        .collect();
    let size: Vec<f64> = known.iter().map(|(_, f)| f.norm()).collect();
    // Maximum over pairs of neighbours of the smaller one: a single spike does not count.
    let peak_n = size.windows(2).map(|w| w[0].min(w[1])).fold(0.0, f64::max);
    let threshold_n =
        (NOISE_FACTOR * noise_n(&known, model.noise.force_n)).max(PEAK_SHARE * peak_n);
    let list = intervals(&size, threshold_n)
        .into_iter()
        .map(|(from, to)| contact(&known[from..to]))
        .collect();
    Contacts {
        list,
        threshold_n,
        peak_n,
        looked_for: !known.is_empty(),
    }
}

fn contact(cycles: &[(usize, Vector3<f64>)]) -> Contact {
    let largest = cycles
        .iter()
        .map(|(_, force)| *force)
        .max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
    Contact {
        from: cycles.first().map_or(0, |(n, _)| *n),
        to: cycles.last().map_or(0, |(n, _)| n + 1),
        direction: largest
            .and_then(|force| force.try_normalize(0.0))
            .unwrap_or_else(Vector3::x),
    }
}

/// Median of the force, N: what the model's zero or weight misses.
fn median_force(force: &[Option<Vector3<f64>>]) -> Vector3<f64> {
    Vector3::from_fn(|i, _| median(force.iter().filter_map(|f| Some((*f)?[i])).collect()))
}

/// Noise of the force, N: the data sheet's, or that estimated from the steps between cycles, whichever is larger.
fn noise_n(force: &[(usize, Vector3<f64>)], data_sheet_n: f64) -> f64 {
    (0..3)
        .map(|i| noise_of_steps(force.iter().map(|(_, f)| f[i])))
        .fold(data_sheet_n, f64::max)
}

/// Standard deviation of white noise, estimated from the median step, which motion and spikes hardly change:
/// `1.4826 median|x(n) − x(n−1)| / √2`.
pub(super) fn noise_of_steps(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    let steps = values.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    1.4826 * median(steps) / std::f64::consts::SQRT_2
}

/// Median of finite values; 0 of none.
fn median(mut values: Vec<f64>) -> f64 {
    values.retain(|v| v.is_finite());
    softdock_statistics::median(&mut values).unwrap_or(0.0)
}

/// Intervals above the threshold, with hysteresis in size and in time.
fn intervals(size: &[f64], threshold: f64) -> Vec<(usize, usize)> {
    let mut found: Vec<(usize, usize)> = Vec::new();
    let (mut above, mut start, mut last_loaded) = (0, 0, None::<usize>);
    for (n, value) in size.iter().enumerate() {
        above = if *value > threshold { above + 1 } else { 0 };
        if last_loaded.is_none() && above >= CONFIRM_CYCLES {
            start = onset(size, n + 1 - CONFIRM_CYCLES, RELEASE_SHARE * threshold);
            last_loaded = Some(n);
        } else if let Some(last) = last_loaded {
            if *value > RELEASE_SHARE * threshold {
                last_loaded = Some(n);
            } else if n - last > CONFIRM_CYCLES {
                found.push((start, last + 1));
                last_loaded = None;
            }
        }
    }
    if let Some(last) = last_loaded {
        found.push((start, last + 1));
    }
    found
}

/// First cycle of a contact: goes back from `from`, by a few cycles at most, to where the force rose above the release level.
fn onset(size: &[f64], from: usize, release: f64) -> usize {
    (0..from)
        .rev()
        .take(CONFIRM_CYCLES)
        .take_while(|n| size[*n] > release)
        .last()
        .unwrap_or(from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chatter_and_spikes_make_no_contacts() {
        let mut size = vec![0.1; 100];
        size[10] = 50.0;
        for (i, value) in [6.0, 8.5, 20.0, 30.0, 9.0, 4.0, 12.0, 8.5]
            .iter()
            .enumerate()
        {
            size[40 + i] = *value;
        }
        assert_eq!(intervals(&size, 10.0), vec![]);
        size[44] = 12.0;
        assert_eq!(intervals(&size, 10.0), vec![(41, 48)]);
    }

    #[test]
    fn a_recording_that_ends_in_contact_keeps_it() {
        let size = [0.0, 0.0, 20.0, 20.0, 20.0];
        assert_eq!(intervals(&size, 10.0), vec![(2, 5)]);
    }

    #[test]
    fn noise_is_found_beside_motion() {
        let values = (0..1000).map(|n| f64::from(n) * 0.01 + if n % 2 == 0 { 1.0 } else { -1.0 });
        let noise = noise_of_steps(values);
        assert!(
            (noise - 1.4826 * 2.0 / 2.0_f64.sqrt()).abs() < 0.02,
            "{noise}"
        );
    }
}
