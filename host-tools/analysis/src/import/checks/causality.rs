//! Does the robot move after it was commanded? If it moves before, the columns of sent and executed velocity are exchanged.

use super::Context;
use softdock_app::record::CycleRecord;
use softdock_physics::model::Axis;
use softdock_report::number;

/// Longest lag that is looked at, s: robots are late by less.
const LONGEST_S: f64 = 0.2;
/// ... in rows.
const MOST_ROWS: usize = 200;
/// Rows of a log that are enough to see who leads.
const ENOUGH: usize = 20_000;
/// The executed velocity leads if 1 − correlation at the best lead is below this share of that at the best delay. Noise leaves
/// about the same of both.
const LEADS: f64 = 0.25;

/// Appends a warning for each axis that looks wrong.
pub(super) fn check(
    cycles: &[CycleRecord],
    sample_time_s: f64,
    context: &Context<'_>,
    warnings: &mut Vec<String>,
) {
    let cycles = &cycles[..cycles.len().min(ENOUGH)];
    for axis in Axis::ALL {
        let sent = series(cycles, axis, |c| &c.trace.sent_velocity);
        let executed = series(cycles, axis, |c| &c.trace.executed_velocity);
        let Some(lead) = lead(&sent, &executed, most_rows(sample_time_s)) else {
            continue;
        };
        warnings.push(format!(
            "{}: the executed velocity {axis} is ahead of the sent one by {} ms: are the columns of [sent_velocity] and \
             [executed_velocity] exchanged?",
            context.name,
            number::significant(1e3 * lead as f64 * sample_time_s, 3)
        ));
    }
}

/// A velocity of an axis, row by row.
pub(super) fn series(
    cycles: &[CycleRecord],
    axis: Axis,
    of: fn(&CycleRecord) -> &[f64; 6],
) -> Vec<f64> {
    cycles.iter().map(|c| of(c)[axis.index()]).collect()
}

/// Rows within which a delay is looked for.
fn most_rows(sample_time_s: f64) -> usize {
    ((LONGEST_S / sample_time_s) as usize).min(MOST_ROWS)
}

/// Delay in rows at which the executed velocity correlates best with the sent one; None where one of them does not change.
pub(super) fn best_delay(sent: &[f64], executed: &[f64], sample_time_s: f64) -> Option<usize> {
    let few = |all: &[f64]| centred(&all[..all.len().min(ENOUGH)]);
    let (sent, executed) = (few(sent)?, few(executed)?);
    let late = (0..=most_rows(sample_time_s)).map(|lag| (lag, shifted(&sent, &executed, lag)));
    late.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(lag, _)| lag)
}

/// Rows by which the executed velocity is ahead of the sent one; None where it is not, or where the data do not tell.
fn lead(sent: &[f64], executed: &[f64], most: usize) -> Option<usize> {
    let [sent, executed] = [sent, executed].map(centred);
    let (sent, executed) = (sent?, executed?);
    let late = (0..=most).map(|lag| shifted(&sent, &executed, lag));
    let late = late.fold(f64::NEG_INFINITY, f64::max);
    let early = (1..=most).map(|lag| (lag, shifted(&executed, &sent, lag)));
    let (lag, early) = early.max_by(|a, b| a.1.total_cmp(&b.1))?;
    (1.0 - early < LEADS * (1.0 - late)).then_some(lag)
}

/// Correlation of two series, the second one shifted by `lag` rows, over the rows that overlap.
fn shifted(from: &[f64], to: &[f64], lag: usize) -> f64 {
    let later = to.get(lag..).unwrap_or_default();
    let sums = from.iter().zip(later);
    let [ab, aa, bb] = sums.fold([0.0; 3], |[ab, aa, bb], (a, b)| {
        [ab + a * b, aa + a * a, bb + b * b]
    });
    ab / (aa * bb).sqrt().max(f64::MIN_POSITIVE)
}

/// A series without its mean; None of one that does not change.
fn centred(series: &[f64]) -> Option<Vec<f64>> {
    let first = series.first()?;
    let changes = series.iter().any(|v| (v - first).abs() > 0.0);
    let mean = series.iter().sum::<f64>() / series.len() as f64;
    (changes && mean.is_finite()).then(|| series.iter().map(|v| v - mean).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two swings; `lag` rows later, with a little noise.
    fn motion(lag: f64) -> Vec<f64> {
        let at = |n: u32| {
            let t = 0.004 * (f64::from(n) - lag);
            let noise = f64::from(n.wrapping_mul(2_654_435_761) >> 16) / 65536.0 - 0.5;
            (2.0 * t).sin() + 0.4 * (5.3 * t).cos() + 2e-3 * noise
        };
        (0..3000).map(at).collect()
    }

    #[test]
    fn a_robot_is_late_and_never_early() {
        let sent = motion(0.0);
        assert_eq!(lead(&sent, &motion(8.0), 50), None);
        assert_eq!(lead(&sent, &sent, 50), None);
        assert_eq!(lead(&motion(8.0), &sent, 50), Some(8));
        assert_eq!(lead(&sent, &[0.0; 3000], 50), None);
        assert_eq!(lead(&[], &[], 50), None);
    }
}
