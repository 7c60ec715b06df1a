//! The SRI driver and its stream.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a helper of a test fails the test"
)]

use proptest::prelude::*;
use softdock_link::can::sri::{SriConfig, SriDriver, is_start_command, stream_frames};
use softdock_link::can::{Frame, Id};
use softdock_link::sensor::{SensorReading, SensorState};

const WRENCH: [f32; 6] = [1.5, -2.0, 300.0, 0.25, -0.5, 4.0];

fn wide(wrench: [f32; 6]) -> [f64; 6] {
    wrench.map(f64::from)
}

/// Delivers frames 100 µs apart and returns the reading that the last one completes.
fn deliver(driver: &mut SriDriver, frames: &[Frame], now_us: u64) -> Option<SensorReading> {
    let times = (now_us..).step_by(100);
    frames
        .iter()
        .zip(times)
        .map(|(frame, now_us)| driver.receive(frame, now_us))
        .last()
        .flatten()
}

fn running() -> SriDriver {
    let mut driver = SriDriver::new(SriConfig::default());
    driver.poll_transmit(0);
    let frames = stream_frames(WRENCH).unwrap();
    assert!(deliver(&mut driver, &frames, 1_000).is_some());
    driver
}

#[test]
fn starts_the_stream_and_reads_it() {
    let mut driver = SriDriver::new(SriConfig::default());
    let start = driver.poll_transmit(5).unwrap();
    assert_eq!(start, Frame::new(Id::Standard(0x80), &[0x02]).unwrap());
    assert!(is_start_command(&start));
    let stop = Frame::new(Id::Standard(0x80), &[0x01]).unwrap();
    let other = Frame::new(Id::Standard(0x81), &[0x02]).unwrap();
    assert!(!is_start_command(&stop) && !is_start_command(&other));
    assert_eq!(driver.poll_transmit(5), None);
    assert_eq!(driver.state(), SensorState::Starting);

    let frames = stream_frames(WRENCH).unwrap();
    assert_eq!(frames[0].id(), Id::Standard(0x291));
    assert_eq!(frames[0].data(), [0, 0, 0xC0, 0x3F, 0, 0, 0, 0xC0]);
    let reading = deliver(&mut driver, &frames, 1_000).unwrap();
    assert_eq!(reading.wrench, wide(WRENCH));
    assert!(!reading.saturated);
    assert_eq!((reading.counter, reading.at_us), (1, 1_000));
    assert_eq!((reading.counts, reading.status), ([0; 6], 0));
    assert_eq!(driver.state(), SensorState::Running);
    assert_eq!(driver.counters(), Default::default());
}

#[test]
fn the_start_command_is_repeated_while_nothing_comes() {
    let mut driver = running();
    let deadline_us = driver.next_deadline_us();
    assert_eq!(deadline_us, 1_200 + 100_000);
    assert_eq!(driver.poll_transmit(deadline_us - 1), None);
    for repeat in 0..3 {
        let now_us = deadline_us + repeat * 100_000;
        assert!(is_start_command(&driver.poll_transmit(now_us).unwrap()));
        assert_eq!(driver.state(), SensorState::Resynchronising);
    }
    let counters = driver.counters();
    assert_eq!((counters.timeouts, counters.retries), (3, 3));
    driver.restart();
    assert_eq!(driver.state(), SensorState::Starting);
    assert!(driver.poll_transmit(deadline_us + 200_001).is_some());
}

#[test]
fn frames_out_of_order_make_no_reading() {
    let [a, b, c] = stream_frames(WRENCH).unwrap();
    for (frames, unpaired) in [
        (vec![a, c], 2),
        (vec![b, c], 2),
        (vec![a, b, a], 1),
        (vec![a, b, b, c], 3),
        (vec![b, a, c, b, c], 5),
    ] {
        let mut driver = running();
        assert_eq!(deliver(&mut driver, &frames, 2_000), None);
        assert_eq!(driver.counters().unpaired, unpaired, "{frames:?}");
        assert!(deliver(&mut driver, &[a, b, c], 3_000).is_some());
    }
}

#[test]
fn parts_of_two_readings_are_not_mixed() {
    let [a, b, _] = stream_frames([1.0; 6]).unwrap();
    let [_, _, c] = stream_frames([2.0; 6]).unwrap();
    let mut driver = running();
    driver.receive(&a, 2_000);
    driver.receive(&b, 2_100);
    assert_eq!(driver.receive(&c, 3_200), None);
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..6 {
            let mut wrench = WRENCH;
            wrench[axis] = bad;
            let mut driver = running();
            let frames = stream_frames(wrench).unwrap();
            assert_eq!(deliver(&mut driver, &frames, 2_000), None);
            assert_eq!(driver.counters().invalid, 1);
        }
    }
}

#[test]
fn an_axis_at_its_range_invalidates_all() {
    let mut driver = SriDriver::new(SriConfig {
        saturation: [1e6, 1e6, 300.0, 1e6, 1e6, 1e6],
        ..SriConfig::default()
    });
    for (force_z, saturated) in [(299.0, false), (300.0, true), (-300.0, true)] {
        let mut wrench = WRENCH;
        wrench[2] = force_z;
        let frames = stream_frames(wrench).unwrap();
        let reading = deliver(&mut driver, &frames, 1_000).unwrap();
        assert_eq!(reading.saturated, saturated);
    }
}

#[test]
fn other_frames_are_counted_and_change_nothing() {
    let [a, b, c] = stream_frames(WRENCH).unwrap();
    let mut driver = running();
    for other in [
        Frame::new(Id::Standard(0x294), &[0; 8]).unwrap(),
        Frame::new(Id::Standard(0x291), &[0; 7]).unwrap(),
        Frame::new(Id::Extended(0x291), &[0; 8]).unwrap(),
        Frame::new_remote(Id::Standard(0x291), 8).unwrap(),
    ] {
        driver.receive(&a, 2_000);
        driver.receive(&b, 2_000);
        assert_eq!(driver.receive(&other, 2_000), None);
        assert!(driver.receive(&c, 2_000).is_some());
    }
    assert_eq!(driver.counters().unknown, 4);
}

proptest! {
    /// Each reading has its number in all six axes; frames are lost, and readings are 1 ms apart.
    #[test]
    fn lost_frames_never_mix_readings(lost in prop::collection::vec(0..8_u8, 1..100)) {
        let mut driver = running();
        for (number, lost) in lost.into_iter().enumerate() {
            let frames = stream_frames([number as f32; 6]).unwrap();
            for (part, frame) in frames.iter().enumerate() {
                if lost & 1 << part != 0 {
                    continue;
                }
                let now_us = 2_000 + 1_000 * number as u64 + 130 * part as u64;
                if let Some(reading) = driver.receive(frame, now_us) {
                    prop_assert_eq!(reading.wrench, [number as f64; 6]);
                    prop_assert_eq!(lost, 0);
                }
            }
        }
    }

    #[test]
    fn any_frames_at_any_time_are_survived(
        frames in prop::collection::vec(
            (0x28F..0x296_u16, prop::collection::vec(any::<u8>(), 0..=8), any::<u64>()),
            0..100,
        ),
    ) {
        let mut driver = running();
        for (id, data, now_us) in frames {
            driver.poll_transmit(now_us);
            let frame = Frame::new(Id::Standard(id), &data).unwrap();
            if let Some(reading) = driver.receive(&frame, now_us) {
                prop_assert!(reading.wrench.iter().all(|value| value.is_finite()));
            }
        }
    }
}
