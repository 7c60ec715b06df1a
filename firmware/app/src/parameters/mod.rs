//! Every setting of a board by its name: list, get and set, with unit, range and description.
//!
//! No list repeats the settings here. Names, types and order come from the types themselves, as in `schema`: [`BoardSettings`] is
//! read from its own bytes by a deserializer that follows the names (`walk`). Descriptions are the doc comments of the fields
//! (`description`), units the ends of their names (`unit`), and ranges come from the error of [`BoardSettings::validate`] for a
//! value beyond any range (`range`).
//!
//! An array or a matrix of numbers is one setting.

mod description;
mod range;
mod unit;
mod walk;

use crate::settings::BoardSettings;
use heapless::Vec;
use softdock_link::service::{ARRAY_MAX, Entry, Form, Refusal, Value};
use walk::{Kind, Leaf, Wanted, Width, find};

/// Room for all settings in postcard's format: they take about 1.4 kB.
const SETTINGS_BYTES: usize = 2048;
/// Room for the longest single value: an array.
const VALUE_BYTES: usize = ARRAY_MAX * size_of::<f64>();

/// All settings in postcard's format.
type Bytes = Vec<u8, SETTINGS_BYTES>;

fn bytes_of(settings: &BoardSettings) -> Option<Bytes> {
    let mut bytes = Bytes::new();
    bytes.resize_default(SETTINGS_BYTES).ok()?;
    let length = postcard::to_slice(settings, &mut bytes).ok()?.len();
    bytes.truncate(length);
    Some(bytes)
}

/// Number of settings.
pub fn count() -> u16 {
    bytes_of(&BoardSettings::default())
        .and_then(|bytes| walk::count::<BoardSettings>(&bytes).ok())
        .unwrap_or_default()
}

/// Calls `take` with the setting of this number, from 0, and returns its result. `None` beyond the last one.
pub fn with_entry<R>(
    settings: &BoardSettings,
    index: u16,
    take: impl FnOnce(Entry<'_>) -> R,
) -> Option<R> {
    let bytes = bytes_of(settings)?;
    let leaf = found(&bytes, Wanted::Index(index))?;
    let default_bytes = bytes_of(&BoardSettings::default())?;
    let default = found(&default_bytes, Wanted::Index(index))?;
    let words = match leaf.kind {
        Kind::Word(words) => words,
        _ => &[],
    };
    let entry = Entry {
        of: walk::count::<BoardSettings>(&bytes).ok()?,
        path: &leaf.path,
        form: leaf.kind.form(),
        value: value_of(&leaf, &bytes)?,
        default: value_of(&default, &default_bytes)?,
        range: range::of(&leaf, &bytes),
        words: Vec::from_slice(words).unwrap_or_default(),
        unit: unit::of(leaf.field),
        help: description::of(leaf.owner, leaf.field),
    };
    Some(take(entry))
}

/// Calls `take` with the value of a setting, and returns its result.
///
/// # Errors
/// There is no such setting.
pub fn get<R>(
    settings: &BoardSettings,
    path: &str,
    take: impl FnOnce(Value<'_>) -> R,
) -> Result<R, Refusal> {
    let bytes = bytes_of(settings).ok_or(Refusal::Unreadable)?;
    let leaf = found(&bytes, Wanted::Path(path)).ok_or(Refusal::UnknownName)?;
    value_of(&leaf, &bytes)
        .map(take)
        .ok_or(Refusal::UnknownName)
}

/// Changes a setting. Ranges are not checked, as settings that depend on each other change one by one.
///
/// # Errors
/// There is no such setting, or it takes another kind of value; the settings are as they were.
pub fn set(settings: &mut BoardSettings, path: &str, value: &Value<'_>) -> Result<(), Refusal> {
    let bytes = bytes_of(settings).ok_or(Refusal::Unreadable)?;
    let leaf = found(&bytes, Wanted::Path(path)).ok_or(Refusal::UnknownName)?;
    let new = encode(value, leaf.kind)?;
    // Only a text can be refused here, if it is too long.
    *settings = with_bytes(&bytes, &leaf, &new).ok_or(Refusal::UnknownWord)?;
    Ok(())
}

fn found(bytes: &[u8], wanted: Wanted<'_>) -> Option<Leaf> {
    find::<BoardSettings>(bytes, wanted).ok().flatten()
}

/// The settings with the bytes of a leaf replaced.
fn with_bytes(bytes: &Bytes, leaf: &Leaf, new: &[u8]) -> Option<BoardSettings> {
    let mut changed = Bytes::new();
    changed
        .extend_from_slice(bytes.get(..leaf.bytes.start)?)
        .ok()?;
    changed.extend_from_slice(new).ok()?;
    changed
        .extend_from_slice(bytes.get(leaf.bytes.end..)?)
        .ok()?;
    postcard::from_bytes(&changed).ok()
}

/// The value of a leaf of these bytes.
fn value_of<'a>(leaf: &Leaf, bytes: &'a [u8]) -> Option<Value<'a>> {
    let bytes = bytes.get(leaf.bytes.clone())?;
    Some(match leaf.kind {
        Kind::Flag => Value::Flag(postcard::from_bytes(bytes).ok()?),
        Kind::Whole(width) => Value::Whole(width.decode(bytes)?),
        Kind::Real => Value::Real(postcard::from_bytes(bytes).ok()?),
        Kind::Word(words) => {
            let index: u32 = postcard::from_bytes(bytes).ok()?;
            Value::Text(words.get(usize::try_from(index).ok()?)?)
        }
        Kind::Text => Value::Text(postcard::from_bytes(bytes).ok()?),
        Kind::Array { .. } => Value::Array(
            bytes
                .chunks_exact(size_of::<f64>())
                .map(|number| postcard::from_bytes::<f64>(number).ok())
                .collect::<Option<_>>()?,
        ),
    })
}

/// A value as encoded in the settings.
fn encode(value: &Value<'_>, kind: Kind) -> Result<Vec<u8, VALUE_BYTES>, Refusal> {
    let mut bytes = Vec::new();
    let _ = bytes.resize_default(VALUE_BYTES);
    let written = match (kind, value) {
        (Kind::Flag, Value::Flag(flag)) => postcard::to_slice(flag, &mut bytes),
        (Kind::Whole(width), Value::Whole(number)) => {
            return width.encode(*number).ok_or(Refusal::TooLarge);
        }
        (Kind::Real, Value::Real(number)) => postcard::to_slice(number, &mut bytes),
        (Kind::Word(words), Value::Text(text)) => {
            let index = words.iter().position(|word| word == text);
            let index = index.and_then(|index| u32::try_from(index).ok());
            postcard::to_slice(&index.ok_or(Refusal::UnknownWord)?, &mut bytes)
        }
        (Kind::Text, Value::Text(text)) => postcard::to_slice(text, &mut bytes),
        (Kind::Array { rows, columns }, Value::Array(numbers))
            if numbers.len() == usize::from(rows) * usize::from(columns) =>
        {
            // Without a length prefix, as the length of an array is fixed.
            let all = numbers.iter().flat_map(|number| number.to_le_bytes());
            return Ok(all.collect());
        }
        _ => return Err(Refusal::WrongForm),
    };
    let length = written.map_err(|_| Refusal::UnknownWord)?.len();
    bytes.truncate(length);
    Ok(bytes)
}

impl Kind {
    fn form(self) -> Form {
        match self {
            Self::Flag => Form::Flag,
            Self::Whole(_) => Form::Whole,
            Self::Real => Form::Real,
            Self::Word(_) => Form::Word,
            Self::Text => Form::Text,
            Self::Array { rows, columns } => Form::Array { rows, columns },
        }
    }
}

/// Encoding of whole numbers of each width.
macro_rules! widths {
    ($($width:ident $type:ty,)+) => {
        impl Width {
            fn decode(self, bytes: &[u8]) -> Option<i64> {
                match self {
                    $(Self::$width => i64::try_from(postcard::from_bytes::<$type>(bytes).ok()?).ok(),)+
                }
            }

            fn encode(self, number: i64) -> Option<Vec<u8, VALUE_BYTES>> {
                let mut bytes = [0; 10];
                let written = match self {
                    $(Self::$width => postcard::to_slice(&<$type>::try_from(number).ok()?, &mut bytes),)+
                };
                Vec::from_slice(written.ok()?).ok()
            }

            /// Smallest and largest number.
            fn limits(self) -> (i64, i64) {
                match self {
                    $(Self::$width => (
                        i64::try_from(<$type>::MIN).unwrap_or(i64::MIN),
                        i64::try_from(<$type>::MAX).unwrap_or(i64::MAX),
                    ),)+
                }
            }
        }
    };
}

widths! { U8 u8, U16 u16, U32 u32, U64 u64, I8 i8, I16 i16, I32 i32, I64 i64, }

#[cfg(test)]
mod tests;
