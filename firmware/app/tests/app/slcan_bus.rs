//! The CAN bus behind a serial line: frames stay complete, whatever arrives on the line and whenever a wait is cancelled.

use embassy_futures::poll_once;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::pipe::Pipe;
use softdock_app::board::{IoError, SensorBus};
use softdock_app::slcan_bus::SlcanBus;
use softdock_link::can::{Frame, Id};
use std::task::Poll;

/// One direction of a line, with room for `BYTES`.
type Line<const BYTES: usize> = Pipe<NoopRawMutex, BYTES>;

fn frame(id: u16) -> Frame {
    Frame::new(Id::Standard(id), &[1, 2]).unwrap()
}

fn text<const BYTES: usize>(line: &Line<BYTES>) -> String {
    let mut bytes = [0; 1024];
    let mut all = Vec::new();
    while let Ok(length) = line.try_read(&mut bytes) {
        all.extend_from_slice(&bytes[..length]);
    }
    String::from_utf8(all).unwrap()
}

fn say<const BYTES: usize>(line: &Line<BYTES>, text: &str) {
    assert_eq!(line.try_write(text.as_bytes()), Ok(text.len()));
}

#[test]
fn frames_pass_both_ways_and_commands_are_answered() {
    let (input, output) = (Line::<256>::new(), Line::<256>::new());
    let mut bus = SlcanBus::new(&input, &output);
    say(&input, "C\rS8\rO\rt12320102\rt12420102\r");
    assert_eq!(poll_once(bus.receive()), Poll::Ready(Ok(frame(0x123))));
    assert_eq!(poll_once(bus.receive()), Poll::Ready(Ok(frame(0x124))));
    assert_eq!(poll_once(bus.send(&frame(0x200))), Poll::Ready(Ok(())));
    assert!(poll_once(bus.receive()).is_pending());
    assert_eq!(text(&output), "\r\r\rz\rz\rt20020102\r");
}

#[test]
fn a_frame_in_pieces_is_one_frame_although_every_wait_is_given_up() {
    let (input, output) = (Line::<64>::new(), Line::<64>::new());
    let mut bus = SlcanBus::new(&input, &output);
    say(&input, "O\r");
    let pieces = "t12320102\r".split_inclusive(|_| true);
    let mut received = Vec::new();
    for piece in pieces {
        assert!(poll_once(bus.receive()).is_pending());
        say(&input, piece);
        if let Poll::Ready(outcome) = poll_once(bus.receive()) {
            received.push(outcome);
        }
    }
    assert_eq!(received, [Ok(frame(0x123))]);
}

#[test]
fn noise_ends_with_its_line() {
    let (input, output) = (Line::<256>::new(), Line::<256>::new());
    let mut bus = SlcanBus::new(&input, &output);
    say(
        &input,
        "O\r#!garbage that is longer than any line\rt1#\rt12320102\r",
    );
    assert_eq!(poll_once(bus.receive()), Poll::Ready(Ok(frame(0x123))));
}

#[test]
fn nobody_on_the_bus_holds_nobody_up() {
    let (input, output) = (Line::<8>::new(), Line::<8>::new());
    let mut bus = SlcanBus::new(&input, &output);
    for _ in 0..100 {
        assert_eq!(poll_once(bus.send(&frame(0x200))), Poll::Ready(Ok(())));
    }
    assert_eq!(text(&output), "");
}

#[test]
fn a_client_that_does_not_read_gets_whole_frames_when_it_reads_again() {
    let (input, output) = (Line::<64>::new(), Line::<4>::new());
    let mut bus = SlcanBus::new(&input, &output);
    say(&input, "O\r");
    assert!(poll_once(bus.receive()).is_pending());
    let sent: Vec<u16> = (0x100..0x200)
        .filter(|id| poll_once(bus.send(&frame(*id))).is_ready())
        .collect();
    assert!((20..40).contains(&sent.len()), "{} frames", sent.len());
    // Output that the client does not read must not block incoming frames.
    say(&input, "t12320102\r");
    assert_eq!(poll_once(bus.receive()), Poll::Ready(Ok(frame(0x123))));

    let mut seen = String::new();
    while let more @ 1.. = output.len() {
        seen += &text(&output);
        assert!(more <= 4);
        assert!(poll_once(bus.receive()).is_pending());
    }
    let mut lines: Vec<String> = sent.iter().map(|id| format!("t{id:X}20102")).collect();
    lines.insert(0, String::new());
    assert_eq!(seen.replace("z\r", ""), lines.join("\r") + "\r");
}

#[test]
fn a_line_that_ends_closes_the_bus() {
    let output = Line::<64>::new();
    let mut bus = SlcanBus::new(&b"O\r"[..], &output);
    assert_eq!(poll_once(bus.receive()), Poll::Ready(Err(IoError::Closed)));
}
