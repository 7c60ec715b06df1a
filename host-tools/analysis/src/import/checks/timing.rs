//! Does the time rise, and in equal steps?

use super::{CheckError, Context};
use softdock_app::record::CycleRecord;
use softdock_report::number;
use softdock_statistics::median;

/// How far the mean step may be from the promised one, relative: clocks are better than that.
const SAME_RATE: f64 = 0.01;
/// A step of more than so many median steps is a gap: a row is missing.
pub(in crate::import) const GAP: f64 = 1.5;
/// Missing rows make a step of a whole number of median steps within this share: a clock that is later by chance, equally often at
/// any time, comes as close in one of three gaps about two steps.
const WHOLE: f64 = 0.08;
/// A log of motions with slower rows than this was probably written in other units, s.
const SLOWEST_S: f64 = 0.5;
/// ... and one with faster rows, s.
const FASTEST_S: f64 = 2e-5;

/// Checks the times and returns the median step, s.
pub(super) fn check(
    cycles: &[CycleRecord],
    context: &Context<'_>,
    warnings: &mut Vec<String>,
) -> Result<f64, CheckError> {
    let name = context.name;
    let times: Vec<f64> = cycles.iter().map(|c| c.trace.time_s).collect();
    let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    ensure_rising(name, &times, |n| n + 1)?;
    let median = typical(&steps);
    match context.sample_time_s {
        Some(expected_s) => ensure_rate(name, &steps, median, expected_s)?,
        None => warnings.extend(other_unit(context, median)),
    }
    if !context.at_rest() {
        warnings.extend(two_rates(name, &times, &steps, median));
        warnings.extend(gaps(name, cycles, &steps, median));
    }
    Ok(median)
}

/// Refuses a mean step that differs from the stated sample time. Gaps are left out of the mean.
fn ensure_rate(name: &str, steps: &[f64], median: f64, expected_s: f64) -> Result<(), CheckError> {
    let kept = steps.iter().filter(|step| **step <= GAP * median);
    let (sum, count) = kept.fold((0.0, 0_usize), |(sum, n), step| (sum + step, n + 1));
    let received_s = sum / count.max(1) as f64;
    if (received_s / expected_s - 1.0).abs() > SAME_RATE {
        return Err(CheckError::SampleTime {
            name: name.to_owned(),
            expected_s,
            received_s,
        });
    }
    Ok(())
}

/// A warning if the median step is unlikely to be in seconds.
fn other_unit(context: &Context<'_>, median: f64) -> Option<String> {
    let question = match median {
        slow if !context.at_rest() && slow > SLOWEST_S => {
            "is the time in milliseconds? Say `unit = \"ms\"`"
        }
        fast if fast < FASTEST_S => "is the unit of the time right? Say `unit` or `scale`",
        _ => return None,
    };
    let apart = number::significant(median, 3);
    Some(format!(
        "{}: the rows are {apart} s apart; {question} for `column` in [time] of the mapping",
        context.name
    ))
}

/// A warning about missing rows, and what becomes of the others.
fn gaps(name: &str, cycles: &[CycleRecord], steps: &[f64], median: f64) -> Option<String> {
    let gaps: Vec<usize> = (0..steps.len())
        .filter(|n| steps[*n] > GAP * median)
        .collect();
    let first = *gaps.first()?;
    let counted = |n: &usize| cycles[n + 1].trace.cycle > cycles[*n].trace.cycle + 1;
    let so = if gaps.iter().all(counted) {
        let missing = gaps.iter().filter(|n| is_whole(steps[**n] / median));
        match 2 * missing.count() >= gaps.len() {
            true => {
                "the row behind a gap begins anew, and nothing is concluded across it (an import with \
                 `gaps = \"bridge\"` in [time] fills short ones)"
            }
            false => {
                "most of them are no whole numbers of steps, so that rows are late rather than missing. The row behind each begins \
                 anew, and nothing is concluded across it; an import with `resample_hz = \"auto\"` in [time] interpolates to \
                 equal steps"
            }
        }
    } else {
        "what is behind a gap is compared as if it followed directly, so import the parts one \
         by one"
    };
    Some(format!(
        "{name}, row {}: {} s are missing after {} s ({} such gap(s)); {so}",
        first + 2,
        number::significant(steps[first] - median, 3),
        number::significant(cycles[first].trace.time_s, 6),
        gaps.len()
    ))
}

/// Whether rows that are so many median steps apart have whole rows missing between them.
fn is_whole(steps: f64) -> bool {
    (steps - steps.round()).abs() < WHOLE * steps
}

/// Refuses times that do not rise in every row; `row`: what the n-th is called.
pub(in crate::import) fn ensure_rising(
    name: &str,
    times: &[f64],
    row: impl Fn(usize) -> usize,
) -> Result<(), CheckError> {
    let rises = |pair: &[f64]| pair[0] < pair[1]; // not so for NaN
    let Some(n) = times.windows(2).position(|pair| !rises(pair)) else {
        return Ok(());
    };
    let (before_s, time_s) = (times[n], times[n + 1]);
    Err(CheckError::TimeNotRising {
        name: name.to_owned(),
        row: row(n + 1),
        time_s,
        before_s,
        remedy: match time_s < before_s {
            true => {
                "are two logs in one file, of which [rows] of a mapping takes one, or are its rows not in order?"
            }
            false => {
                "with `duplicates = \"keep_first\"` in [time] of a mapping one of several with the same time is kept; if its stamps \
                 have too few digits, rows are equally far apart with `sample_time_s` for `column`"
            }
        },
    })
}

/// A warning if a part of the log is sampled at another rate.
fn two_rates(name: &str, times: &[f64], steps: &[f64], overall: f64) -> Option<String> {
    // A tenth of the log at a time; a rate that changes shows in the median of a part.
    let part = (steps.len() / 10).max(10);
    let other = steps
        .chunks(part)
        .enumerate()
        .filter(|(_, steps)| steps.len() >= 10)
        .map(|(i, steps)| (i * part, typical(steps)))
        .find(|(_, step)| !(0.75..=1.0 / 0.75).contains(&(step / overall)))?;
    Some(format!(
        "{name}: two sample times in one file: mostly {} s, but {} s from {} s on; import them \
         one by one",
        number::significant(overall, 3),
        number::significant(other.1, 3),
        times[other.0]
    ))
}

fn typical(steps: &[f64]) -> f64 {
    median(&mut steps.to_vec()).unwrap_or(0.0)
}
