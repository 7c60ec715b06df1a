//! The client's side: commands that open an adapter's channel, and its bytes into frames.

use heapless::Vec;

use super::line::{CARRIAGE_RETURN, MAX_LINE_BYTES, parse_frame_line};
use crate::can::Frame;

/// Refused, without a carriage return.
const BEL: u8 = 0x07;

/// Opens the channel of an adapter in whatever state it was left: ends a line that was begun, closes the channel (which
/// is refused where none is open), sets 1 Mbit/s, the bit rate of all sensors here, and opens it.
pub const OPENING: [&[u8]; 4] = [b"\r\r\r", b"C\r", b"S8\r", b"O\r"];
/// Closes it.
pub const CLOSING: &[u8] = b"C\r";

/// Output of the adapter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdapterEvent {
    /// A frame of the bus.
    Frame(Frame),
    /// A command was carried out. Not every adapter says so.
    Done,
    /// A command was refused.
    Refused,
    /// Neither: noise, an incomplete line, or an extension of the adapter.
    NotUnderstood,
}

/// Reads an adapter's lines.
#[derive(Clone, Debug, Default)]
pub struct AdapterLines {
    line: Vec<u8, MAX_LINE_BYTES>,
}

impl AdapterLines {
    /// Takes a byte from the adapter.
    ///
    /// Every line is complete in itself, so after any garbage the next end of a line brings both sides back in step.
    pub fn push(&mut self, byte: u8) -> Option<AdapterEvent> {
        match byte {
            b'\n' => return None,
            CARRIAGE_RETURN | BEL => {}
            _ => {
                // A line that does not fit is cut, and no frame is as long as what is left.
                let _ = self.line.push(byte);
                return None;
            }
        }
        let line = core::mem::take(&mut self.line);
        Some(match line.as_slice() {
            _ if byte == BEL => AdapterEvent::Refused,
            // Nothing, or that a standard or extended frame was put on the bus.
            [] | b"z" | b"Z" => AdapterEvent::Done,
            line => parse_frame_line(line).map_or(AdapterEvent::NotUnderstood, AdapterEvent::Frame),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Slcan, SlcanEvent, encode_frame_line};
    use super::*;
    use crate::can::Id;
    use proptest::prelude::*;

    fn events(bytes: &[u8]) -> std::vec::Vec<AdapterEvent> {
        let mut lines = AdapterLines::default();
        bytes.iter().filter_map(|byte| lines.push(*byte)).collect()
    }

    #[test]
    fn an_adapters_words() {
        let frame = Frame::new(Id::Standard(0x200), &[0x0A]).unwrap();
        let words = b"\r\x07z\rZ\rt20010AEA5F\r\nt20010A\rV1013\r";
        assert_eq!(
            events(words),
            [
                AdapterEvent::Done,
                AdapterEvent::Refused,
                AdapterEvent::Done,
                AdapterEvent::Done,
                AdapterEvent::Frame(frame),
                AdapterEvent::Frame(frame),
                AdapterEvent::NotUnderstood,
            ]
        );
    }

    /// Left open or closed, in the middle of a line: the opening ends with a channel that takes frames.
    #[test]
    fn the_opening_opens_an_adapter_in_any_state() {
        for before in ["", "O\r", "t20", "S8\rO\rt2008"] {
            let mut adapter = Slcan::new();
            let mut replies = std::vec::Vec::new();
            let mut opened = false;
            for byte in before.bytes().chain(OPENING.concat()) {
                let event = adapter.push(byte, &mut |reply| replies.extend_from_slice(reply));
                opened |= event == Some(SlcanEvent::Opened);
            }
            assert!(opened && adapter.is_open(), "{before:?}: {replies:?}");
            assert_eq!(events(&replies).last(), Some(&AdapterEvent::Done));
        }
    }

    /// Two lines without the end in between: the beginning of the first would be a frame.
    #[test]
    fn a_line_longer_than_any_frame_is_none() {
        let frame = Frame::new(Id::Extended(1), &[0; 8]).unwrap();
        let mut line = Vec::new();
        encode_frame_line(&frame, &mut line);
        let digits = line.strip_suffix(b"\r").unwrap();
        let without_an_end = [digits, &line].concat();
        assert_eq!(events(&without_an_end), [AdapterEvent::NotUnderstood]);
    }

    proptest! {
        #[test]
        fn a_frame_comes_through_behind_any_garbage(
            garbage in proptest::collection::vec(any::<u8>(), 0..100),
            data in proptest::collection::vec(any::<u8>(), 0..=8),
        ) {
            let frame = Frame::new(Id::Standard(0x123), &data).unwrap();
            let mut line = Vec::new();
            encode_frame_line(&frame, &mut line);
            let events = events(&[&garbage, &b"\r"[..], &line].concat());
            prop_assert_eq!(events.last(), Some(&AdapterEvent::Frame(frame)));
        }
    }
}
