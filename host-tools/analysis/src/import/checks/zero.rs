//! Has the executed velocity a zero of its own, as that of a gyroscope has? No effect of the catalogue is a constant velocity.

use super::Context;
use super::causality::{best_delay, series};
use softdock_app::record::CycleRecord;
use softdock_physics::model::Axis;
use softdock_report::number;

/// Parts of a log whose means tell how well the zero is known.
const PARTS: usize = 16;
/// Standard errors from which on a zero is one. Means of parts follow Student's law with 15 degrees of freedom, by which one axis in
/// six thousand without a zero has so many.
const STANDS_OUT: f64 = 5.0;
/// Least part of what a gain and a delay of the command leave that the zero makes: less is found by nobody in its place.
const SHARE: f64 = 0.1;
/// Least share of the commanded way that goes back: one way a gain is a constant, too.
const BACK: f64 = 0.1;

/// Appends a warning for each axis with such a zero.
pub(super) fn check(
    cycles: &[CycleRecord],
    sample_time_s: f64,
    context: &Context<'_>,
    warnings: &mut Vec<String>,
) {
    for axis in Axis::ALL {
        let sent = series(cycles, axis, |c| &c.trace.sent_velocity);
        let executed = series(cycles, axis, |c| &c.trace.executed_velocity);
        let Some(zero) = zero(&sent, &executed, sample_time_s) else {
            continue;
        };
        let unit = if axis.is_rotation() { "rad/s" } else { "m/s" };
        warnings.push(format!(
            "{}: beside a gain and a delay of the sent velocity, the executed velocity {axis} is shifted by {} {unit}: is that the zero of a \
             gyroscope or a tachometer? `offset` for {axis} in [executed_velocity] takes it away. A valve's dead zone that lies to one \
             side looks the same",
            context.name,
            number::significant(zero, 3)
        ));
    }
}

/// The constant that the executed velocity has beside the sent one, times a gain and behind a delay, in their unit; None where none
/// stands out.
fn zero(sent: &[f64], executed: &[f64], sample_time_s: f64) -> Option<f64> {
    let there: f64 = sent.iter().map(|v| v.max(0.0)).sum();
    let back: f64 = sent.iter().map(|v| (-v).max(0.0)).sum();
    if there.min(back) < BACK * (there + back) {
        return None;
    }
    let delay = best_delay(sent, executed, sample_time_s)?;
    let executed = executed.get(delay..)?;
    let sent = &sent[..executed.len()];
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len().max(1) as f64;
    let (mean_sent, mean_executed) = (mean(sent), mean(executed));
    let sums = sent
        .iter()
        .zip(executed)
        .fold([0.0; 2], |[ab, aa], (s, e)| {
            let s = s - mean_sent;
            [ab + s * (e - mean_executed), aa + s * s]
        });
    let gain = sums[0] / sums[1];
    let left: Vec<f64> = sent
        .iter()
        .zip(executed)
        .map(|(s, e)| e - gain * s)
        .collect();
    let zero = mean(&left);
    let parts = left.chunks_exact((left.len() / PARTS).max(1));
    let squares: f64 = parts
        .take(PARTS)
        .map(|part| (mean(part) - zero).powi(2))
        .sum();
    let error = (squares / (PARTS * (PARTS - 1)) as f64).sqrt();
    let power = left.iter().map(|v| v * v).sum::<f64>() / left.len() as f64;
    (zero.abs() > STANDS_OUT * error && zero * zero > SHARE * power).then_some(zero)
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_statistics::RandomStream;

    #[test]
    fn a_zero_stands_out_of_what_follows_a_command() {
        let mut random = RandomStream::new(1, 0);
        let at = |n: usize, lag: f64| (2.0 * (0.004 * (n as f64 - lag))).sin();
        let sent: Vec<f64> = (0..4000).map(|n| at(n, 0.0)).collect();
        let mut executed = |zero: f64| -> Vec<f64> {
            (0..4000)
                .map(|n| 0.9 * at(n, 12.0) + zero + 0.05 * random.normal())
                .collect()
        };
        let found = zero(&sent, &executed(-0.05), 0.004).unwrap();
        assert!((found + 0.05).abs() < 0.005, "{found}");
        assert_eq!(zero(&sent, &executed(0.0), 0.004), None);
        let one_way: Vec<f64> = sent.iter().map(|v| v.abs()).collect();
        assert_eq!(zero(&one_way, &executed(-0.05), 0.004), None);
        assert_eq!(zero(&[], &[], 0.004), None);
    }
}
