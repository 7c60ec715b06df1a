//! Range checks of settings, and the error that names field, value and range.

use core::ops::RangeInclusive;

/// Largest component of a quaternion in the settings; it is normalised when it is read.
pub(crate) const LARGEST_QUATERNION: f64 = 1.0e3;

/// Dotted name of a settings field.
pub type FieldName = &'static str;

/// A settings value outside of its allowed range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SettingsError {
    /// Dotted name of the field.
    pub field: FieldName,
    /// The value that was given.
    pub received: f64,
    /// Smallest allowed value.
    pub low: f64,
    /// Largest allowed value.
    pub high: f64,
}

impl core::fmt::Display for SettingsError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self {
            field,
            received,
            low,
            high,
        } = self;
        write!(f, "`{field}` is {received}; allowed is {low} to {high}")
    }
}

impl core::error::Error for SettingsError {}

/// `Ok` if `value` lies in `low..=high` (NaN does not).
pub fn in_range(field: FieldName, value: f64, low: f64, high: f64) -> Result<(), SettingsError> {
    if value >= low && value <= high {
        Ok(())
    } else {
        Err(SettingsError {
            field,
            received: value,
            low,
            high,
        })
    }
}

/// Numbers of a setting, each of which lies in a range.
pub trait Ranged {
    /// `Ok` if all of them do.
    fn check(&self, field: FieldName, range: RangeInclusive<f64>) -> Result<(), SettingsError>;
}

impl Ranged for f64 {
    fn check(&self, field: FieldName, range: RangeInclusive<f64>) -> Result<(), SettingsError> {
        in_range(field, *self, *range.start(), *range.end())
    }
}

macro_rules! ranged {
    ($($whole:ty),*) => {
        $(impl Ranged for $whole {
            fn check(&self, field: FieldName, range: RangeInclusive<f64>) -> Result<(), SettingsError> {
                f64::from(*self).check(field, range)
            }
        })*
    };
}

ranged! { u8, u16, i16, u32 }

impl<T: Ranged, const N: usize> Ranged for [T; N] {
    fn check(&self, field: FieldName, range: RangeInclusive<f64>) -> Result<(), SettingsError> {
        self.iter()
            .try_for_each(|each| each.check(field, range.clone()))
    }
}

/// `Ok` if every value lies in `-limit..=limit`.
pub fn all_within(field: FieldName, values: &[f64], limit: f64) -> Result<(), SettingsError> {
    values
        .iter()
        .try_for_each(|v| in_range(field, *v, -limit, limit))
}
