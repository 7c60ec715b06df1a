//! The range of a setting, from the validation error for a value beyond it.

use super::walk::{Kind, Leaf, Width};
use super::{Bytes, encode, value_of, with_bytes};
use crate::settings::BoardSettingsError;
use softdock_control::range::SettingsError;
use softdock_link::service::Value;

/// A value that no real setting allows.
const BEYOND_ALL: f64 = 1e300;
/// Prefix of the control settings, which their validation leaves out of names.
const CONTROL: &str = "control.";

/// Smallest and largest value, given the other settings in these bytes; `None` if it takes no numbers, or its validation does not
/// bound them.
pub(super) fn of(leaf: &Leaf, bytes: &Bytes) -> Option<(f64, f64)> {
    match leaf.kind {
        Kind::Flag | Kind::Word(_) | Kind::Text => None,
        Kind::Real => refused(leaf, bytes, &Value::Real(BEYOND_ALL)),
        Kind::Whole(width) => Some(whole(leaf, bytes, width)),
        Kind::Array { .. } => {
            let Some(Value::Array(mut numbers)) = value_of(leaf, bytes) else {
                return None;
            };
            *numbers.first_mut()? = BEYOND_ALL;
            refused(leaf, bytes, &Value::Array(numbers))
        }
    }
}

/// If validation gives no bound, every number of the type is allowed.
fn whole(leaf: &Leaf, bytes: &Bytes, width: Width) -> (f64, f64) {
    let (low, high) = width.limits();
    let beyond = |number| refused(leaf, bytes, &Value::Whole(number));
    beyond(high)
        .or_else(|| beyond(low).map(|(lowest, _)| (lowest, high as f64)))
        .unwrap_or((low as f64, high as f64))
}

/// The range in the error about a value, if it is about this setting.
fn refused(leaf: &Leaf, bytes: &Bytes, value: &Value<'_>) -> Option<(f64, f64)> {
    let new = encode(value, leaf.kind).ok()?;
    let error = with_bytes(bytes, leaf, &new)?.validate().err()?;
    let BoardSettingsError::Range(SettingsError {
        field, low, high, ..
    }) = error
    else {
        return None;
    };
    let path = leaf.path.as_str();
    let same = field == path || path.strip_prefix(CONTROL) == Some(field);
    same.then_some((low, high))
}
