//! What a recording determines, and what it does not.
//!
//! A parameter is not determined if the recording hardly changes with it, if the best value lies at the end of its range, or if
//! it is correlated with another parameter so much that only the two together are known.

use super::least_squares::{Solution, norm};
use super::parameter::Parameter;
use softdock_report::number;
use softdock_statistics::DEVIATIONS_95;

/// A nominal parameter is visible if the recording determines it to less than so many tolerances.
const FEEBLE: f64 = 10.0;
/// Beyond this correlation two parameters cannot be told apart.
const SAME: f64 = 0.99;
/// Distance from the end of a range that counts as at the end, relative to the smaller of range and value.
const AT_END: f64 = 1e-6;
/// Digits of numbers in reasons.
const DIGITS: usize = 2;

/// Why a parameter is not determined.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Doubt {
    /// With all others known it would have this standard deviation, in its unit; infinite if nothing changes with it.
    Invisible(f64),
    /// The best value lies at this end of its range.
    AtEnd(f64),
    /// Another parameter has the same effect: its name, and the correlation.
    SameAs(String, f64),
}

impl Doubt {
    /// The parameter that does the same.
    pub(super) fn partner(&self) -> Option<&String> {
        match self {
            Self::SameAs(name, _) => Some(name),
            Self::Invisible(_) | Self::AtEnd(_) => None,
        }
    }

    /// In words.
    pub(super) fn reason(&self, of: &Parameter) -> String {
        let shown = |value: f64| format!("{} {}", number::significant(value, DIGITS), of.unit);
        match self {
            Self::Invisible(_) if of.tolerance.is_some() => {
                "this log says nothing about it beyond its tolerance".to_owned()
            }
            Self::Invisible(sigma) if !sigma.is_finite() => {
                "not determined by this log, because nothing in it changes with this parameter"
                    .to_owned()
            }
            Self::Invisible(sigma) => format!(
                "not determined by this log, because it would be known to ±{} only",
                shown(DEVIATIONS_95 * sigma)
            ),
            Self::AtEnd(end) => format!(
                "not determined by this log, because its best value lies beyond {}, which physics \
                 or the rig's size forbid",
                shown(*end)
            ),
            Self::SameAs(other, correlation) => format!(
                "not determined by this log, because {other} does the same (correlation \
                 {correlation:.3})"
            ),
        }
    }
}

/// Parameters that the recording would not determine even if all others were known, in rising order. `columns` are the
/// derivatives of the residuals.
pub(super) fn undetermined_alone(columns: &[Vec<f64>], free: &[Parameter]) -> Vec<(usize, Doubt)> {
    let sigma = columns.iter().map(|column| 1.0 / norm(column));
    sigma
        .enumerate()
        .filter(|(k, sigma)| !is_visible(&free[*k], *sigma))
        .map(|(k, sigma)| (k, Doubt::Invisible(sigma)))
        .collect()
}

fn is_visible(parameter: &Parameter, sigma: f64) -> bool {
    match parameter.tolerance {
        Some(tolerance) => sigma < FEEBLE * tolerance,
        None => sigma.is_finite() && sigma < 0.5 * (parameter.high - parameter.low),
    }
}

/// Parameters that are undetermined by a solution, in rising order. Of two that are correlated one is returned at a time.
pub(super) fn undetermined_together(
    solution: &Solution,
    free: &[Parameter],
) -> Vec<(usize, Doubt)> {
    let ends: Vec<(usize, Doubt)> = (0..free.len())
        .filter_map(|k| Some((k, at_end(&free[k], solution.values[k])?)))
        .collect();
    if !ends.is_empty() {
        return ends;
    }
    let pairs = (0..free.len()).flat_map(|i| (0..i).map(move |k| (k, i)));
    let worst = pairs
        .map(|(k, i)| (k, i, solution.correlation(k, i)))
        .filter(|(_, _, correlation)| correlation.abs() > SAME)
        .max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()));
    if let Some((k, i, correlation)) = worst {
        let (kept, held) = if is_more_certain(solution, free, k, i) {
            (i, k)
        } else {
            (k, i)
        };
        return vec![(held, Doubt::SameAs(free[kept].name.clone(), correlation))];
    }
    (0..free.len())
        .map(|k| (k, solution.sigma(k)))
        .filter(|(k, sigma)| free[*k].tolerance.is_none() && !is_visible(&free[*k], *sigma))
        .map(|(k, sigma)| (k, Doubt::Invisible(sigma)))
        .collect()
}

fn at_end(parameter: &Parameter, value: f64) -> Option<Doubt> {
    let near =
        AT_END * (parameter.high - parameter.low).min(parameter.value.abs() + parameter.step);
    [parameter.low, parameter.high]
        .into_iter()
        .find(|end| (value - end).abs() <= near)
        .map(Doubt::AtEnd)
}

/// Whether the first of two correlated parameters is the one to hold. It is if it alone has a prior, or if both have one and the
/// data add less to its prior than to the other's.
fn is_more_certain(solution: &Solution, free: &[Parameter], first: usize, second: usize) -> bool {
    match (free[first].tolerance, free[second].tolerance) {
        (Some(a), Some(b)) => solution.sigma(first) / a > solution.sigma(second) / b,
        (first, second) => first.is_some() && second.is_none(),
    }
}
