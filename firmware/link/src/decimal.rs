//! Exact decimal numbers held as an integer count of their last digit.
//!
//! A correction leaves the board as decimal text with a fixed number of digits. Holding it as a count makes the text exact: what
//! was sent is an integer that the controller can subtract from the intended value, and no floating-point formatting code is
//! needed on the board.

use core::fmt;
use core::str::FromStr;

/// A finite decimal number, `counts * 10^-decimals`.
///
/// It is displayed with exactly `decimals` digits behind the point: `Decimal { counts: -123, decimals: 4 }` is
/// `-0.0123`. Zero never carries a sign.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Decimal {
    /// The value in units of the last digit.
    pub counts: i64,
    /// Digits behind the point, 0 to [`Decimal::MAX_DECIMALS`].
    pub decimals: u8,
}

/// Why a number has no exact [`Decimal`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DecimalError {
    /// More digits behind the point than are supported.
    #[error("{decimals} digits behind the point, at most {max} are supported")]
    TooManyDecimals {
        /// Digits asked for or found.
        decimals: usize,
        /// [`Decimal::MAX_DECIMALS`].
        max: u8,
    },
    /// The value is not finite, or its count would not be exact.
    #[error("the number is too large for an exact decimal")]
    OutOfRange,
    /// The text is not `[+-]digits[.digits]`.
    #[error("expected a decimal number, found something else at byte {at}")]
    Syntax {
        /// Offset of the first byte that does not fit.
        at: usize,
    },
}

impl Decimal {
    /// Most digits behind the point: 1e-9 mm is far below what any robot resolves.
    pub const MAX_DECIMALS: u8 = 9;

    /// Largest text of a number with at most [`Self::MAX_DECIMALS`] digits behind the point: sign, the 19 digits of
    /// `i64::MIN`, point; or the 20 digits of a `u64`.
    pub const MAX_TEXT_BYTES: usize = 1 + 19 + 1;

    /// Counts up to this magnitude are exact in an `f64` (2^53).
    const EXACT_F64_COUNTS: f64 = 9_007_199_254_740_992.0;

    /// Zero with the given number of digits behind the point.
    pub const fn zero(decimals: u8) -> Self {
        Self {
            counts: 0,
            decimals,
        }
    }

    /// The decimal nearest to `value`, halves away from zero.
    ///
    /// # Errors
    /// [`DecimalError::TooManyDecimals`] above nine digits, [`DecimalError::OutOfRange`] for a value that is not
    /// finite or whose count exceeds 2^53.
    pub fn from_f64(value: f64, decimals: u8) -> Result<Self, DecimalError> {
        if decimals > Self::MAX_DECIMALS {
            return Err(DecimalError::TooManyDecimals {
                decimals: decimals.into(),
                max: Self::MAX_DECIMALS,
            });
        }
        let scaled = value * power_of_ten(decimals) as f64;
        if scaled.is_nan() || scaled.abs() >= Self::EXACT_F64_COUNTS {
            return Err(DecimalError::OutOfRange);
        }
        Ok(Self {
            counts: nearest(scaled),
            decimals,
        })
    }

    /// The nearest `f64`; the same number that a reader of the text would get for counts up to 2^53.
    pub fn to_f64(self) -> f64 {
        self.counts as f64 / power_of_ten(self.decimals) as f64
    }
}

/// The nearest integer, halves away from zero; saturates, and is 0 for NaN.
pub(crate) fn nearest(value: f64) -> i64 {
    let whole = value as i64;
    let rest = value - whole as f64;
    if rest >= 0.5 {
        whole.saturating_add(1)
    } else if rest <= -0.5 {
        whole.saturating_sub(1)
    } else {
        whole
    }
}

impl fmt::Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.decimals <= Self::MAX_DECIMALS {
            let text = &mut [0; Self::MAX_TEXT_BYTES];
            return f.write_str(core::str::from_utf8(self.text(text)).unwrap_or_default());
        }
        // More digits than any telegram has; `counts` and `decimals` are public, so this can occur.
        let sign = if self.counts < 0 { "-" } else { "" };
        let magnitude = self.counts.unsigned_abs();
        let (whole, fraction) = match 10_u64.checked_pow(self.decimals.into()) {
            Some(scale) => (magnitude / scale, magnitude % scale),
            // Scale above 2^64: there is no whole part.
            None => (0, magnitude),
        };
        write!(
            f,
            "{sign}{whole}.{fraction:0digits$}",
            digits = usize::from(self.decimals)
        )
    }
}

impl Decimal {
    /// The text of a number with at most [`Self::MAX_DECIMALS`] digits behind the point (more are taken for that
    /// many). Answering a telegram writes twelve numbers; this is several times cheaper than formatting them.
    pub(crate) fn text<'a>(&self, buffer: &'a mut [u8; Self::MAX_TEXT_BYTES]) -> &'a [u8] {
        let decimals = self.decimals.min(Self::MAX_DECIMALS);
        let sign = (self.counts < 0).then_some(b'-');
        text(sign, self.counts.unsigned_abs(), decimals.into(), buffer)
    }
}

/// The text of a whole number: as cheap as that of a [`Decimal`].
pub(crate) fn count_text(count: u64, buffer: &mut [u8; Decimal::MAX_TEXT_BYTES]) -> &[u8] {
    text(None, count, 0, buffer)
}

/// Sign, digits and point of `magnitude * 10^-decimals`, at the end of the buffer.
fn text(
    sign: Option<u8>,
    magnitude: u64,
    decimals: usize,
    buffer: &mut [u8; Decimal::MAX_TEXT_BYTES],
) -> &[u8] {
    let (mut rest, mut written) = (magnitude, 0);
    for place in buffer.iter_mut().rev() {
        // The digit before the point is written even if it is zero.
        let digits = written - usize::from(decimals > 0 && written > decimals);
        if rest == 0 && digits > decimals {
            if let Some(sign) = sign {
                *place = sign;
                written += 1;
            }
            break;
        }
        *place = if decimals > 0 && written == decimals {
            b'.'
        } else {
            b'0' + last_digit(&mut rest)
        };
        written += 1;
    }
    let start = buffer.len() - written;
    buffer.get(start..).unwrap_or_default()
}

/// Removes and returns the last digit of a number. A microcontroller divides 32 bits by one instruction, 64 bits in software.
fn last_digit(number: &mut u64) -> u8 {
    let digit = match u32::try_from(*number) {
        Ok(short) => {
            *number = (short / 10).into();
            short % 10
        }
        Err(_) => {
            let digit = *number % 10;
            *number /= 10;
            digit as u32
        }
    };
    // A remainder of ten fits.
    digit as u8
}

impl FromStr for Decimal {
    type Err = DecimalError;

    /// Reads `[+-]digits[.digits]` and keeps the number of digits behind the point.
    fn from_str(text: &str) -> Result<Self, DecimalError> {
        let (negative, sign_bytes) = match text.as_bytes().first() {
            Some(b'-') => (true, 1),
            Some(b'+') => (false, 1),
            _ => (false, 0),
        };
        let mut number = Self::zero(0);
        let mut point_seen = false;
        let mut digits = 0_usize;
        let mut decimals = 0_usize;
        for (at, byte) in text.bytes().enumerate().skip(sign_bytes) {
            match byte {
                b'.' if !point_seen => point_seen = true,
                b'0'..=b'9' => {
                    digits += 1;
                    decimals += usize::from(point_seen);
                    let digit = i64::from(byte - b'0');
                    number.counts = number
                        .counts
                        .checked_mul(10)
                        .and_then(|counts| {
                            counts.checked_add(if negative { -digit } else { digit })
                        })
                        .ok_or(DecimalError::OutOfRange)?;
                }
                _ => return Err(DecimalError::Syntax { at }),
            }
        }
        if digits == 0 {
            return Err(DecimalError::Syntax { at: text.len() });
        }
        number.decimals = u8::try_from(decimals)
            .ok()
            .filter(|decimals| *decimals <= Self::MAX_DECIMALS)
            .ok_or(DecimalError::TooManyDecimals {
                decimals,
                max: Self::MAX_DECIMALS,
            })?;
        Ok(number)
    }
}

/// 10^`exponent`, saturating above 10^19 so that no value of the public field can panic.
fn power_of_ten(exponent: u8) -> u64 {
    10_u64.saturating_pow(exponent.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn writes_fixed_digits() {
        let text = |counts, decimals| Decimal { counts, decimals }.to_string();
        assert_eq!(text(-123, 4), "-0.0123");
        assert_eq!(text(0, 4), "0.0000");
        assert_eq!(text(10_500, 3), "10.500");
        assert_eq!(text(-7, 0), "-7");
        assert_eq!(text(i64::MIN, 9), "-9223372036.854775808");
        assert_eq!(text(i64::MIN, 9).len(), Decimal::MAX_TEXT_BYTES);
        assert_eq!(text(1, 21), "0.000000000000000000001");
        let count = |n| count_text(n, &mut [0; Decimal::MAX_TEXT_BYTES]).to_vec();
        for n in [0, 9, u32::MAX.into(), u64::from(u32::MAX) + 1, u64::MAX] {
            assert_eq!(count(n), n.to_string().into_bytes());
        }
    }

    #[test]
    fn rounds_halves_away_from_zero_and_refuses_what_is_not_exact() {
        let counts = |value, decimals| Decimal::from_f64(value, decimals).map(|d| d.counts);
        assert_eq!(counts(0.5, 0), Ok(1));
        assert_eq!(counts(-0.5, 0), Ok(-1));
        assert_eq!(counts(0.499_999, 0), Ok(0));
        assert_eq!(counts(-0.012_34, 4), Ok(-123));
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e12] {
            assert_eq!(counts(bad, 4), Err(DecimalError::OutOfRange));
        }
        assert_eq!(
            counts(0.0, 10),
            Err(DecimalError::TooManyDecimals {
                decimals: 10,
                max: 9
            })
        );
    }

    #[test]
    fn one_sign_may_stand_before_the_digits() {
        let number = |counts, decimals| Ok(Decimal { counts, decimals });
        assert_eq!("+1.50".parse::<Decimal>(), number(150, 2));
        assert_eq!("-1.50".parse::<Decimal>(), number(-150, 2));
        assert_eq!(
            "+-1".parse::<Decimal>(),
            Err(DecimalError::Syntax { at: 1 })
        );
    }

    #[test]
    fn refuses_what_is_not_a_plain_decimal() {
        for (text, at) in [("", 0), ("-", 1), (".", 1), ("1.2.3", 3), ("1e3", 1)] {
            assert_eq!(text.parse::<Decimal>(), Err(DecimalError::Syntax { at }));
        }
        assert_eq!(
            "99999999999999999999".parse::<Decimal>(),
            Err(DecimalError::OutOfRange)
        );
        assert!("0.0000000001".parse::<Decimal>().is_err());
    }

    proptest! {
        #[test]
        fn text_round_trips(counts: i64, decimals in 0_u8..=9) {
            let number = Decimal { counts, decimals };
            prop_assert_eq!(number.to_string().parse::<Decimal>(), Ok(number));
        }

        #[test]
        fn float_is_the_float_of_the_text(counts in -(1_i64 << 53)..(1_i64 << 53), decimals in 0_u8..=9) {
            let number = Decimal { counts, decimals };
            prop_assert_eq!(number.to_string().parse::<f64>(), Ok(number.to_f64()));
        }

        #[test]
        fn from_float_is_within_half_a_digit(value in -1e5_f64..1e5, decimals in 0_u8..=9) {
            let number = Decimal::from_f64(value, decimals).unwrap();
            let half_digit = 0.5 / power_of_ten(decimals) as f64;
            prop_assert!((number.to_f64() - value).abs() <= half_digit * 1.000_001 + 1e-10);
        }
    }
}
