//! Range checks that name the field, the value and the allowed range, as the controller's do.

use anyhow::{Result, anyhow, ensure};
use softdock_control::range::SettingsError;

/// `low <= value <= high`; NaN never is.
pub(super) fn check(field: &str, value: f64, low: f64, high: f64) -> Result<()> {
    ensure!(
        value >= low && value <= high,
        "`{field}` is {value}; allowed is {low} to {high}"
    );
    Ok(())
}

/// [`check`] for each component.
pub(super) fn check_all(field: &str, values: &[f64], low: f64, high: f64) -> Result<()> {
    values
        .iter()
        .try_for_each(|value| check(field, *value, low, high))
}

/// Turns the error of an effect into one that names the key from which the value was read.
pub(super) fn named<T>(field: &str, built: Result<T, SettingsError>) -> Result<T> {
    built.map_err(|error| {
        let SettingsError {
            received,
            low,
            high,
            ..
        } = error;
        anyhow!("`{field}` is {received}; allowed is {low} to {high}")
    })
}

/// The same where the keys are the names of the effect's parameters behind a prefix.
pub(super) fn prefixed<T>(prefix: &str, built: Result<T, SettingsError>) -> Result<T> {
    match built {
        Err(error) => named(&format!("{prefix}{}", error.field), Err(error)),
        Ok(value) => Ok(value),
    }
}
