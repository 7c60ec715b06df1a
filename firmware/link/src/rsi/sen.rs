//! Our answer, `<Sen>`: written by the board, read by a simulated robot.

use core::fmt::{self, Write};

use super::fields::{self, AXES, Content, SixAxes, set_once};
use super::scan::Token;
use super::writer::Writer;
use super::{Field, Name, RsiError, SenTelegram, Tags};
use crate::decimal::Decimal;

/// Longest message for the operator panel, in characters before escaping; the rest is cut off.
const MAX_MESSAGE_CHARS: usize = 48;

/// A buffer of this size holds every answer whose correction has at most [`Decimal::MAX_DECIMALS`] decimals.
pub const SEN_MAX_BYTES: usize = {
    const NAME: usize = Name::MAX_BYTES;
    const ESCAPED_CHAR: usize = b"&quot;".len();
    let root = b"<Sen Type=\"\"></Sen>".len() + NAME;
    let message = b"<EStr></EStr>".len() + MAX_MESSAGE_CHARS * ESCAPED_CHAR;
    let axis = b" X=\"\"".len() + Decimal::MAX_TEXT_BYTES;
    let correction = b"</>".len() + NAME + AXES.len() * axis;
    let stop = b"<>1</>".len() + 2 * NAME;
    let ipoc = b"<IPOC>18446744073709551615</IPOC>".len();
    root + message + correction + stop + ipoc
};

/// Writes an answer and returns its length. No line break, no declaration, nothing that is not configured.
///
/// # Errors
/// [`RsiError::BufferTooSmall`]; [`SEN_MAX_BYTES`] are always enough.
pub fn write_sen(telegram: &SenTelegram, tags: &Tags, out: &mut [u8]) -> Result<usize, RsiError> {
    write(telegram, None, tags, out)
}

/// Like [`write_sen`], with a message for the operator panel (`EStr`).
///
/// KUKA shows the message as it is; a prefix such as `Error:` is customary. Longer messages are cut off.
///
/// # Errors
/// As [`write_sen`].
pub fn write_sen_with_message(
    telegram: &SenTelegram,
    message: &str,
    tags: &Tags,
    out: &mut [u8],
) -> Result<usize, RsiError> {
    write(telegram, Some(message), tags, out)
}

fn write(
    telegram: &SenTelegram,
    message: Option<&str>,
    tags: &Tags,
    out: &mut [u8],
) -> Result<usize, RsiError> {
    let mut writer = Writer::new(out);
    let available = writer.capacity();
    let mut write = || -> fmt::Result {
        writer.write_str("<Sen Type=\"")?;
        writer.write_ascii(tags.sentype.as_bytes())?;
        writer.write_str("\">")?;
        if let Some(message) = message {
            writer.write_str("<EStr>")?;
            writer.write_escaped(message, MAX_MESSAGE_CHARS)?;
            writer.write_str("</EStr>")?;
        }
        writer.write_axes(tags.correction.as_bytes(), &telegram.correction)?;
        if let Some(name) = tags.stop {
            let stop = if telegram.stop { b">1</" } else { b">0</" };
            for part in [b"<", name.as_bytes(), stop, name.as_bytes(), b">"] {
                writer.write_ascii(part)?;
            }
        }
        writer.write_ipoc(telegram.ipoc)?;
        writer.write_str("</Sen>")
    };
    write().map_err(|fmt::Error| RsiError::BufferTooSmall { available })?;
    Ok(writer.len())
}

/// Reads an answer, as the robot does.
///
/// # Errors
/// Whatever is not a complete, unambiguous answer with six plain decimals in the correction and with the right
/// `SENTYPE`.
pub fn parse_sen(bytes: &[u8], tags: &Tags) -> Result<SenTelegram, RsiError> {
    let mut sen = Sen {
        tags,
        type_matches: None,
        ipoc: None,
        correction: SixAxes::new(Field::Correction),
        stop: None,
    };
    fields::read(bytes, b"Sen", &mut sen)?;
    let missing = |field| RsiError::Missing { field };
    sen.type_matches.ok_or(missing(Field::SenType))?;
    Ok(SenTelegram {
        ipoc: sen.ipoc.ok_or(missing(Field::Ipoc))?,
        correction: sen.correction.finish()?.ok_or(missing(Field::Correction))?,
        stop: sen.stop.unwrap_or(false),
    })
}

/// What has been read so far.
struct Sen<'t> {
    tags: &'t Tags,
    type_matches: Option<()>,
    ipoc: Option<u64>,
    correction: SixAxes<Decimal>,
    stop: Option<bool>,
}

impl Content for Sen<'_> {
    fn root_attribute(&mut self, name: &[u8], value: Token<'_>) -> Result<(), RsiError> {
        let field = Field::SenType;
        if !name.eq_ignore_ascii_case(b"Type") {
            return Ok(());
        }
        if value.bytes != self.tags.sentype.as_bytes() {
            return Err(RsiError::BadValue {
                field,
                at: value.at,
            });
        }
        set_once(&mut self.type_matches, (), field, value.at)
    }

    fn open(&mut self, element: &[u8], at: usize) -> Result<(), RsiError> {
        if element == self.tags.correction.as_bytes() {
            return self.correction.open(at);
        }
        Ok(())
    }

    fn attribute(&mut self, element: &[u8], name: &[u8], value: Token<'_>) -> Result<(), RsiError> {
        if element == self.tags.correction.as_bytes() {
            return self.correction.set(name, value, decimal);
        }
        Ok(())
    }

    fn text(&mut self, element: &[u8], text: Token<'_>) -> Result<(), RsiError> {
        if element == b"IPOC" {
            let ipoc = fields::ipoc(text)?;
            return set_once(&mut self.ipoc, ipoc, Field::Ipoc, text.at);
        }
        if self
            .tags
            .stop
            .is_some_and(|name| name.as_bytes() == element)
        {
            let stop = boolean(text, Field::Stop)?;
            return set_once(&mut self.stop, stop, Field::Stop, text.at);
        }
        Ok(())
    }
}

/// A plain decimal number.
fn decimal(token: Token<'_>, field: Field) -> Result<Decimal, RsiError> {
    fields::plain_text(token, |byte| byte.is_ascii())
        .and_then(|text| text.parse().ok())
        .ok_or(RsiError::BadValue {
            field,
            at: token.at,
        })
}

/// A BOOL, `1` or `0`.
fn boolean(token: Token<'_>, field: Field) -> Result<bool, RsiError> {
    match token.bytes.trim_ascii() {
        b"0" => Ok(false),
        b"1" => Ok(true),
        _ => Err(RsiError::BadValue {
            field,
            at: token.at,
        }),
    }
}
