//! Which answer belongs to which request, on a bus that delays and loses frames.

use std::collections::VecDeque;

use proptest::prelude::*;
use softdock_link::can::ati::{AtiConfig, AtiDriver};
use softdock_link::can::{Frame, Id};
use softdock_link::sensor::SensorState;

use crate::bench::{Bench, GAUGES, calibration, device, opcode};

#[test]
fn a_late_pair_is_not_the_answer_to_the_next_request() {
    let mut bench = Bench::running();
    let asked = bench.request().unwrap();
    let old = bench.device.answer(&asked, [11; 6], 0);

    let fence = bench.request().unwrap();
    assert_eq!(bench.driver.state(), SensorState::Resynchronising);
    assert_ne!(opcode(&fence), 0, "gauges must not be asked for yet");
    for answer in &old {
        assert_eq!(bench.driver.receive(answer, bench.now_us), None);
    }
    for answer in bench.device.answer(&fence, [0; 6], 0) {
        assert_eq!(bench.driver.receive(&answer, bench.now_us), None);
    }
    assert_eq!(bench.driver.state(), SensorState::Running);
    assert_eq!(bench.step([22; 6], 0).unwrap().counts, [22; 6]);
    let counters = bench.driver.counters();
    assert_eq!(
        (counters.timeouts, counters.retries, counters.late),
        (1, 1, 2)
    );
}

#[test]
fn an_answer_at_the_deadline_is_late() {
    let mut bench = Bench::running();
    let asked = bench.request().unwrap();
    let answer = bench.device.answer(&asked, GAUGES, 0);
    let deadline_us = bench.driver.next_deadline_us();
    assert_eq!(bench.driver.receive(&answer[0], deadline_us - 1), None);
    assert_eq!(bench.driver.receive(&answer[1], deadline_us), None);
    let counters = bench.driver.counters();
    assert_eq!(
        (counters.timeouts, counters.unpaired, counters.late),
        (1, 1, 1)
    );
}

#[test]
fn the_second_half_alone_is_discarded() {
    let mut bench = Bench::running();
    let asked = bench.request().unwrap();
    let answer = bench.device.answer(&asked, GAUGES, 0);
    assert_eq!(bench.driver.receive(&answer[1], bench.now_us), None);
    assert_eq!(bench.driver.counters().unpaired, 1);
    assert_eq!(bench.driver.receive(&answer[0], bench.now_us), None);
    assert!(bench.driver.receive(&answer[1], bench.now_us).is_some());
}

#[test]
fn an_answer_that_nobody_asked_for_is_dropped() {
    let mut bench = Bench::running();
    let asked = bench.request().unwrap();
    let answer = bench.device.answer(&asked, GAUGES, 0);
    for (frame, completes) in [(0, false), (1, true), (0, false), (1, false)] {
        let reading = bench.driver.receive(&answer[frame], bench.now_us);
        assert_eq!(reading.is_some(), completes);
    }
    assert_eq!(bench.driver.counters().late, 2);
}

/// Disturbance of one exchange by the bus.
#[derive(Clone, Copy, Debug)]
struct Weather {
    request_lost: bool,
    /// Which frames of the answer are lost, as bits.
    answers_lost: u8,
    delay_us: u64,
}

fn weather() -> impl Strategy<Value = Weather> {
    let delay_us = prop_oneof![6 => 100..900_u64, 3 => 900..6_000_u64, 1 => 6_000..120_000_u64];
    let answers_lost = prop_oneof![8 => Just(0_u8), 2 => 0..8_u8];
    (prop::bool::weighted(0.1), answers_lost, delay_us).prop_map(
        |(request_lost, answers_lost, delay_us)| Weather {
            request_lost,
            answers_lost,
            delay_us,
        },
    )
}

/// Runs the exchanges with these disturbances, one per request, and checks every reading. The sensor writes the number of the
/// request into its gauges.
fn survive(weather: &[Weather]) -> Result<u32, TestCaseError> {
    let mut driver = AtiDriver::new(AtiConfig::default());
    let mut device = device();
    let mut asked_at_us = Vec::new();
    let mut on_the_bus: VecDeque<(u64, Frame)> = VecDeque::new();
    let mut bus_free_us = 0;
    let mut now_us = 0;
    let mut readings = 0;
    while asked_at_us.len() < weather.len() {
        if let Some(request) = driver.poll_transmit(now_us) {
            let number = asked_at_us.len();
            let weather = weather[number];
            asked_at_us.push(now_us);
            if !weather.request_lost {
                // The sensor answers in order, however late.
                bus_free_us = bus_free_us.max(now_us + weather.delay_us);
                let gauges = [number as i16; 6];
                for (bit, frame) in device.answer(&request, gauges, 0).into_iter().enumerate() {
                    if weather.answers_lost & 1 << bit == 0 {
                        on_the_bus.push_back((bus_free_us, frame));
                    }
                    bus_free_us += 100;
                }
            }
        }
        let next_us = driver.next_deadline_us();
        match on_the_bus.front().copied() {
            Some((at_us, frame)) if at_us < next_us => {
                on_the_bus.pop_front();
                now_us = now_us.max(at_us);
                if let Some(reading) = driver.receive(&frame, now_us) {
                    let number = usize::try_from(reading.counts[0]).unwrap();
                    prop_assert_eq!(reading.counts, [number as i32; 6], "gauges mixed");
                    prop_assert_eq!(reading.at_us, asked_at_us[number], "old sample, new time");
                    prop_assert_eq!(driver.calibration(), Some(&calibration()), "rows mixed");
                    readings += 1;
                }
            }
            _ => now_us = now_us.max(next_us),
        }
    }
    Ok(readings)
}

#[test]
fn good_weather_gives_a_reading_per_request() {
    let good = Weather {
        request_lost: false,
        answers_lost: 0,
        delay_us: 100,
    };
    assert_eq!(survive(&[good; 60]).unwrap(), 49);
}

proptest! {
    #[test]
    fn every_reading_belongs_to_its_request(
        weather in prop::collection::vec(weather(), 50..600),
    ) {
        survive(&weather)?;
    }

    #[test]
    fn any_frames_at_any_time_are_survived(
        frames in prop::collection::vec(
            (0x200..0x210_u16, prop::collection::vec(any::<u8>(), 0..=8), 0..3_000_u64),
            0..200,
        ),
    ) {
        let mut bench = Bench::running();
        for (id, data, wait_us) in frames {
            bench.now_us += wait_us;
            bench.driver.poll_transmit(bench.now_us);
            let frame = Frame::new(Id::Standard(id), &data).unwrap();
            bench.driver.receive(&frame, bench.now_us);
        }
    }
}
