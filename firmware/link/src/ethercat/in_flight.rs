//! Frames on their way through the segment; recognises which incoming frames are among them.
//!
//! A frame comes back with the datagrams with which it left; only their data, their working counters and one bit of its sender's
//! address have changed. All other frames are kept from the stack: those of others, damaged ones, repeated ones, and those whose
//! place has been reused in the meantime.

/// EtherType of EtherCAT (IEEE registration).
pub const ETHERTYPE: [u8; 2] = [0x88, 0xA4];

/// Frames that may be on their way.
const FRAMES: usize = 4;
/// Most datagrams of a frame: process data and the state of two SubDevices.
const DATAGRAMS: usize = 3;
/// Length of destination, sender and EtherType.
const ETHERNET_HEADER_BYTES: usize = 14;
/// Length and type.
const ETHERCAT_HEADER_BYTES: usize = 2;
/// Command, index, address, length, interrupt.
const DATAGRAM_HEADER_BYTES: usize = 10;
const WORKING_COUNTER_BYTES: usize = 2;
/// Bits of a datagram's length; the highest bit says that another follows.
const LENGTH: u16 = 0x07FF;
const MORE: u16 = 0x8000;
/// Bit that the first SubDevice sets in the sender's address (ETG.1000.4, 5.3: locally administered).
const PROCESSED: u8 = 0x02;

/// Command "configured address, physical read".
const FPRD: u8 = 4;
/// First address of a SubDevice's memory behind its registers; only mailboxes are read there.
const MEMORY: u16 = 0x1000;
/// Protocol of a mailbox, and service of a CoE message.
const COE: u8 = 3;
const EMERGENCY: u8 = 1;

/// The parts of a datagram that stay unchanged: command, index, length.
type Datagram = (u8, u8, u16);
type Shape = heapless::Vec<Datagram, DATAGRAMS>;

/// The frames on their way.
#[derive(Clone, Debug, Default)]
pub struct InFlight {
    frames: [Option<Shape>; FRAMES],
    next: usize,
}

impl InFlight {
    /// Records a frame that leaves, in place of the oldest.
    pub fn record_sent(&mut self, frame: &[u8]) {
        if let Some(place) = self.frames.get_mut(self.next) {
            *place = shape(frame);
        }
        self.next = (self.next + 1) % FRAMES;
    }

    /// Whether a frame has left earlier and comes back for the first time.
    pub fn returned(&mut self, frame: &[u8]) -> bool {
        if frame.get(6).is_none_or(|first| first & PROCESSED == 0) {
            return false;
        }
        let Some(shape) = shape(frame) else {
            return false;
        };
        let place = self
            .frames
            .iter_mut()
            .find(|sent| **sent == Some(shape.clone()));
        place.is_some_and(|place| place.take().is_some())
    }
}

/// The datagrams of a complete EtherCAT frame; `None` if it is not one.
fn shape(frame: &[u8]) -> Option<Shape> {
    let (ethernet, payload) = frame.split_at_checked(ETHERNET_HEADER_BYTES)?;
    let (header, rest) = payload.split_first_chunk::<ETHERCAT_HEADER_BYTES>()?;
    let length = u16::from_le_bytes(*header) & LENGTH;
    let mut rest = rest.get(..usize::from(length))?;
    let mut shape = Shape::new();
    let mut more = ethernet.ends_with(&ETHERTYPE);
    while more {
        let (header, behind) = rest.split_first_chunk::<DATAGRAM_HEADER_BYTES>()?;
        let [command, index, _, _, a0, a1, l0, l1, ..] = *header;
        let flags = u16::from_le_bytes([l0, l1]);
        let (data, behind) = behind.split_at_checked(usize::from(flags & LENGTH))?;
        if command == FPRD && u16::from_le_bytes([a0, a1]) >= MEMORY && is_emergency(data) {
            return None;
        }
        rest = behind.get(WORKING_COUNTER_BYTES..)?;
        shape.push((command, index, flags & LENGTH)).ok()?;
        more = flags & MORE != 0;
    }
    (!shape.is_empty()).then_some(shape)
}

/// Whether a mailbox holds an emergency message, at which ethercrab 0.7.1 panics (`mailbox/coe/mod.rs`). Without the message the
/// start-up times out and is tried again.
fn is_emergency(mailbox: &[u8]) -> bool {
    match mailbox {
        [_, _, _, _, _, protocol, _, service, ..] => {
            protocol & 0xF == COE && service >> 4 == EMERGENCY
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const FPRD_MAILBOX: [u8; 10] = [FPRD, 9, 1, 0x10, 0x80, 0x10, 8, 0, 0, 0];

    fn frame(sender: u8, datagrams: &[(&[u8; 10], &[u8])]) -> Vec<u8> {
        let mut payload = Vec::new();
        for (header, data) in datagrams {
            payload.extend_from_slice(*header);
            payload.extend_from_slice(data);
            payload.extend_from_slice(&[0, 0]);
        }
        let mut bytes = vec![0xFF; 6];
        bytes.extend_from_slice(&[sender, 0x10, 0x10, 0x10, 0x10, 0x10, 0x88, 0xA4]);
        bytes.extend_from_slice(&(payload.len() as u16 | 0x1000).to_le_bytes());
        bytes.extend(payload);
        bytes.resize(bytes.len().max(60), 0);
        bytes
    }

    fn lrw(index: u8, more: u8) -> [u8; 10] {
        [12, index, 0, 0, 0, 0, 4, more, 0, 0]
    }

    #[test]
    fn a_frame_comes_back_once_with_other_data() {
        let mut wire = InFlight::default();
        let state = [FPRD, 2, 1, 0x10, 0x30, 1, 2, 0, 0, 0];
        wire.record_sent(&frame(0x10, &[(&lrw(1, 0x80), &[0; 4]), (&state, &[0; 2])]));
        let back = frame(0x12, &[(&lrw(1, 0x80), &[7; 4]), (&state, &[8, 0])]);
        let echo = frame(0x10, &[(&lrw(1, 0x80), &[7; 4]), (&state, &[8, 0])]);
        assert!(!wire.returned(&echo), "no SubDevice has seen it");
        assert!(wire.returned(&back));
        assert!(!wire.returned(&back), "it comes twice");
        // A SubDevice may mark a frame that goes round; what tells it is the length beside that mark.
        wire.record_sent(&frame(0x10, &[(&lrw(1, 0), &[0; 4])]));
        assert!(wire.returned(&frame(0x12, &[(&lrw(1, 0x40), &[7; 4])])));
    }

    #[test]
    fn another_frame_is_not_taken_for_it() {
        let mut wire = InFlight::default();
        wire.record_sent(&frame(0x10, &[(&lrw(1, 0), &[0; 4])]));
        let mut wrong_type = frame(0x12, &[(&lrw(1, 0), &[0; 4])]);
        wrong_type[13] = 0;
        let mut cut = frame(0x12, &[(&lrw(1, 0), &[0; 4])]);
        cut.truncate(25);
        let mut longer = lrw(1, 0);
        longer[6] = 5;
        for foreign in [
            wrong_type,
            cut,
            frame(0x12, &[(&lrw(2, 0), &[0; 4])]),
            frame(0x12, &[(&longer, &[0; 5])]),
            frame(0x12, &[]),
        ] {
            assert!(!wire.returned(&foreign), "{foreign:02x?}");
        }
    }

    #[test]
    fn a_frame_whose_place_was_taken_comes_too_late() {
        let mut wire = InFlight::default();
        for index in 0..=FRAMES as u8 {
            wire.record_sent(&frame(0x10, &[(&lrw(index, 0), &[0; 4])]));
        }
        assert!(!wire.returned(&frame(0x12, &[(&lrw(0, 0), &[0; 4])])));
        assert!(wire.returned(&frame(0x12, &[(&lrw(1, 0), &[0; 4])])));
    }

    #[test]
    fn an_emergency_message_is_kept_away() {
        let mut wire = InFlight::default();
        wire.record_sent(&frame(0x10, &[(&FPRD_MAILBOX, &[0; 8])]));
        let mailbox = [10, 0, 0, 0, 0, 0x13, 0, EMERGENCY << 4];
        assert!(!wire.returned(&frame(0x12, &[(&FPRD_MAILBOX, &mailbox)])));
        let answer = [10, 0, 0, 0, 0, 0x13, 0, 3 << 4];
        assert!(wire.returned(&frame(0x12, &[(&FPRD_MAILBOX, &answer)])));
    }

    /// A logical address may be any, and so may the bytes of a force.
    #[test]
    fn process_data_that_look_like_an_emergency_are_process_data() {
        let mut wire = InFlight::default();
        let read = [12, 1, 0, 0, 0x80, 0x10, 8, 0, 0, 0];
        wire.record_sent(&frame(0x10, &[(&read, &[0; 8])]));
        let force = [10, 0, 0, 0, 0, 0x13, 0, EMERGENCY << 4];
        assert!(wire.returned(&frame(0x12, &[(&read, &force)])));
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic(bytes in proptest::collection::vec(any::<u8>(), 0..80)) {
            let mut wire = InFlight::default();
            wire.record_sent(&bytes);
            let _ = wire.returned(&bytes);
        }
    }
}
