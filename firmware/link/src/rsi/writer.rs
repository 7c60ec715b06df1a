//! Formatted text into a byte slice, without allocation.

use core::fmt::{self, Write};

use super::fields::AXES;
use crate::decimal::{Decimal, count_text};

/// Appends text to a byte slice; fails, and leaves the rest as it is, when the slice is full.
pub(super) struct Writer<'a> {
    out: &'a mut [u8],
    len: usize,
}

impl<'a> Writer<'a> {
    pub(super) fn new(out: &'a mut [u8]) -> Self {
        Self { out, len: 0 }
    }

    /// Bytes written so far.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Size of the slice.
    pub(super) fn capacity(&self) -> usize {
        self.out.len()
    }

    /// Appends bytes of ASCII.
    pub(super) fn write_ascii(&mut self, bytes: &[u8]) -> fmt::Result {
        let end = self.len.checked_add(bytes.len()).ok_or(fmt::Error)?;
        self.out
            .get_mut(self.len..end)
            .ok_or(fmt::Error)?
            .copy_from_slice(bytes);
        self.len = end;
        Ok(())
    }

    /// Appends an empty element with the attributes X, Y, Z, A, B, C.
    pub(super) fn write_axes(&mut self, element: &[u8], values: &[Decimal; 6]) -> fmt::Result {
        self.write_ascii(b"<")?;
        self.write_ascii(element)?;
        for (axis, value) in AXES.into_iter().zip(values) {
            self.write_ascii(&[b' ', axis, b'=', b'"'])?;
            self.write_ascii(value.text(&mut [0; Decimal::MAX_TEXT_BYTES]))?;
            self.write_ascii(b"\"")?;
        }
        self.write_ascii(b"/>")
    }

    /// Appends the element of the time stamp.
    pub(super) fn write_ipoc(&mut self, ipoc: u64) -> fmt::Result {
        self.write_ascii(b"<IPOC>")?;
        self.write_ascii(count_text(ipoc, &mut [0; Decimal::MAX_TEXT_BYTES]))?;
        self.write_ascii(b"</IPOC>")
    }

    /// Appends the first `max_chars` characters of `text` as XML character data. What is not printable ASCII, which
    /// no operator panel is known to show, becomes `?`.
    pub(super) fn write_escaped(&mut self, text: &str, max_chars: usize) -> fmt::Result {
        for character in text.chars().take(max_chars) {
            match character {
                '&' => self.write_str("&amp;")?,
                '<' => self.write_str("&lt;")?,
                '>' => self.write_str("&gt;")?,
                '"' => self.write_str("&quot;")?,
                '\'' => self.write_str("&apos;")?,
                ' '..='~' => self.write_char(character)?,
                _ => self.write_char('?')?,
            }
        }
        Ok(())
    }
}

impl Write for Writer<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.write_ascii(text.as_bytes())
    }
}
