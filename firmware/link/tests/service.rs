//! Frames of the parameter service on a line that loses and changes bytes.
#![allow(clippy::unwrap_used, reason = "that is how a test fails")]

use proptest::prelude::*;
use softdock_link::service::{Frame, FrameError, FrameReader, Kind, PAYLOAD_MAX_BYTES};

/// Payloads of the frames that arrive, and the number of damaged ones.
fn receive(line: &[u8]) -> (Vec<Vec<u8>>, usize) {
    let mut reader = FrameReader::new();
    let (mut good, mut bad) = (Vec::new(), 0);
    for byte in line {
        match reader.push(*byte) {
            Some(Ok(frame)) => good.push(frame.payload.to_vec()),
            Some(Err(_)) => bad += 1,
            None => {}
        }
    }
    (good, bad)
}

fn frame(sequence: u16, payload: &[u8]) -> Vec<u8> {
    let frame = Frame {
        version: 1,
        kind: Kind::Request,
        sequence,
        conversation: 0x0102_0300,
        payload,
    };
    frame.encode().unwrap().to_vec()
}

#[test]
fn a_frame_comes_back_whole() {
    let line = frame(700, &[0, 1, 0, 0, 255]);
    let mut reader = FrameReader::new();
    let (last, rest) = line.split_last().unwrap();
    assert!(rest.iter().all(|byte| reader.push(*byte).is_none()));
    let read = reader.push(*last).unwrap().unwrap();
    assert_eq!((read.version, read.kind), (1, Kind::Request));
    assert_eq!((read.sequence, read.conversation), (700, 0x0102_0300));
    assert_eq!(read.payload, [0, 1, 0, 0, 255]);
}

/// The longest payload fits, one more byte does not: with zeros only, without zeros, and mixed.
#[test]
fn payloads_have_a_largest_size() {
    for filling in [[0, 0], [7, 7], [0, 9]] {
        let payload: Vec<u8> = (0..PAYLOAD_MAX_BYTES).map(|i| filling[i % 2]).collect();
        assert_eq!(receive(&frame(1, &payload)), (vec![payload.clone()], 0));
        let longer = [payload, vec![1]].concat();
        let frame = Frame {
            version: 1,
            kind: Kind::Answer,
            sequence: 0,
            conversation: 0,
            payload: &longer,
        };
        assert_eq!(frame.encode(), Err(FrameError::Length));
    }
}

/// Three frames, with every byte of the middle one flipped in every bit, dropped, or doubled: the other two frames arrive,
/// and the middle one never arrives with another content.
#[test]
fn a_damaged_byte_costs_one_frame_at_most() {
    let payloads = [b"first\0\0".to_vec(), (0..=255).collect(), b"last".to_vec()];
    let lines: Vec<Vec<u8>> = payloads.iter().map(|p| frame(3, p)).collect();
    let check = |middle: &[u8], what: &str| {
        let (good, _) = receive(&[&lines[0], middle, &lines[2]].concat());
        assert_eq!(good.first(), Some(&payloads[0]), "{what}");
        assert_eq!(good.last(), Some(&payloads[2]), "{what}");
        assert!(good.iter().all(|p| payloads.contains(p)), "{what}");
        good.len()
    };
    for at in 0..lines[1].len() {
        let edge = at == 0 || at + 1 == lines[1].len();
        for bit in 0..8 {
            let mut damaged = lines[1].clone();
            damaged[at] ^= 1 << bit;
            let count = check(&damaged, &format!("bit {bit} of byte {at}"));
            assert!(edge || count == 2, "bit {bit} of byte {at} went unnoticed");
        }
        let mut dropped = lines[1].clone();
        dropped.remove(at);
        let count = check(&dropped, &format!("byte {at} dropped"));
        assert!(edge || count == 2, "byte {at} dropped unnoticed");
        let mut doubled = lines[1].clone();
        doubled.insert(at, lines[1][at]);
        check(&doubled, &format!("byte {at} doubled"));
    }
    assert_eq!(check(&lines[1], "undamaged"), 3);
}

/// The reader tells how a line differs from that of the service: a wrong checksum means a noisy line; bytes without an end
/// mean another speed or another program.
#[test]
fn bytes_without_an_end_are_too_long_for_a_frame() {
    let mut reader = FrameReader::new();
    for _ in 0..2 {
        for _ in 0..10_000 {
            assert_eq!(reader.push(7), None);
        }
        assert_eq!(reader.push(0), Some(Err(FrameError::Length)));
    }
}

#[test]
fn an_unknown_kind_is_no_frame() {
    // Kind 1 becomes 9, with a matching checksum, as in a later version of the protocol.
    let mut plain = vec![1, 9, 0, 0, 0, 0, 0, 0];
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&plain);
    plain.extend(crc.to_le_bytes());
    let mut line = vec![0; plain.len() + 2];
    let length = cobs::try_encode(&plain, &mut line).unwrap();
    line.truncate(length);
    line.push(0);
    let mut reader = FrameReader::new();
    let (last, rest) = line.split_last().unwrap();
    assert!(rest.iter().all(|byte| reader.push(*byte).is_none()));
    assert_eq!(reader.push(*last), Some(Err(FrameError::Kind)));
}

proptest! {
    /// Noise of any length, then a frame: the frame arrives, and noise is never taken for one.
    #[test]
    fn a_frame_is_found_behind_noise(noise in prop::collection::vec(any::<u8>(), 0..3000), payload in prop::collection::vec(any::<u8>(), 0..PAYLOAD_MAX_BYTES)) {
        let line = [noise, frame(9, &payload)].concat();
        let (good, _) = receive(&line);
        prop_assert_eq!(good, vec![payload]);
    }

    /// Any payload is received unchanged.
    #[test]
    fn any_payload_comes_back(sequence: u16, payload in prop::collection::vec(any::<u8>(), 0..PAYLOAD_MAX_BYTES)) {
        prop_assert_eq!(receive(&frame(sequence, &payload)), (vec![payload], 0));
    }
}
