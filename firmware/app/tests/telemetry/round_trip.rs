//! Written data are read back bit for bit.

use proptest::prelude::*;
use softdock_app::image::{IMAGE_MAX_BYTES, Image};
use softdock_app::record::CycleRecord;
use softdock_app::settings::BoardSettings;
use softdock_app::telemetry::{
    Announcement, DATAGRAM_MAX_BYTES, Datagram, Kind, MESSAGE_MAX_BYTES, MessageError, MessagePart,
    PAYLOAD_MAX_BYTES, Stream, read_record, schema,
};
use softdock_control::io::Sequence;
use softdock_control::limits::LimitFlags;
use softdock_control::modes::{Command, Fault, FaultCode, Mode, Refusal};

/// All datagrams of a message, as bytes.
fn datagrams<'a>(parts: impl Iterator<Item = MessagePart<'a>>) -> Vec<Datagram> {
    parts
        .map(|part| {
            let mut datagram = Datagram::new();
            part.write(&mut datagram);
            datagram
        })
        .collect()
}

/// The message that the datagrams contain.
fn message(datagrams: &[Datagram]) -> Vec<u8> {
    let parts = datagrams
        .iter()
        .map(|bytes| MessagePart::read(bytes).unwrap());
    parts.flat_map(|part| part.payload.to_vec()).collect()
}

/// Any record, with any bit pattern as each number.
fn any_record() -> impl Strategy<Value = CycleRecord> {
    let reals = prop::collection::vec(any::<u64>().prop_map(f64::from_bits), 32);
    (
        reals,
        any::<[i64; 6]>(),
        any::<[u64; 2]>(),
        any::<u32>(),
        any::<bool>(),
    )
        .prop_map(|(reals, counts, [cycle, ipoc], word, there)| {
            let mut record = CycleRecord::default();
            record.inputs.robot.counter = ipoc;
            record.inputs.robot.sequence = Sequence::Gap(word);
            record.inputs.robot.pose = there.then(|| core::array::from_fn(|i| reals[i]));
            record.inputs.robot.late_answers = word;
            record.inputs.sensor.wrench = core::array::from_fn(|i| reals[6 + i]);
            record.inputs.sensor.counts = counts.map(|count| count as i32);
            record.inputs.command = there.then_some(Command::Zero);
            record.output.correction = counts;
            record.output.stop = there;
            record.trace.cycle = cycle;
            record.trace.time_s = reals[12];
            record.trace.mode = Mode::Fault;
            let fault = || Fault::new(FaultCode::PoseLost, reals[13], reals[14]);
            record.trace.fault = there.then(fault);
            record.trace.refusal = there.then_some(Refusal::OrientationSingular);
            record.trace.limits = LimitFlags(word as u16);
            record.trace.body_k.pose = core::array::from_fn(|i| reals[15 + i]);
            record.trace.law_parts[6] = core::array::from_fn(|i| reals[22 + i]);
            record
        })
}

proptest! {
    #[test]
    fn a_record_comes_back_bit_for_bit(record in any_record(), boot: u32, lost: u32) {
        let mut stream = Stream::new(boot);
        stream.set_lost(lost);
        let sent = datagrams(stream.record(&record).unwrap());
        let first = MessagePart::read(&sent[0]).unwrap();
        prop_assert_eq!((first.kind, first.part, first.sequence), (Kind::Record, 0, 0));
        prop_assert_eq!((first.boot, first.schema, first.lost), (boot, schema(), lost));
        let received = read_record(&message(&sent)).unwrap();
        // NaN is not equal to itself, but its text is.
        prop_assert_eq!(format!("{received:?}"), format!("{record:?}"));
        let mut again = Stream::new(boot);
        again.set_lost(lost);
        prop_assert_eq!(datagrams(again.record(&received).unwrap()), sent);
    }

    #[test]
    fn a_part_comes_back(
        numbers: [u32; 4],
        parts in 1..=u8::MAX,
        part: prop::sample::Index,
        record: bool,
        payload in prop::collection::vec(any::<u8>(), 0..=PAYLOAD_MAX_BYTES),
    ) {
        let [boot, sequence, schema, lost] = numbers;
        let part = MessagePart {
            kind: if record { Kind::Record } else { Kind::Announcement },
            part: part.index(usize::from(parts)) as u8,
            parts,
            boot,
            sequence,
            schema,
            lost,
            payload: &payload,
        };
        let mut bytes = Datagram::new();
        part.write(&mut bytes);
        prop_assert!(bytes.len() <= DATAGRAM_MAX_BYTES);
        prop_assert_eq!(MessagePart::read(&bytes), Ok(part));
    }
}

#[test]
fn a_part_without_payload_comes_back() {
    let part = MessagePart {
        kind: Kind::Machine,
        part: 0,
        parts: 1,
        boot: 1,
        sequence: 2,
        schema: 3,
        lost: 4,
        payload: &[],
    };
    let mut bytes = Datagram::new();
    part.write(&mut bytes);
    assert_eq!(MessagePart::read(&bytes), Ok(part));
}

#[test]
fn a_long_message_is_split_into_full_datagrams_with_consecutive_numbers() {
    let image: Vec<u8> = (0..4000).map(|i| (i % 251) as u8).collect();
    let announcement = Announcement {
        image: &image,
        identity: "softdock 0.1.0",
    };
    let mut stream = Stream::new(1);
    for round in 0..3_u32 {
        let sent = datagrams(stream.announcement(&announcement).unwrap());
        let lengths: Vec<usize> = sent.iter().map(|datagram| datagram.len()).collect();
        assert_eq!(lengths[..2], [DATAGRAM_MAX_BYTES; 2]);
        assert_eq!(lengths.len(), 3);
        for (i, bytes) in (0..).zip(&sent) {
            let part = MessagePart::read(bytes).unwrap();
            assert_eq!((part.part, part.parts), (i, 3));
            assert_eq!(part.sequence, round * 3 + u32::from(i));
        }
        let message = message(&sent);
        assert_eq!(Announcement::read(&message), Ok(announcement));
    }
}

#[test]
fn settings_come_back_from_an_announcement() {
    let image = Image {
        sequence: 3,
        settings: BoardSettings::default(),
    };
    let mut block = [0; IMAGE_MAX_BYTES];
    let length = image.encode(&mut block).unwrap();
    let announcement = Announcement {
        image: &block[..length],
        identity: "softdock 0.1.0 (test)",
    };
    let message = message(&datagrams(
        Stream::new(1).announcement(&announcement).unwrap(),
    ));
    let received = Announcement::read(&message).unwrap();
    assert_eq!(received.identity, announcement.identity);
    assert_eq!(Image::decode(received.image), Ok(image));
}

#[test]
fn a_message_that_is_too_long_is_refused_and_takes_no_number() {
    let mut stream = Stream::new(1);
    let announcement = Announcement {
        image: &[0; MESSAGE_MAX_BYTES],
        identity: "",
    };
    let refused = stream.announcement(&announcement).map(Iterator::count);
    assert_eq!(refused, Err(MessageError::TooLong));
    let sent = datagrams(stream.record(&CycleRecord::default()).unwrap());
    assert_eq!(MessagePart::read(&sent[0]).unwrap().sequence, 0);
}

/// The whole settings of the longest image and a long identity can be announced.
#[test]
fn the_longest_announcement_fits() {
    let identity = "i".repeat(MESSAGE_MAX_BYTES - IMAGE_MAX_BYTES - 4);
    let announcement = Announcement {
        image: &[0; IMAGE_MAX_BYTES],
        identity: &identity,
    };
    assert!(Stream::new(1).announcement(&announcement).is_ok());
}
