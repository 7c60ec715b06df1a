//! Parsers of the data that a board receives.

use softdock_app::image::Image;
use softdock_app::telemetry::{Announcement, MessagePart, read_machine, read_record};
use softdock_link::can::ati::{AtiConfig, AtiDriver};
use softdock_link::can::sri::{SriConfig, SriDriver};
use softdock_link::can::{CanSensor, Frame, Id};
use softdock_link::ethercat::{
    ATI_VENDOR, AtiSubDevice, Control, EtherCatConfig, Exchange, INPUT_BYTES, InFlight, Inputs,
    Product, Setup,
};
use softdock_link::rsi::{Tags, parse_rob, parse_sen, salvage_ipoc, write_rob};
use softdock_link::sensor::{SensorDriver, SensorReading};
use softdock_link::slcan::{Slcan, encode_frame_line, parse_frame_line};

/// A telegram that can be parsed can be written and parsed again; its counter is never read as another one.
pub(super) fn rsi(input: &[u8]) {
    let tags = Tags::default();
    if let Ok(telegram) = parse_rob(input, &tags) {
        let mut bytes = [0; 1024];
        if let Ok(length) = write_rob(&telegram, 6, &tags, &mut bytes) {
            let again = parse_rob(&bytes[..length], &tags).expect("what was written can be read");
            assert_eq!(again.ipoc, telegram.ipoc);
            assert_eq!(salvage_ipoc(&bytes[..length]), Some(telegram.ipoc));
        }
        // None where a comment or a declaration looks like a second counter.
        let salvaged = salvage_ipoc(input);
        assert!(salvaged.is_none_or(|counter| counter == telegram.ipoc));
    }
    let _ = parse_sen(input, &tags);
}

/// A frame that was written can be read as the same frame.
pub(super) fn slcan(input: &[u8]) {
    let mut adapter = Slcan::new();
    for byte in input {
        let _ = adapter.push(*byte, &mut |_| {});
    }
    for line in input.split(|byte| *byte == b'\r') {
        if let Ok(frame) = parse_frame_line(line) {
            let mut text = heapless::Vec::new();
            encode_frame_line(&frame, &mut text);
            let text = text.strip_suffix(b"\r").unwrap_or(&text);
            assert_eq!(parse_frame_line(text), Ok(frame));
        }
    }
}

/// Frames of CAN sensors, in any order.
pub(super) fn can_sensor(input: &[u8]) {
    let mut ati = CanSensor::Ati(AtiDriver::new(AtiConfig::default()));
    let mut sri = CanSensor::Sri(SriDriver::new(SriConfig::default()));
    for (n, bytes) in input.chunks(10).enumerate() {
        let [high, low, data @ ..] = bytes else {
            return;
        };
        let id = Id::Standard(u16::from_be_bytes([*high, *low]) & Id::MAX_STANDARD);
        let Ok(frame) = Frame::new(id, data) else {
            return;
        };
        take(&mut ati, &frame, n);
        take(&mut sri, &frame, n);
    }
}

/// Process data, the description of a SubDevice, and frames on the segment.
pub(super) fn ethercat_sensor(input: &[u8]) {
    let mut driver = AtiSubDevice::new(EtherCatConfig {
        poll_period_us: 1_000,
        answer_timeout_us: 1_000,
        control: Control::default(),
    });
    let mut in_flight = InFlight::default();
    for (n, bytes) in input.chunks(INPUT_BYTES + 3).enumerate() {
        let [kind, counter, operational, data @ ..] = bytes else {
            return;
        };
        let mut inputs = [0; INPUT_BYTES];
        inputs
            .iter_mut()
            .zip(data)
            .for_each(|(to, from)| *to = *from);
        assert_eq!(Inputs::decode(&inputs).encode(), inputs);
        let word = |at: usize| {
            i32::from_le_bytes([inputs[at], inputs[at + 1], inputs[at + 2], inputs[at + 3]])
        };
        let exchange = match kind % 4 {
            0 => Exchange::Ready(Setup {
                vendor: ATI_VENDOR,
                product: word(0) as u32,
                force_unit: inputs[4],
                torque_unit: inputs[5],
                counts_per_force: word(8),
                counts_per_torque: word(12),
            }),
            1 => Exchange::Ready(Setup {
                vendor: ATI_VENDOR,
                product: Product::Axia80.code(),
                force_unit: 2,
                torque_unit: 3,
                counts_per_force: 1_000_000,
                counts_per_torque: 1_000_000,
            }),
            _ => Exchange::Inputs {
                working_counter: u16::from(*counter),
                operational: *operational != 0,
                bytes: inputs,
            },
        };
        take(&mut driver, &exchange, n);
        in_flight.record_sent(bytes);
        let _ = in_flight.returned(data);
    }
}

/// Checks that an accepted reading is finite.
fn take<D: SensorDriver>(driver: &mut D, frame: &D::Frame, n: usize) {
    let now_us = n as u64 * 1_000;
    for _ in 0..4 {
        let _ = driver.poll_transmit(now_us);
    }
    let reading = driver.receive(frame, now_us + 300);
    if let Some(SensorReading { wrench, .. }) = reading {
        assert!(wrench.iter().all(|part| part.is_finite()), "{wrench:?}");
    }
}

/// Settings that can be decoded are valid, and are the same after encoding and decoding.
pub(super) fn image(input: &[u8]) {
    if let Ok(image) = Image::decode(input) {
        image
            .settings
            .validate()
            .expect("settings that may be used");
        let mut block = [0; softdock_app::image::IMAGE_MAX_BYTES];
        let length = image.encode(&mut block).expect("there is room");
        assert_eq!(Image::decode(&block[..length]), Ok(image));
    }
}

pub(super) fn telemetry(input: &[u8]) {
    let payload = match MessagePart::read(input) {
        Ok(part) => part.payload,
        Err(_) => input,
    };
    let _ = Announcement::read(payload);
    let _ = read_record(payload);
    let _ = read_machine(payload);
}
