//! The driver of an EtherCAT sensor: which exchange gives a reading, and when the driver restarts the SubDevice.

use softdock_link::ethercat::{
    ATI_VENDOR, AtiSubDevice, Control, EtherCatConfig, Exchange, Inputs, Product, Setup, StartUp,
    WORKING_COUNTER,
};
use softdock_link::sensor::{SensorDriver, SensorFault, SensorReading, SensorState};

/// Time after which readings are accepted, µs.
const BELIEVED_US: u64 = 25_000;

/// Time after which an exchange is lost, µs.
const TIMEOUT_US: u64 = 800;

fn config() -> EtherCatConfig {
    EtherCatConfig {
        poll_period_us: 1_000,
        answer_timeout_us: TIMEOUT_US,
        control: Control {
            filter: 2,
            ..Control::default()
        },
    }
}

fn setup() -> Setup {
    let (force_unit, torque_unit) = Product::Axia80.newton_codes();
    Setup {
        vendor: ATI_VENDOR,
        product: Product::Axia80.code(),
        force_unit,
        torque_unit,
        counts_per_force: 1_000_000,
        counts_per_torque: 100_000,
    }
}

/// A driver with a SubDevice whose answers the test controls.
struct Bench {
    driver: AtiSubDevice,
    now_us: u64,
    sample: u32,
}

impl Bench {
    fn operational() -> Self {
        let mut driver = AtiSubDevice::new(config());
        assert_eq!(driver.poll_transmit(0), Some(Exchange::StartUp));
        assert_eq!(driver.state(), SensorState::Starting);
        assert_eq!(driver.receive(&Exchange::Ready(setup()), 0), None);
        Self {
            driver,
            now_us: 0,
            sample: 0,
        }
    }

    fn running() -> Self {
        let mut bench = Self::operational();
        while bench.now_us < BELIEVED_US {
            assert_eq!(bench.exchange(), None);
        }
        assert!(bench.exchange().is_some());
        assert_eq!(bench.driver.state(), SensorState::Running);
        bench
    }

    /// The outputs of the next exchange; any other request fails the test.
    fn ask(&mut self) -> [u8; 8] {
        let asked = self.driver.poll_transmit(self.now_us);
        assert!(matches!(asked, Some(Exchange::Outputs(_))), "{asked:?}");
        match asked {
            Some(Exchange::Outputs(outputs)) => outputs,
            _ => [0xFF; 8],
        }
    }

    fn answer(&mut self, working_counter: u16, operational: bool) -> Option<SensorReading> {
        let inputs = Inputs {
            counts: [2_000_000, -1_000_000, 500_000, 20_000, -30_000, 50_000],
            status: 0,
            sample: self.sample,
        };
        let answer = Exchange::Inputs {
            working_counter,
            operational,
            bytes: inputs.encode(),
        };
        self.driver.receive(&answer, self.now_us + 100)
    }

    /// Runs an exchange with a new sample, and waits until the next.
    fn exchange(&mut self) -> Option<SensorReading> {
        self.ask();
        self.sample = self.sample.wrapping_add(7);
        let reading = self.answer(WORKING_COUNTER, true);
        self.now_us += 1_000;
        reading
    }

    fn asks_for_a_start(&mut self) -> bool {
        self.driver.poll_transmit(self.now_us) == Some(Exchange::StartUp)
    }
}

#[test]
fn a_reading_is_scaled_and_numbered() {
    let mut bench = Bench::running();
    let reading = bench.exchange().unwrap();
    assert_eq!(reading.wrench, [2.0, -1.0, 0.5, 0.2, -0.3, 0.5]);
    assert_eq!((reading.counter, reading.status), (2, 0));
    assert_eq!(
        reading.at_us,
        bench.now_us - 2_000 + 100,
        "not before the one before was seen"
    );
}

#[test]
fn the_bias_is_cleared_first_and_the_filter_set() {
    let mut bench = Bench::operational();
    assert_eq!(bench.ask()[0], 0x24);
    bench.answer(WORKING_COUNTER, true);
    let mut bench = Bench::running();
    assert_eq!(bench.ask()[0], 0x20);
}

/// The bias is cleared for 20 ms, and readings are accepted 5 ms later, both exact to the microsecond.
#[test]
fn a_reading_is_believed_when_the_bias_has_settled() {
    for (at_us, cleared) in [(19_999, 0x24), (20_000, 0x20)] {
        let mut bench = Bench::operational();
        bench.now_us = at_us;
        assert_eq!(bench.ask()[0], cleared, "{at_us}");
    }
    for (at_us, believed) in [(BELIEVED_US - 1, false), (BELIEVED_US, true)] {
        let mut bench = Bench::operational();
        bench.exchange();
        // The answer comes 100 µs later.
        bench.now_us = at_us - 100;
        assert_eq!(bench.exchange().is_some(), believed, "{at_us}");
    }
}

#[test]
fn an_exchange_is_asked_for_once_in_a_period_and_waited_for() {
    let mut bench = Bench::running();
    let asked_us = bench.now_us;
    assert_eq!(bench.driver.next_deadline_us(), asked_us);
    bench.ask();
    assert_eq!(bench.driver.next_deadline_us(), asked_us + TIMEOUT_US);
    assert_eq!(bench.driver.poll_transmit(asked_us + 1), None, "on its way");
    bench.sample += 7;
    assert!(bench.answer(WORKING_COUNTER, true).is_some());
    assert_eq!(bench.driver.next_deadline_us(), asked_us + 1_000);
    assert_eq!(bench.driver.poll_transmit(asked_us + 999), None, "early");
    bench.driver.expedite(asked_us + 300);
    assert_eq!(bench.driver.next_deadline_us(), asked_us + 300);
    bench.now_us = asked_us + 300;
    bench.ask();
}

/// Running: there was a reading, and the last exchange was complete. Resynchronising: the last exchange failed.
#[test]
fn the_state_says_what_the_last_exchanges_were() {
    let mut bench = Bench::operational();
    assert_eq!(bench.driver.state(), SensorState::Starting);
    bench.ask();
    assert_eq!(bench.answer(1, true), None);
    assert_eq!(bench.driver.state(), SensorState::Starting);
    let mut bench = Bench::running();
    bench.ask();
    assert_eq!(bench.answer(1, true), None);
    assert_eq!(bench.driver.state(), SensorState::Resynchronising);
    bench.now_us += 1_000;
    assert!(bench.exchange().is_some());
    assert_eq!(bench.driver.state(), SensorState::Running);
}

#[test]
fn the_same_sample_or_an_older_one_is_no_reading() {
    let mut bench = Bench::running();
    for step in [0, u32::MAX, u32::MAX - 1000] {
        bench.ask();
        bench.sample = bench.sample.wrapping_add(step);
        assert_eq!(bench.answer(WORKING_COUNTER, true), None, "{step}");
        bench.sample = bench.sample.wrapping_sub(step);
        bench.now_us += 1_000;
    }
    assert_eq!(bench.driver.state(), SensorState::Running);
    assert!(bench.exchange().is_some());
}

#[test]
fn the_sample_counter_may_wrap() {
    let mut bench = Bench::operational();
    bench.sample = u32::MAX - 100;
    for _ in 0..25 {
        bench.exchange();
    }
    for _ in 0..10 {
        assert!(bench.exchange().is_some());
    }
}

#[test]
fn an_exchange_that_nobody_asked_for_is_late() {
    let mut bench = Bench::running();
    bench.sample += 1;
    assert_eq!(bench.answer(WORKING_COUNTER, true), None);
    assert_eq!(bench.driver.counters().late, 1);
}

#[test]
fn five_failed_exchanges_start_the_subdevice_anew() {
    type Fail = fn(&mut Bench);
    let failures: [(Fail, SensorFault); 3] = [
        (|bench| bench.now_us += 1_000, SensorFault::NoAnswer),
        (
            |bench| assert!(bench.answer(1, true).is_none()),
            SensorFault::NotOperational,
        ),
        (
            |bench| assert!(bench.answer(3, false).is_none()),
            SensorFault::NotOperational,
        ),
    ];
    for (fail, fault) in failures {
        let mut bench = Bench::running();
        for _ in 0..4 {
            bench.ask();
            fail(&mut bench);
            bench.now_us += 1_000;
        }
        assert!(bench.exchange().is_some(), "four cost nothing");
        for _ in 0..5 {
            bench.ask();
            fail(&mut bench);
            bench.now_us += 1_000;
        }
        assert!(bench.asks_for_a_start(), "{fault}");
        assert_eq!(bench.driver.state(), SensorState::Failed(fault));
    }
}

#[test]
fn a_start_that_failed_is_tried_again_and_its_reason_stands() {
    let mut bench = Bench::operational();
    bench.driver.restart();
    assert!(bench.asks_for_a_start());
    let fault = SensorFault::StartUp(StartUp::Op);
    bench.driver.receive(&Exchange::Failed(fault), bench.now_us);
    for _ in 0..3 {
        assert!(!bench.asks_for_a_start(), "not at once");
        assert_eq!(bench.driver.state(), SensorState::Failed(fault));
        bench.now_us = bench.driver.next_deadline_us();
        assert!(bench.asks_for_a_start());
        assert_eq!(bench.driver.state(), SensorState::Failed(fault));
        bench.driver.receive(&Exchange::Failed(fault), bench.now_us);
    }
}

#[test]
fn a_sensor_that_cannot_be_used_is_refused_with_its_reason() {
    let mut bench = Bench::operational();
    bench.driver.restart();
    assert!(bench.asks_for_a_start());
    let wrong = Setup {
        counts_per_torque: 0,
        ..setup()
    };
    bench.driver.receive(&Exchange::Ready(wrong), bench.now_us);
    let fault = SensorFault::CountsPerUnit {
        force: 1_000_000,
        torque: 0,
    };
    assert_eq!(bench.driver.state(), SensorState::Failed(fault));
    assert!(
        fault
            .to_string()
            .ends_with("1 to 100000000: force 1000000, torque 0"),
        "{fault}"
    );
}

#[test]
fn an_answer_to_nothing_changes_nothing() {
    let mut bench = Bench::running();
    bench
        .driver
        .receive(&Exchange::Ready(setup()), bench.now_us);
    bench
        .driver
        .receive(&Exchange::Failed(SensorFault::NoSubDevice), bench.now_us);
    assert_eq!(bench.driver.state(), SensorState::Running);
    assert_eq!(bench.driver.counters().late, 2);
}
