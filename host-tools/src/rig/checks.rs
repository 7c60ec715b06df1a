//! Range checks that name the field, the value and the allowed range.

use anyhow::{Result, anyhow, ensure};
use softdock_control::effects::OutOfRange;

/// `low <= value <= high`; NaN never is.
pub(super) fn check(field: &str, value: f64, low: f64, high: f64) -> Result<()> {
    ensure!(
        value >= low && value <= high,
        "{field} = {value}: allowed is {low} to {high}"
    );
    Ok(())
}

/// [`check`] for each component.
pub(super) fn check_all(field: &str, values: &[f64], low: f64, high: f64) -> Result<()> {
    values
        .iter()
        .try_for_each(|value| check(field, *value, low, high))
}

/// What an effect refused, under the name of the key that it was read from.
pub(super) fn named<T>(field: &str, built: Result<T, OutOfRange>) -> Result<T> {
    built.map_err(|error| {
        let OutOfRange {
            value, low, high, ..
        } = error;
        anyhow!("{field} = {value}: allowed is {low} to {high}")
    })
}

/// What an effect refused, where the keys are its parameters behind a prefix.
pub(super) fn prefixed<T, E: std::fmt::Display>(prefix: &str, built: Result<T, E>) -> Result<T> {
    built.map_err(|error| anyhow!("{prefix}{error}"))
}
