//! The range of a setting, from what its validation says to values that it cannot allow.

use super::walk::{Kind, Leaf, Width};
use super::{Bytes, encode, value_of, with_bytes};
use crate::settings::BoardSettingsError;
use softdock_control::range::SettingsError;
use softdock_link::service::Value;

/// No real setting allows it.
const BEYOND_ALL: f64 = 1e300;
/// Validation of the control settings leaves their place in the whole out of its names.
const CONTROL: &str = "control.";

/// Smallest and largest value beside the other settings of these bytes; none if it takes no numbers,
/// or its validation says nothing of them.
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

/// Where validation says nothing, every number of the type is allowed.
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
