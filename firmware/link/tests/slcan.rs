//! The SLCAN adapter from the view of its clients.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a helper of a test fails the test"
)]

use proptest::prelude::*;
use softdock_link::can::{Frame, Id};
use softdock_link::slcan::{Slcan, SlcanError, SlcanEvent, encode_frame_line, parse_frame_line};

/// Sends text to the adapter; returns the replies and the events.
fn send(adapter: &mut Slcan, text: &[u8]) -> (String, Vec<SlcanEvent>) {
    let mut replies = Vec::new();
    let mut events = Vec::new();
    for byte in text {
        events.extend(adapter.push(*byte, &mut |reply: &[u8]| replies.extend_from_slice(reply)));
    }
    (String::from_utf8(replies).unwrap(), events)
}

fn adapter_after(text: &str) -> Slcan {
    let mut adapter = Slcan::new();
    send(&mut adapter, text.as_bytes());
    adapter
}

fn standard(id: u16, data: &[u8]) -> Frame {
    Frame::new(Id::Standard(id), data).unwrap()
}

#[test]
fn opens_as_python_can_does_it() {
    let mut adapter = Slcan::new();
    let (replies, events) = send(&mut adapter, b"C\rS8\r\rO\rO\rt2000\r");
    assert_eq!(replies, "\r\r\r\r\rz\r");
    assert_eq!(
        events,
        [SlcanEvent::Opened, SlcanEvent::Frame(standard(0x200, &[]))]
    );
    assert!(adapter.is_open());
    assert_eq!(
        send(&mut adapter, b"C\r"),
        ("\r".to_owned(), vec![SlcanEvent::Closed])
    );
    assert!(!adapter.is_open());
}

#[test]
fn every_command_has_its_reply() {
    const OK: &str = "\r";
    const BEL: &str = "\x07";
    for (before, command, reply) in [
        ("", "", OK),
        ("", "V", "V1010\r"),
        ("", "N", "N0000\r"),
        ("", "F", BEL),
        ("O\r", "F", "F00\r"),
        ("", "S0", OK),
        ("", "S8", OK),
        ("", "S9", BEL),
        ("", "S", BEL),
        ("", "S88", BEL),
        ("O\r", "S8", BEL),
        ("", "s031C", OK),
        ("", "s031", BEL),
        ("", "s03G1", BEL),
        ("", "M00000000", OK),
        ("", "mFFFFFFFF", OK),
        ("", "m", BEL),
        ("O\r", "M00000000", BEL),
        ("", "Z1", OK),
        ("", "Z2", BEL),
        ("O\r", "Z1", BEL),
        ("", "t2000", BEL),
        ("L\r", "t2000", BEL),
        ("O\r", "t2001", BEL),
        ("O\r", "t20010", BEL),
        ("O\r", "t2002FF0a", "z\r"),
        ("O\r", "t8000", BEL),
        ("O\r", "r2008", "z\r"),
        ("O\r", "T1FFFFFFF0", "Z\r"),
        ("O\r", "T200000000", BEL),
        ("O\r", "R000000001", "Z\r"),
        ("", "o", BEL),
        ("", "OO", BEL),
        ("", "X1", BEL),
        ("", "\u{e9}", BEL),
    ] {
        let mut adapter = adapter_after(before);
        let (replies, _) = send(&mut adapter, format!("{command}\r").as_bytes());
        assert_eq!(replies, reply, "{before:?} {command:?}");
    }
}

#[test]
fn line_feeds_do_not_matter() {
    let (replies, events) = send(&mut Slcan::new(), b"O\r\nt1230\r\n");
    assert_eq!(replies, "\rz\r");
    assert_eq!(events.len(), 2);
}

#[test]
fn listening_only_still_receives() {
    let mut adapter = Slcan::new();
    assert_eq!(send(&mut adapter, b"L\r").1, [SlcanEvent::Opened]);
    assert_eq!(
        adapter.encode(&standard(1, &[]), &mut heapless::Vec::new()),
        Ok(())
    );
}

#[test]
fn the_client_gets_frames_while_the_channel_is_open() {
    let frame = standard(0x200, &[0x40, 0, 0xFF]);
    let mut out = heapless::Vec::from_slice(b"old").unwrap();
    let mut adapter = Slcan::new();
    assert_eq!(adapter.encode(&frame, &mut out), Err(SlcanError::Closed));
    assert_eq!(out, b"");
    send(&mut adapter, b"O\r");
    assert_eq!(adapter.encode(&frame, &mut out), Ok(()));
    assert_eq!(out, b"t20034000FF\r");
}

#[test]
fn time_stamps_come_if_the_client_asks_for_them() {
    let frame = standard(0x200, &[]);
    let mut out = heapless::Vec::new();
    let mut adapter = adapter_after("Z1\rO\r");
    assert_eq!(adapter.encode(&frame, &mut out), Ok(()));
    assert_eq!(out, b"t20000000\r");
    assert_eq!(parse_frame_line(&out), Ok(frame));
    send(&mut adapter, b"C\rZ0\rO\r");
    assert_eq!(adapter.encode(&frame, &mut out), Ok(()));
    assert_eq!(out, b"t2000\r");
}

#[test]
fn an_overlong_line_is_refused_as_a_whole() {
    for len in [33, 64, 10_000] {
        let mut adapter = adapter_after("O\r");
        let line = "t20080011223344556677".to_owned() + &"0".repeat(len) + "\rt2000\r";
        let (replies, events) = send(&mut adapter, line.as_bytes());
        assert_eq!(replies, "\x07z\r");
        assert_eq!(events, [SlcanEvent::Frame(standard(0x200, &[]))]);
    }
    // Exactly as long as the buffer, but still not a frame.
    let (replies, events) = send(
        &mut adapter_after("O\r"),
        &[b"t".repeat(32), b"\r".to_vec()].concat(),
    );
    assert_eq!((replies.as_str(), events.len()), ("\x07", 0));
}

prop_compose! {
    fn frame()(
        standard in 0..=Id::MAX_STANDARD,
        extended in 0..=Id::MAX_EXTENDED,
        is_extended: bool,
        is_remote: bool,
        data in prop::collection::vec(any::<u8>(), 0..=8),
    ) -> Frame {
        let id = if is_extended { Id::Extended(extended) } else { Id::Standard(standard) };
        if is_remote {
            Frame::new_remote(id, data.len()).unwrap()
        } else {
            Frame::new(id, &data).unwrap()
        }
    }
}

proptest! {
    #[test]
    fn frames_pass_in_both_directions(frames in prop::collection::vec(frame(), 0..20)) {
        let mut adapter = adapter_after("O\r");
        for frame in frames {
            let mut line = heapless::Vec::new();
            encode_frame_line(&frame, &mut line);
            let (replies, events) = send(&mut adapter, &line);
            prop_assert!(replies.eq_ignore_ascii_case("z\r"));
            prop_assert_eq!(events, vec![SlcanEvent::Frame(frame)]);
            adapter.encode(&frame, &mut line).unwrap();
            prop_assert_eq!(parse_frame_line(&line), Ok(frame));
        }
    }

    #[test]
    fn any_bytes_are_survived_and_the_next_line_is_understood(
        soup in prop::collection::vec(any::<u8>(), 0..300),
        commands in "[OCLSstTrRFVNZMm0-9A-F\r]{0,200}",
        frame in frame(),
    ) {
        let mut adapter = Slcan::new();
        send(&mut adapter, &soup);
        send(&mut adapter, commands.as_bytes());
        let mut line = heapless::Vec::new();
        encode_frame_line(&frame, &mut line);
        send(&mut adapter, b"\rC\rO\r");
        let (_, events) = send(&mut adapter, &line);
        prop_assert_eq!(events, vec![SlcanEvent::Frame(frame)]);
    }

    #[test]
    fn each_line_gets_exactly_one_reply(lines in prop::collection::vec("[ -~]{0,40}", 0..20)) {
        let mut adapter = Slcan::new();
        for line in lines {
            let (replies, _) = send(&mut adapter, format!("{line}\r").as_bytes());
            let ends = replies.bytes().filter(|byte| matches!(byte, b'\r' | 0x07)).count();
            prop_assert_eq!(ends, 1, "{:?}", line);
        }
    }
}
