//! The sample that belongs to a telegram.

use crate::bench::{Bench, CYCLE_US, START_CYCLES, flying, robot};
use crate::sensor::{Behaviour, EXCHANGE_US, opcode};
use crate::world::Event;
use softdock_link::sensor::SensorState;

/// Times of the answers after their telegrams, µs.
fn delays_us(bench: &Bench, first_telegram_us: u64) -> Vec<u64> {
    let world = bench.world();
    let late = world
        .answers
        .iter()
        .filter(|a| a.at_us >= first_telegram_us);
    late.map(|answer| (answer.at_us - first_telegram_us) % CYCLE_US)
        .collect()
}

/// Times of the requests for gauges since `from_us`.
fn gauge_requests_us(bench: &Bench, from_us: u64) -> Vec<u64> {
    let world = bench.world();
    let requests = world.requests.iter();
    let late = requests.filter(|(at_us, frame)| *at_us >= from_us && opcode(frame) == 0);
    late.map(|(at_us, _)| *at_us).collect()
}

#[test]
fn a_telegram_asks_for_its_sample() {
    let mut bench = Bench::cruising(&flying());
    let start_us = bench.next_at_us;
    let mut counter = bench.last_record().inputs.sensor.counter;
    for cycle in 0..10 {
        bench.world().sensor.gauges[0] = 100 * cycle;
        bench.cycle();
        let sensor = bench.last_record().inputs.sensor;
        assert_eq!(
            sensor.wrench[0],
            f64::from(cycle),
            "measured after the telegram"
        );
        assert_eq!(sensor.counter, counter + 1, "one request per telegram");
        counter = sensor.counter;
    }
    assert_eq!(delays_us(&bench, start_us), [EXCHANGE_US; 10]);
    let telegrams: Vec<u64> = (0..10).map(|n| start_us + n * CYCLE_US).collect();
    assert_eq!(gauge_requests_us(&bench, start_us), telegrams);
}

#[test]
fn a_dead_sensor_delays_an_answer_by_the_wait_at_most() {
    let settings = flying();
    let wait_us = settings.sample_wait_us();
    let mut bench = Bench::cruising(&settings);
    let start_us = bench.next_at_us;
    bench.world().sensor.behaviour = Behaviour::Silent;
    bench.cycles(20);
    let delays = delays_us(&bench, start_us);
    // The answer to the first request is awaited for 8 ms; after that the board does not wait any more.
    assert_eq!(delays[..2], [wait_us; 2]);
    assert_eq!(delays[2..], [0; 18]);
}

#[test]
fn a_slow_sensor_is_not_waited_for() {
    let settings = flying();
    let wait_us = settings.sample_wait_us();
    let mut bench = Bench::cruising(&settings);
    let start_us = bench.next_at_us;
    bench.world().sensor.exchange_us = 3_000;
    bench.cycles(20);
    assert_eq!(delays_us(&bench, start_us), [wait_us; 20]);
    // Each telegram gets the sample of the one before it.
    assert_eq!(bench.last_record().trace.sensor_age, 0);
    assert_eq!(bench.status().sensor, Some(SensorState::Running));
}

#[test]
fn no_wait_is_no_wait() {
    let mut settings = flying();
    settings.can.sample_wait_s = 0.0;
    let mut bench = Bench::new(&settings, true);
    let start_us = bench.next_at_us;
    bench.cycles(START_CYCLES);
    assert_eq!(delays_us(&bench, start_us), [0; START_CYCLES]);
}

/// A request in progress serves the telegram; a second one would only delay the reading.
#[test]
fn a_request_on_its_way_is_not_repeated() {
    let mut bench = Bench::new(&flying(), false);
    bench.cycles(3);
    // Without telegrams, the sensor is polled at its own rate.
    bench.lose(100);
    let from_us = bench.next_at_us - 8 * CYCLE_US;
    bench.run_to(bench.next_at_us);
    let polls = gauge_requests_us(&bench, from_us);
    assert!(polls.windows(2).all(|pair| pair[1] - pair[0] == 5_000));
    let poll_us = polls[polls.len() - 1] + 5_000;
    let event = Event::Datagram(bench.telegram(), robot());
    bench.world().schedule(poll_us + 200, event);
    bench.run_to(poll_us + 1_000);
    assert_eq!(gauge_requests_us(&bench, poll_us), [poll_us]);
    assert_eq!(delays_us(&bench, poll_us + 200), [EXCHANGE_US - 200]);
}

/// Telegrams that were not served leave one request altogether, not one each.
#[test]
fn unserved_telegrams_do_not_pile_up() {
    let mut bench = Bench::new(&flying(), false);
    bench.world().go_bus_off();
    bench.cycles(26);
    let recovered_us = bench.world().recoveries_us[0];
    bench.cycles(10);
    let until_us = recovered_us + 2 * CYCLE_US;
    let after = gauge_requests_us(&bench, recovered_us);
    let soon = after.iter().filter(|at| **at < until_us).count();
    assert!(soon <= 4, "{after:?}");
    assert_eq!(bench.status().sensor, Some(SensorState::Running));
}

/// Frames that arrive at the time of a telegram, a deadline and a request are all received.
#[test]
fn no_frame_is_lost_when_everything_comes_at_once() {
    for exchange_us in [CYCLE_US, CYCLE_US / 2, 5_000, 1_000] {
        let mut settings = flying();
        settings.can.poll_period_s = 0.002;
        let mut bench = Bench::new(&settings, false);
        bench.world().sensor.exchange_us = exchange_us;
        let (from_us, before) = (bench.next_at_us, bench.shared.sample().counter);
        bench.cycles(200);
        let asked = gauge_requests_us(&bench, from_us).len() as u32;
        let answered = bench.shared.sample().counter - before;
        assert!(
            answered.abs_diff(asked) <= 1,
            "{exchange_us}: {asked} {answered}"
        );
        assert!(answered >= 130);
        assert_eq!(bench.status().sensor_counters, Default::default());
    }
}
