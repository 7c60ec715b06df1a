//! Time stamps: equal steps, gaps, and steps of any length.
//!
//! A comparison counts in cycles, so rows have to be equally far apart. Where they are not, the user
//! says what is done, and the import says what that cost: interpolated values look like measured ones.

use super::channels::Channels;
use super::file::{Duplicates, Gaps, Resample, Time};
use super::shape::{largest_turn, normalise, unroll};
use super::times::{pieces, sample_time_s, split};
use crate::import::checks::{GAP, ensure_rising};
use crate::import::turns;
use anyhow::{bail, ensure};
use softdock_report::number;
use std::f64::consts::PI;
use std::ops::Range;

/// Longer steps than this, in median steps, are gaps when rows are resampled. A cubic through four rows bridges no more than half
/// a period of the fastest motion: five rows, if a period has ten.
const RESAMPLED_GAP: f64 = 5.0;
/// Longest step that a cubic bridges, in periods of the low-pass's cutoff: faster motion is filtered out afterwards.
const BRIDGED_PERIODS: f64 = 0.5;
/// Number of rows over which time stamps are compared with equal steps: so few that a clock that drifts is regular.
const WINDOW: usize = 100;
/// Largest deviation of a stamp from equal steps, in steps, that rounding or a late stamp explains.
const LATE: f64 = 0.5;
/// Share of rows that may be farther off, or behind a gap, in a log of equal steps.
const FEW: f64 = 0.05;
/// Largest number of samples that resampling makes per row: more are a slip in a unit.
const FINEST: f64 = 100.0;
/// Rows that are closer than this part of the next step are a burst, stamped when they arrived: their difference quotient is no
/// slope. A cubic amplifies the error of a row from a step h into the next step H by (4/27) √2 H/h, which this limits to about 1.
const BURST: f64 = 0.2;
/// A sample closer to a row than this, in steps, takes the row's value.
const SAME: f64 = 1e-3;

/// Keeps one of several rows with the same time. The number of removed rows goes to `told`.
pub(super) fn without_duplicates(
    channels: &mut Channels,
    kept: Duplicates,
    name: &str,
    told: &mut Vec<String>,
) {
    let times = channels.time_s.clone();
    let same = |a: usize, b: Option<&f64>| b.is_some_and(|b| (b - times[a]).abs() <= 0.0);
    let is_kept = |n: usize| match kept {
        Duplicates::KeepFirst => !same(n, n.checked_sub(1).map(|n| &times[n])),
        Duplicates::KeepLast => !same(n, times.get(n + 1)),
    };
    let Some(first) = (0..times.len()).find(|n| !is_kept(*n)) else {
        return;
    };
    channels.keep(is_kept);
    told.push(format!(
        "{name}: {} of {} rows are left out, the first at {} s: another row has the same time, and `duplicates` in [time] says \
         which counts",
        times.len() - channels.len(),
        times.len(),
        number::significant(times[first], 6)
    ));
}

/// Interpolates missing values of each signal between its own rows that are not too far apart. The number of interpolated values
/// goes to `told`.
///
/// # Errors
///
/// Rows of several channels at uneven steps that are not resampled afterwards.
pub(super) fn fill_in(
    channels: &mut Channels,
    resamples: bool,
    name: &str,
    told: &mut Vec<String>,
) -> anyhow::Result<()> {
    let times = channels.time_s.clone();
    ensure!(
        resamples || are_even(&times),
        "{name}: rows of several channels, one behind the other, are not equally far apart: say `resample_hz` in [time], the rate \
         of the fastest"
    );
    unroll(channels);
    let counts = channels.signals_mut().map(|signal| fill(signal, &times));
    let counts: Vec<usize> = counts.collect();
    normalise(channels);
    let filled = channels.named().into_iter().zip(counts);
    let filled = filled.filter(|(_, count)| *count > 0);
    let filled: Vec<String> = filled
        .map(|((of, ..), count)| format!("{of} {count}"))
        .collect();
    if !filled.is_empty() {
        told.push(format!(
            "{name}: of {} rows values are interpolated from those of the same column: {}",
            times.len(),
            filled.join(", ")
        ));
    }
    Ok(())
}

/// [`fill_in`] of one signal. Returns the number of interpolated values.
fn fill(signal: &mut [f64], times: &[f64]) -> usize {
    let own = (0..times.len()).filter(|n| signal[*n].is_finite() && times[*n].is_finite());
    let (own_times, values): (Vec<f64>, Vec<f64>) = own.map(|n| (times[n], signal[n])).unzip();
    let longest_s = RESAMPLED_GAP * sample_time_s(&own_times).unwrap_or(0.0);
    let pieces = split(&own_times, longest_s);
    let cubic = Cubic {
        times: &own_times,
        values: &values,
        longest_s,
    };
    let between = |time: f64| {
        let row = own_times
            .partition_point(|own| *own <= time)
            .checked_sub(1)?;
        let piece = &pieces[pieces.partition_point(|piece| piece.end <= row)];
        (row + 1 < piece.end).then(|| cubic.at(time, row, piece))
    };
    let mut count = 0;
    let rows = signal.iter_mut().zip(times);
    for (value, time) in rows.filter(|(value, _)| !value.is_finite()) {
        if let Some(filled) = between(*time) {
            (*value, count) = (filled, count + 1);
        }
    }
    count
}

/// Whether nearly all steps are about the median one.
fn are_even(times: &[f64]) -> bool {
    /// Largest deviation from the median step, relative to it.
    const ABOUT: f64 = 0.25;
    let median_s = sample_time_s(times).unwrap_or(f64::INFINITY);
    let off = |pair: &&[f64]| ((pair[1] - pair[0]) / median_s - 1.0).abs() > ABOUT;
    times.windows(2).filter(off).count() as f64 <= FEW * times.len() as f64
}

/// Makes the steps of the rows equal, by resampling or by cutting or bridging gaps, as the mapping says. Notes on this go to
/// `told`. `cutoff_hz`: cutoff of the low-pass that follows, if any.
///
/// # Errors
///
/// Rows at unequal steps without `resample_hz`; an impossible rate.
pub(super) fn regular(
    channels: &mut Channels,
    time: &Time,
    cutoff_hz: Option<f64>,
    name: &str,
    told: &mut Vec<String>,
) -> anyhow::Result<()> {
    let times = channels.time_s.as_slice();
    // Checked before any row is filtered, interpolated or dropped.
    ensure_rising(name, times, |n| channels.rows[n])?;
    let median_s = sample_time_s(times)?;
    turns::ensure_told(&channels.uncounted(), &pieces(times), &channels.rows, name)?;
    match time.resample_hz {
        Some(rate) => {
            let step_s = match rate {
                Resample::Auto => median_s,
                Resample::Hz(hz) => 1.0 / hz,
            };
            let duration_s = times.last().unwrap_or(&0.0) - times[0];
            ensure!(
                median_s < FINEST * step_s,
                "[time] resample_hz: samples every {step_s} s of rows that are {median_s} s apart, more than {FINEST} for \
                 each; is the unit of the time right?"
            );
            ensure!(
                step_s > 0.0 && 2.0 * step_s < duration_s && duration_s / step_s < 1e8,
                "[time] resample_hz: samples every {step_s} s in {duration_s} s; expected a rate that \
                 gives at least two samples, and \"auto\" for the median of the rows, {median_s} s"
            );
            let bridged_s = cutoff_hz.map_or(0.0, |cutoff_hz| BRIDGED_PERIODS / cutoff_hz);
            resample(
                channels,
                step_s,
                bridged_s.max(RESAMPLED_GAP * median_s),
                time.gaps,
                name,
                told,
            );
        }
        None => {
            ensure_equal(times, median_s, name)?;
            gaps(channels, median_s, time.gaps, name, told);
        }
    }
    ensure_followed(channels, name)
}

/// Refuses unequal steps.
fn ensure_equal(times: &[f64], median_s: f64, name: &str) -> anyhow::Result<()> {
    let pieces = split(times, GAP * median_s);
    let late: usize = pieces
        .iter()
        .flat_map(|piece| times[piece.clone()].chunks(WINDOW))
        .map(|window| late(window, median_s))
        .sum();
    let off = late + pieces.len() - 1;
    if (off as f64) <= FEW * times.len() as f64 {
        return Ok(());
    }
    let steps = || times.windows(2).map(|pair| pair[1] - pair[0]);
    let shortest = steps().fold(f64::INFINITY, f64::min);
    let longest = steps().fold(0.0, f64::max);
    let word = |value: f64| number::significant(value, 3);
    bail!(
        "{name}: the time stamps are irregular: the rows are {} to {} s apart (median {} s), and {off} \
         of {} are not where equal steps would have them. Have them interpolated to equal steps: add to \
         the mapping\n  [time]\n  resample_hz = {}    # or \"auto\"",
        word(shortest),
        word(longest),
        word(median_s),
        times.len(),
        word(1.0 / median_s)
    )
}

/// Number of rows of a window that deviate from a straight line through it by more than [`LATE`].
fn late(window: &[f64], step_s: f64) -> usize {
    let count = window.len() as f64;
    let mean = window.iter().sum::<f64>() / count;
    let place = |n: usize| n as f64 - 0.5 * (count - 1.0);
    let places = || (0..window.len()).map(place);
    let slope = places()
        .zip(window)
        .map(|(p, t)| p * (t - mean))
        .sum::<f64>()
        / places().map(|p| p * p).sum::<f64>().max(1.0);
    let off = |(p, t): (f64, &f64)| (t - mean - slope * p).abs() > LATE * step_s;
    places().zip(window).filter(|both| off(*both)).count()
}

/// Cuts or bridges the gaps of rows with equal steps.
fn gaps(
    channels: &mut Channels,
    step_s: f64,
    gaps: Option<Gaps>,
    name: &str,
    told: &mut Vec<String>,
) {
    let pieces = split(&channels.time_s, GAP * step_s);
    let [first, _, ..] = pieces.as_slice() else {
        return;
    };
    let (count, at_s) = (pieces.len() - 1, channels.time_s[first.end - 1]);
    let rows = channels.len();
    match gaps {
        Some(Gaps::Bridge) => {
            let mut samples = Vec::with_capacity(rows);
            for (n, time) in channels.time_s.iter().enumerate() {
                if let Some(last) = n.checked_sub(1).map(|n| channels.time_s[n]) {
                    let steps = ((time - last) / step_s).round().max(1.0);
                    samples.extend(
                        (1..steps as usize).map(|i| last + (time - last) * i as f64 / steps),
                    );
                }
                samples.push(*time);
            }
            unroll(channels);
            interpolate(
                channels,
                &samples,
                GAP * step_s,
                std::slice::from_ref(&(0..rows)),
            );
            told.push(format!(
                "{name}: {count} gap(s), the first after {} s, bridged by straight lines: {} of {} \
                 rows are made up",
                number::significant(at_s, 6),
                channels.len() - rows,
                channels.len()
            ));
        }
        // Gaps are filled only on request. The check of the recording reports them.
        Some(Gaps::Cut) | None => {}
    }
}

/// Interpolates to equal steps, within the stretches between gaps or across them. Nothing is noted if the rows are at these times
/// already.
fn resample(
    channels: &mut Channels,
    step_s: f64,
    longest_s: f64,
    gaps: Option<Gaps>,
    name: &str,
    told: &mut Vec<String>,
) {
    unroll(channels);
    let before = channels.clone();
    let rows = before.time_s.as_slice();
    let found = split(rows, longest_s);
    let pieces = match gaps {
        Some(Gaps::Bridge) => std::iter::once(0..rows.len()).collect(),
        _ => found.clone(),
    };
    let samples = equal_steps(rows, &pieces, step_s);
    interpolate(channels, &samples, longest_s, &pieces);
    let share = interpolated(rows, &samples, step_s);
    if share <= 0.0 && samples.len() == rows.len() && found.len() == 1 {
        return;
    }
    let largest = rows.windows(2).map(|p| p[1] - p[0]).fold(0.0, f64::max);
    let what = match (found.len() - 1, gaps) {
        (0, _) => String::new(),
        (count, Some(Gaps::Bridge)) => format!(", {count} gap(s) bridged by straight lines"),
        (count, _) => format!(", {count} gap(s) cut out"),
    };
    told.push(format!(
        "{name}: resampled from {} rows to {} samples at {} Hz: {:.0} % are interpolated, the largest \
         step between rows is {} s{what}. Changed by it, which holds what was faster than {} Hz (rms, \
         and part of the channel): {}",
        rows.len(),
        samples.len(),
        number::significant(1.0 / step_s, 4),
        100.0 * share,
        number::significant(largest, 3),
        number::significant(0.5 / step_s, 3),
        losses(&before, channels, longest_s)
    ));
}

/// Times of equal steps from the first row on, s, as far as the pieces reach.
fn equal_steps(rows: &[f64], pieces: &[Range<usize>], step_s: f64) -> Vec<f64> {
    let start = rows[0];
    let place = |row: usize| (rows[row] - start) / step_s;
    let of_piece = |piece: &Range<usize>| {
        let from = (place(piece.start) - SAME).ceil() as u64;
        let to = (place(piece.end - 1) + SAME).floor() as u64;
        (from..=to).map(|k| start + k as f64 * step_s)
    };
    pieces.iter().flat_map(of_piece).collect()
}

/// Refuses a rotation of half a turn or more between neighbouring rows: its direction is ambiguous.
fn ensure_followed(channels: &Channels, name: &str) -> anyhow::Result<()> {
    let (turn, after_s) = largest_turn(channels, |_| true);
    let rate_hz = 1.0 / sample_time_s(&channels.time_s)?;
    ensure!(
        turn < PI,
        "{name}: at {} Hz it turns by up to {} rad from a row to the next (after {} s), and of half a turn or more nobody can tell which \
         way; expected [time] resample_hz of more than {}, other [rows] if the angle is wrong there, or the angle as a [position]",
        number::significant(rate_hz, 4),
        number::significant(turn, 3),
        number::significant(after_s, 6),
        number::significant(rate_hz * turn / PI, 4)
    );
    Ok(())
}

/// Share of the samples that are not at a row.
fn interpolated(rows: &[f64], samples: &[f64], step_s: f64) -> f64 {
    let at_row = |sample: &&f64| {
        let next = rows.partition_point(|row| row < *sample);
        let near = [next.checked_sub(1), Some(next)].into_iter().flatten();
        near.filter_map(|n| rows.get(n))
            .any(|row| (row - *sample).abs() <= SAME * step_s)
    };
    let same = samples.iter().filter(at_row).count();
    1.0 - same as f64 / samples.len().max(1) as f64
}

/// Changes of each channel by resampling, in words: the samples are interpolated back to the times of the rows and compared with
/// them.
fn losses(before: &Channels, after: &Channels, longest_s: f64) -> String {
    let mut back = after.clone();
    let longest_s = longest_s.max(GAP * sample_time_s(&after.time_s).unwrap_or(longest_s));
    let whole = 0..after.len();
    interpolate(
        &mut back,
        &before.time_s,
        longest_s,
        std::slice::from_ref(&whole),
    );
    let rms = |values: &dyn Fn(usize) -> f64| {
        let squares: f64 = (0..before.len()).map(|n| values(n).powi(2)).sum();
        (squares / before.len().max(1) as f64).sqrt()
    };
    let lost =
        before
            .named()
            .into_iter()
            .zip(back.named())
            .filter_map(|((channel, unit, a), (.., b))| {
                let mean = a.iter().sum::<f64>() / a.len().max(1) as f64;
                let whole = rms(&|n| a[n] - mean);
                let changed = rms(&|n| a[n] - b[n]);
                let part = 100.0 * changed / whole;
                // Smaller shares would print as zero.
                (part >= 0.005).then(|| {
                    let space = if unit.is_empty() { "" } else { " " };
                    format!(
                        "{channel} {}{space}{unit} ({part:.2} %)",
                        number::significant(changed, 2)
                    )
                })
            });
    match lost.collect::<Vec<_>>().as_slice() {
        [] => "nothing".to_owned(),
        lost => lost.join(", "),
    }
}

/// Interpolates all channels to the rising times `samples`; orientations have to be [ready](unroll). Steps longer than
/// `longest_s` are bridged by straight lines.
fn interpolate(channels: &mut Channels, samples: &[f64], longest_s: f64, pieces: &[Range<usize>]) {
    let rows = std::mem::take(&mut channels.time_s);
    // The row at or before each sample and the piece that it is in.
    let mut places = Vec::with_capacity(samples.len());
    let (mut row, mut piece) = (0, 0);
    for sample in samples {
        while row + 1 < rows.len() && rows[row + 1] <= *sample {
            row += 1;
        }
        // A sample that is before a piece by round-off belongs to it.
        while piece + 1 < pieces.len() && rows[pieces[piece + 1].start] <= sample + SAME * longest_s
        {
            piece += 1;
        }
        places.push((row.max(pieces[piece].start), piece));
    }
    for signal in channels.signals_mut() {
        let cubic = Cubic {
            times: &rows,
            values: signal,
            longest_s,
        };
        let samples = samples.iter().zip(&places);
        let values = samples
            .map(|(t, (row, piece))| cubic.at(*t, *row, &pieces[*piece]))
            .collect();
        *signal = values;
    }
    channels.running = places
        .iter()
        .map(|(row, _)| channels.running[*row])
        .collect();
    channels.time_s = samples.to_vec();
    channels.rows.clear();
    normalise(channels);
}

/// Cubic Hermite interpolation. The slope at a row is that of the parabola through it and its neighbours, so that a parabola is
/// reproduced at any steps. Beside a burst it is the slope of the straight line over the longer step.
struct Cubic<'a> {
    times: &'a [f64],
    values: &'a [f64],
    /// Longer steps are bridged by a straight line, s.
    longest_s: f64,
}

impl Cubic<'_> {
    /// Value at a time between `row` and the next one of its piece; at the end of the piece the value of `row`.
    fn at(&self, time: f64, row: usize, piece: &Range<usize>) -> f64 {
        let (from, to) = (row, row + 1);
        if to >= piece.end || time <= self.times[from] {
            return self.values[from];
        }
        let step = self.times[to] - self.times[from];
        let u = (time - self.times[from]) / step;
        let rise = self.values[to] - self.values[from];
        if step > self.longest_s {
            return self.values[from] + u * rise;
        }
        let (a, b) = (step * self.slope(from, piece), step * self.slope(to, piece));
        self.values[from] + u * (a + u * (3.0 * rise - 2.0 * a - b + u * (a + b - 2.0 * rise)))
    }

    fn slope(&self, n: usize, piece: &Range<usize>) -> f64 {
        let secant = |from: usize| {
            let step = self.times[from + 1] - self.times[from];
            ((self.values[from + 1] - self.values[from]) / step, step)
        };
        let before = (n > piece.start).then(|| secant(n - 1));
        let after = (n + 1 < piece.end).then(|| secant(n));
        match (before, after) {
            (Some((s, h)), Some((t, k))) => {
                let (near, far) = if h < k { (s, t) } else { (t, s) };
                if h.max(k) > self.longest_s {
                    near
                } else if h.min(k) < BURST * h.max(k) {
                    far
                } else {
                    (s * k + t * h) / (h + k)
                }
            }
            (Some((s, _)), None) | (None, Some((s, _))) => s,
            (None, None) => 0.0,
        }
    }
}
