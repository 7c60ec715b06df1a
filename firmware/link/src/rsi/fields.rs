//! Element content into numbers, common to both telegrams.

use super::scan::{Event, Scanner, Token};
use super::{Field, RsiError};

/// Longest digits and point of a [`short_decimal`].
const SHORT_BYTES: usize = 15;

/// Attribute names of a pose or a correction, in the order of the arrays in this crate.
pub(super) const AXES: [u8; 6] = *b"XYZABC";

/// Receives the content of a telegram, element by element.
///
/// The elements are the children of the root, or of a `Dat` in the root, as old RSI 2 wraps them. Anything deeper is
/// skipped.
pub(super) trait Content {
    /// An attribute of the root element.
    fn root_attribute(&mut self, name: &[u8], value: Token<'_>) -> Result<(), RsiError>;
    /// An element starts.
    fn open(&mut self, element: &[u8], at: usize) -> Result<(), RsiError>;
    /// An attribute of an element.
    fn attribute(&mut self, element: &[u8], name: &[u8], value: Token<'_>) -> Result<(), RsiError>;
    /// The text of an element.
    fn text(&mut self, element: &[u8], text: Token<'_>) -> Result<(), RsiError>;
}

/// Runs through a telegram whose root element is `root`.
pub(super) fn read(bytes: &[u8], root: &[u8], content: &mut impl Content) -> Result<(), RsiError> {
    let mut scanner = Scanner::new(bytes);
    while let Some(event) = scanner.next()? {
        let element = match scanner.path() {
            [_] => None,
            [_, element] | [_, b"Dat", element] => Some(*element),
            _ => continue,
        };
        match (event, element) {
            (Event::Open { at }, None) if scanner.path() != [root] => {
                return Err(RsiError::WrongRoot { at });
            }
            (Event::Attribute { name, value }, None) => content.root_attribute(name, value)?,
            (Event::Open { at }, Some(element)) => content.open(element, at)?,
            (Event::Attribute { name, value }, Some(element)) => {
                content.attribute(element, name, value)?;
            }
            (Event::Text(text), Some(element)) => content.text(element, text)?,
            (Event::Open { .. } | Event::Text(_), None) | (Event::Close, _) => {}
        }
    }
    Ok(())
}

/// The six attributes of a pose or a correction.
pub(super) struct SixAxes<T> {
    field: Field,
    seen: bool,
    values: [Option<T>; 6],
}

impl<T: Copy> SixAxes<T> {
    pub(super) fn new(field: Field) -> Self {
        Self {
            field,
            seen: false,
            values: [None; 6],
        }
    }

    pub(super) fn open(&mut self, at: usize) -> Result<(), RsiError> {
        if core::mem::replace(&mut self.seen, true) {
            return Err(RsiError::Duplicate {
                field: self.field,
                at,
            });
        }
        Ok(())
    }

    /// Stores one attribute; names other than the six are skipped.
    pub(super) fn set(
        &mut self,
        name: &[u8],
        text: Token<'_>,
        parse: impl FnOnce(Token<'_>, Field) -> Result<T, RsiError>,
    ) -> Result<(), RsiError> {
        let slot = AXES
            .iter()
            .zip(&mut self.values)
            .find(|(axis, _)| name == [**axis]);
        match slot {
            Some((_, slot)) => set_once(slot, parse(text, self.field)?, self.field, text.at),
            None => Ok(()),
        }
    }

    /// All six; `None` if the element was not there, an error if it was there in part.
    pub(super) fn finish(self) -> Result<Option<[T; 6]>, RsiError> {
        if !self.seen {
            return Ok(None);
        }
        match self.values {
            [Some(x), Some(y), Some(z), Some(a), Some(b), Some(c)] => Ok(Some([x, y, z, a, b, c])),
            _ => Err(RsiError::Missing { field: self.field }),
        }
    }
}

/// Fills an empty slot; a full one means that the telegram contradicts itself.
pub(super) fn set_once<T>(
    slot: &mut Option<T>,
    value: T,
    field: Field,
    at: usize,
) -> Result<(), RsiError> {
    match slot.replace(value) {
        None => Ok(()),
        Some(_) => Err(RsiError::Duplicate { field, at }),
    }
}

/// The token as text without white space around it, if every byte of it passes `admit`.
pub(super) fn plain_text(token: Token<'_>, admit: impl Fn(u8) -> bool) -> Option<&str> {
    let bytes = token.bytes.trim_ascii();
    let admitted = bytes.iter().all(|byte| admit(*byte));
    core::str::from_utf8(bytes).ok().filter(|_| admitted)
}

/// A finite number: sign, digits, point and exponent. `inf`, `nan` and what overflows to infinity are refused.
pub(super) fn number(token: Token<'_>, field: Field) -> Result<f64, RsiError> {
    let admit =
        |byte: u8| byte.is_ascii_digit() || matches!(byte, b'+' | b'-' | b'.' | b'e' | b'E');
    short_decimal(token.bytes)
        .or_else(|| plain_text(token, admit)?.parse().ok())
        .filter(|value: &f64| value.is_finite())
        .ok_or(RsiError::BadValue {
            field,
            at: token.at,
        })
}

/// A number as robots write it: at most 15 digits, a point, no exponent. Its digits and the power of ten are exact
/// in `f64`, so that their quotient is the number nearest to the text, which `str::parse` finds at three times the
/// cost.
fn short_decimal(text: &[u8]) -> Option<f64> {
    const POWERS: [f64; SHORT_BYTES] = [
        1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14,
    ];
    let unsigned = text.strip_prefix(b"-").unwrap_or(text);
    if unsigned.len() > SHORT_BYTES {
        return None;
    }
    let (mut count, mut decimals, mut point) = (0_u64, 0, false);
    for byte in unsigned {
        match byte {
            b'0'..=b'9' => {
                count = count * 10 + u64::from(byte - b'0');
                decimals += usize::from(point);
            }
            b'.' if !point => point = true,
            _ => return None,
        }
    }
    if unsigned.len() == usize::from(point) {
        return None;
    }
    let magnitude = count as f64 / POWERS.get(decimals)?;
    let negative = unsigned.len() < text.len();
    Some(if negative { -magnitude } else { magnitude })
}

/// A count, which the robot writes as `3` or, from a DOUBLE channel, as `3.0`.
pub(super) fn count(token: Token<'_>, field: Field) -> Result<u32, RsiError> {
    let value = number(token, field)?;
    // The cast saturates, so that only a whole number in range survives the round trip.
    let count = value as u32;
    if f64::from(count) == value {
        Ok(count)
    } else {
        Err(RsiError::BadValue {
            field,
            at: token.at,
        })
    }
}

/// The time stamp: digits only, any `u64`.
pub(super) fn ipoc(token: Token<'_>) -> Result<u64, RsiError> {
    plain_text(token, |byte| byte.is_ascii_digit())
        .and_then(|text| text.parse().ok())
        .ok_or(RsiError::BadValue {
            field: Field::Ipoc,
            at: token.at,
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_short_decimal_is_what_parse_finds(text in "-?[0-9]{0,16}\\.?[0-9]{0,12}", any in "[-+.e0-9 ]{0,6}") {
            for text in [text, any] {
                if let Some(value) = short_decimal(text.as_bytes()) {
                    prop_assert_eq!(Ok(value.to_bits()), text.parse().map(f64::to_bits), "{}", text);
                }
            }
        }
    }

    fn token(text: &str) -> Token<'_> {
        Token {
            bytes: text.as_bytes(),
            at: 7,
        }
    }

    #[test]
    fn numbers() {
        let read = |text| number(token(text), Field::ActualPose);
        for (text, value) in [
            ("0.0", 0.0),
            (" -1.25\t", -1.25),
            ("+3", 3.0),
            ("1.5e-3", 1.5e-3),
            (".5", 0.5),
            ("1E2", 100.0),
        ] {
            assert_eq!(read(text), Ok(value));
        }
        for text in [
            "", " ", "-", ".", "e", "1e", "1e999", "inf", "nan", "NaN", "1,5", "0x1", "1 2",
            "&#49;", "1_0", "--1", "\0",
        ] {
            let error = RsiError::BadValue {
                field: Field::ActualPose,
                at: 7,
            };
            assert_eq!(read(text), Err(error), "{text}");
        }
    }

    #[test]
    fn counts_are_whole_and_in_range() {
        let read = |text| count(token(text), Field::LateAnswers).ok();
        assert_eq!(read("3"), Some(3));
        assert_eq!(read("3.0"), Some(3));
        assert_eq!(read("4294967295"), Some(u32::MAX));
        for text in ["4294967296", "-1", "0.5"] {
            assert_eq!(read(text), None);
        }
    }

    #[test]
    fn time_stamps_use_the_full_range() {
        assert_eq!(ipoc(token("18446744073709551615")), Ok(u64::MAX));
        for text in ["18446744073709551616", "-1", "+1", "1.0", ""] {
            assert!(ipoc(token(text)).is_err(), "{text}");
        }
    }
}
