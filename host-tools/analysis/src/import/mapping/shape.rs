//! From rows to those that count: a low-pass, every n-th row.

use super::channels::Channels;
use super::file::Filter;
use super::stamps::pieces;
use anyhow::{bail, ensure};
use softdock_report::number;
use softdock_statistics::LowPass;

/// Highest order whose sections are still well conditioned.
const HIGHEST_ORDER: u32 = 12;

/// Filters every channel alike between its gaps, and keeps every n-th row between the ends that are
/// left out.
///
/// # Errors
///
/// A cutoff that the sampling rate does not allow, before or after decimation; an order out of
/// its range; ends that leave nothing.
pub(super) fn filter(channels: &mut Channels, filter: &Filter) -> anyhow::Result<()> {
    let Filter {
        cutoff_hz,
        order,
        decimate,
        trim_s,
    } = *filter;
    let rate_hz = 1.0 / sample_time_s(&channels.time_s)?;
    ensure!(
        decimate >= 1 && decimate < channels.len(),
        "[filter] decimate is {decimate}; allowed is 1 to {}",
        channels.len().saturating_sub(1)
    );
    let highest = 0.5 * rate_hz / decimate as f64;
    ensure!(
        cutoff_hz > 0.0 && cutoff_hz < highest,
        "[filter] cutoff_hz is {cutoff_hz}; allowed is above 0 and below {} Hz, half of the rate \
         after decimation",
        number::significant(highest, 3)
    );
    ensure!(
        (1..=HIGHEST_ORDER).contains(&order),
        "[filter] order is {order}; allowed is 1 to {HIGHEST_ORDER}"
    );
    let trimmed = (trim_s * rate_hz).round();
    let most = (channels.len() / decimate).saturating_sub(2) as f64 * 0.5 * decimate as f64;
    ensure!(
        (0.0..=most).contains(&trimmed),
        "[filter] trim_s is {trim_s}; allowed is 0 to {} s, so that two rows are left",
        number::significant(most / rate_hz, 3)
    );
    let low_pass = LowPass::new(order, cutoff_hz / rate_hz);
    let pieces = pieces(&channels.time_s);
    if let Some(quaternion) = &mut channels.quaternion {
        continue_signs(quaternion);
    }
    for signal in channels.signals_mut() {
        let parts = pieces
            .iter()
            .map(|piece| low_pass.zero_phase(&signal[piece.clone()]));
        *signal = parts.collect::<Vec<_>>().concat();
    }
    if let Some(quaternion) = &mut channels.quaternion {
        normalise(quaternion);
    }
    let trimmed = trimmed as usize;
    let mut kept = vec![false; channels.len()];
    for piece in pieces {
        let (count, part) = (piece.len(), &mut kept[piece]);
        for (n, kept) in part.iter_mut().enumerate() {
            *kept = n % decimate == 0 && n >= trimmed && n + trimmed < count;
        }
    }
    channels.keep(|n| kept[n]);
    Ok(())
}

/// Median time from row to row, s.
///
/// # Errors
///
/// Fewer than two rows, or a time that does not rise.
pub(super) fn sample_time_s(times: &[f64]) -> anyhow::Result<f64> {
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    match steps.get(steps.len() / 2) {
        Some(step) if *step > 0.0 => Ok(*step),
        Some(step) => bail!("the time does not rise from row to row (median step {step} s)"),
        None => bail!("expected at least two rows, received {}", times.len()),
    }
}

/// A quaternion and its negative are the same orientation, but not for a filter.
pub(super) fn continue_signs(quaternion: &mut [Vec<f64>; 4]) {
    for n in 1..quaternion[0].len() {
        let along: f64 = quaternion.iter().map(|part| part[n] * part[n - 1]).sum();
        if along < 0.0 {
            quaternion.iter_mut().for_each(|part| part[n] = -part[n]);
        }
    }
}

/// Makes unit quaternions of them.
pub(super) fn normalise(quaternion: &mut [Vec<f64>; 4]) {
    for n in 0..quaternion[0].len() {
        let squares: f64 = quaternion.iter().map(|part| part[n] * part[n]).sum();
        if squares > 0.0 {
            let length = squares.sqrt();
            quaternion.iter_mut().for_each(|part| part[n] /= length);
        }
    }
}
