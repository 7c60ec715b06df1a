//! A frame as a line: `tiiildd..`, `Tiiiiiiiildd..`, and `r`, `R` without data for remote frames.

use heapless::Vec;

use crate::can::{Frame, Id};

/// Longest line: `T`, 8 digits of identifier, length, 16 digits of data, 4 of time stamp, carriage return (31 bytes),
/// rounded up.
pub const MAX_LINE_BYTES: usize = 32;

/// Ends every line.
pub(super) const CARRIAGE_RETURN: u8 = b'\r';

/// Digits of a time stamp.
pub(super) const TIMESTAMP_DIGITS: usize = 4;

/// Why there is no line for a frame, or no frame in a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SlcanError {
    /// The channel is closed: the client gets no frames.
    #[error("the SLCAN channel is closed")]
    Closed,
    /// Not a frame: wrong command, digit, length or identifier.
    #[error("not an SLCAN frame, expected tiiildd.., Tiiiiiiiildd.., riiil or Riiiiiiiil")]
    Syntax,
}

/// Writes `frame` as a line with its carriage return, replacing what is in `out`.
pub fn encode_frame_line(frame: &Frame, out: &mut Vec<u8, MAX_LINE_BYTES>) {
    encode(frame, None, out);
}

/// [`encode_frame_line`] with the adapter's optional time stamp.
pub(super) fn encode(frame: &Frame, stamp: Option<u16>, out: &mut Vec<u8, MAX_LINE_BYTES>) {
    let (command, id, id_digits) = match (frame.id(), frame.is_remote()) {
        (Id::Standard(id), false) => (b't', u32::from(id), 3),
        (Id::Standard(id), true) => (b'r', u32::from(id), 3),
        (Id::Extended(id), false) => (b'T', id, 8),
        (Id::Extended(id), true) => (b'R', id, 8),
    };
    out.clear();
    let mut line = Line(out);
    line.push(command);
    line.hex(id, id_digits);
    line.hex(frame.dlc() as u32, 1);
    for byte in frame.data() {
        line.hex((*byte).into(), 2);
    }
    if let Some(stamp) = stamp {
        line.hex(stamp.into(), TIMESTAMP_DIGITS);
    }
    line.push(CARRIAGE_RETURN);
}

/// A line that is being written.
struct Line<'a>(&'a mut Vec<u8, MAX_LINE_BYTES>);

impl Line<'_> {
    /// Cannot fail within one frame, see [`MAX_LINE_BYTES`].
    fn push(&mut self, byte: u8) {
        let _ = self.0.push(byte);
    }

    /// The lowest `digits` hexadecimal digits, the highest first.
    fn hex(&mut self, value: u32, digits: usize) {
        for digit in (0..digits).rev() {
            let nibble = (value >> (4 * digit) & 0xF) as u8;
            self.push(match nibble {
                0..=9 => b'0' + nibble,
                _ => b'A' + (nibble - 10),
            });
        }
    }
}

/// Reads a line, with or without its carriage return and a time stamp. For the client's side: what an adapter hands
/// over from the bus.
///
/// # Errors
/// [`SlcanError::Syntax`].
pub fn parse_frame_line(line: &[u8]) -> Result<Frame, SlcanError> {
    let line = line.strip_suffix(&[CARRIAGE_RETURN]).unwrap_or(line);
    parse(line).or_else(|error| {
        // An exact frame is tried first: a time stamp is only what is left over.
        let stamp_at = line.len().checked_sub(TIMESTAMP_DIGITS).ok_or(error)?;
        let (frame, stamp) = line.split_at_checked(stamp_at).ok_or(error)?;
        hex(stamp).and(parse(frame).ok()).ok_or(error)
    })
}

/// Reads a line without a carriage return and a time stamp.
pub(super) fn parse(line: &[u8]) -> Result<Frame, SlcanError> {
    frame(line).ok_or(SlcanError::Syntax)
}

fn frame(line: &[u8]) -> Option<Frame> {
    let (command, rest) = line.split_first()?;
    let extended = command.is_ascii_uppercase();
    let (id, rest) = rest.split_at_checked(if extended { 8 } else { 3 })?;
    let id = hex(id)?;
    let id = if extended {
        Id::Extended(id)
    } else {
        Id::Standard(u16::try_from(id).ok()?)
    };
    let (dlc, digits) = rest.split_first()?;
    let dlc = usize::from(dlc.checked_sub(b'0')?);
    match command {
        b't' | b'T' => {
            let mut data: Vec<u8, { Frame::MAX_BYTES }> = Vec::new();
            for pair in digits.chunks(2) {
                let byte = u8::try_from(hex(pair)?).ok()?;
                data.push(byte).ok()?;
            }
            let exact = digits.len() == 2 * dlc && data.len() == dlc;
            Frame::new(id, &data).ok().filter(|_| exact)
        }
        b'r' | b'R' if digits.is_empty() => Frame::new_remote(id, dlc).ok(),
        _ => None,
    }
}

/// Hexadecimal digits of either case; of more than eight, the last eight.
pub(super) fn hex(digits: &[u8]) -> Option<u32> {
    digits.iter().try_fold(0, |value, digit| {
        let digit = char::from(*digit).to_digit(16)?;
        Some(value << 4 | digit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn standard(id: u16, data: &[u8]) -> Frame {
        Frame::new(Id::Standard(id), data).unwrap()
    }

    #[test]
    fn known_lines() {
        let extended = |id, data| Frame::new(Id::Extended(id), data).unwrap();
        for (line, frame) in [
            ("t2000\r", standard(0x200, &[])),
            ("t7FF2A0FF\r", standard(0x7FF, &[0xA0, 0xFF])),
            (
                "T1FFFFFFF80011223344556677\r",
                extended(0x1FFF_FFFF, &[0, 0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77]),
            ),
            (
                "r1238\r",
                Frame::new_remote(Id::Standard(0x123), 8).unwrap(),
            ),
            (
                "R000001230\r",
                Frame::new_remote(Id::Extended(0x123), 0).unwrap(),
            ),
        ] {
            let mut out = Vec::new();
            encode_frame_line(&frame, &mut out);
            assert_eq!(out, line.as_bytes());
            assert_eq!(parse_frame_line(line.as_bytes()), Ok(frame));
            assert_eq!(
                parse_frame_line(line.to_ascii_lowercase().as_bytes()).is_ok(),
                line.starts_with(['t', 'r'])
            );
        }
    }

    #[test]
    fn time_stamps_are_dropped() {
        assert_eq!(
            parse_frame_line(b"t20010AEA5F\r"),
            Ok(standard(0x200, &[0x0A]))
        );
        let mut out = Vec::new();
        let longest = Frame::new(Id::Extended(1), &[0; 8]).unwrap();
        encode(&longest, Some(59_999), &mut out);
        assert_eq!(out, b"T0000000180000000000000000EA5F\r");
        assert_eq!(parse_frame_line(&out), Ok(longest));
    }

    #[test]
    fn anything_else_is_refused() {
        for line in [
            "",
            "\r",
            "t",
            "t200",
            "t2001",
            "t20010",
            "t2000A",
            "t8000",
            "t2009",
            "tG000",
            "t200:",
            "x2000",
            "T200000000",
            "T0000000",
            "r20010A",
            "t2 00",
            "t+000",
            "t20010A5",
            "t200/",
            "t2008001122334455667788",
        ] {
            assert_eq!(
                parse_frame_line(line.as_bytes()),
                Err(SlcanError::Syntax),
                "{line}"
            );
        }
    }

    proptest! {
        #[test]
        fn frames_round_trip(
            standard in 0_u16..=Id::MAX_STANDARD,
            extended in 0..=Id::MAX_EXTENDED,
            is_extended: bool,
            is_remote: bool,
            data in proptest::collection::vec(any::<u8>(), 0..=8),
            stamp in proptest::option::of(0_u16..60_000),
        ) {
            let id = if is_extended { Id::Extended(extended) } else { Id::Standard(standard) };
            let frame = if is_remote {
                Frame::new_remote(id, data.len()).unwrap()
            } else {
                Frame::new(id, &data).unwrap()
            };
            let mut line = Vec::new();
            encode(&frame, stamp, &mut line);
            prop_assert_eq!(parse_frame_line(&line), Ok(frame));
        }

        #[test]
        fn byte_soup_never_panics(line in proptest::collection::vec(any::<u8>(), 0..40)) {
            let _ = parse_frame_line(&line);
        }
    }
}
