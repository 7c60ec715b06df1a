//! The client's side of SLCAN: frames out of what an adapter sends, and frames for it.

use softdock_link::can::Frame;
use softdock_link::slcan::{AdapterEvent, AdapterLines, MAX_LINE_BYTES, encode_frame_line};
use std::io::{Result, Write};

/// The frames that these bytes complete; anything else is skipped.
pub fn frames<'a>(lines: &'a mut AdapterLines, bytes: &'a [u8]) -> impl Iterator<Item = Frame> {
    let events = bytes.iter().filter_map(|byte| lines.push(*byte));
    events.filter_map(|event| match event {
        AdapterEvent::Frame(frame) => Some(frame),
        _ => None,
    })
}

/// Puts frames on the bus, in one piece.
///
/// # Errors
/// The adapter has gone.
pub fn send(stream: &mut impl Write, frames: impl IntoIterator<Item = Frame>) -> Result<()> {
    let mut text = Vec::new();
    for frame in frames {
        let mut line = heapless::Vec::<u8, MAX_LINE_BYTES>::new();
        encode_frame_line(&frame, &mut line);
        text.extend_from_slice(&line);
    }
    stream.write_all(&text)
}
