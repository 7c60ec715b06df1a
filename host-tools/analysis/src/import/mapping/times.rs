//! Times of rows: how far apart they are, and where gaps are.

use crate::import::checks::GAP;
use anyhow::bail;
use softdock_statistics::sample_time;
use std::ops::Range;

/// Time from row to row, s: see [`sample_time`].
///
/// # Errors
///
/// Fewer than two rows, or a time that does not rise.
pub(super) fn sample_time_s(times: &[f64]) -> anyhow::Result<f64> {
    match sample_time(times.iter().copied()) {
        Some(step) if step > 0.0 => Ok(step),
        Some(step) => bail!("the time does not rise from row to row (median step {step} s)"),
        None => bail!("expected at least two rows, received {}", times.len()),
    }
}

/// Stretches of rows without a gap.
pub(super) fn pieces(times: &[f64]) -> Vec<Range<usize>> {
    match sample_time_s(times) {
        Ok(median_s) => split(times, GAP * median_s),
        Err(_) => std::iter::once(0..times.len()).collect(),
    }
}

/// Numbers of the rows as cycles: they rise by one, and across a gap by the number of cycles that it lasts.
pub(super) fn cycle_numbers(times: &[f64]) -> Vec<u64> {
    let median_s = sample_time_s(times).unwrap_or(f64::INFINITY);
    let mut number = 0_u64;
    let rest = times.windows(2).map(|pair| {
        let cycles = (pair[1] - pair[0]) / median_s;
        let step = if cycles > GAP {
            (cycles.round() as u64).max(2)
        } else {
            1
        };
        // A gap in a file may have any length.
        number = number.saturating_add(step);
        number
    });
    std::iter::once(0).chain(rest).take(times.len()).collect()
}

/// Splits rows into pieces where more than `longest_s` passes from a row to the next.
pub(super) fn split(times: &[f64], longest_s: f64) -> Vec<Range<usize>> {
    let ends = (1..times.len()).filter(|n| times[*n] - times[n - 1] > longest_s);
    let mut pieces = Vec::new();
    let mut start = 0;
    for end in ends.chain([times.len()]) {
        pieces.push(start..end);
        start = end;
    }
    pieces
}
