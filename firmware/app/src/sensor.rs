//! The sensor task: keeps the newest force sample up to date, for any type of link.

use crate::board::{Clock, IoError, SensorBus};
use crate::shared::{LastSample, Shared};
use embassy_futures::select::{Either, Either5, select, select5};
use embassy_sync::blocking_mutex::raw::RawMutex;
use softdock_control::io::SensorSample;
use softdock_link::sensor::{SensorDriver, SensorFault, SensorReading, SensorState};

/// Pause after bus-off before the controller tries again, µs: a broken cable must not keep the
/// controller busy.
const BUS_OFF_PAUSE_US: u64 = 100_000;
/// Recoveries without a frame in between after which only an operator's reset helps.
const BUS_OFF_RETRIES: u32 = 10;

/// Runs until the bus is closed.
pub async fn run<M: RawMutex, B: SensorBus>(
    shared: &Shared<M>,
    bus: &mut B,
    clock: &impl Clock,
    mut driver: impl SensorDriver<Frame = B::Frame>,
) {
    let mut recoveries = 0;
    loop {
        let outcome = match exchange(shared, bus, clock, &mut driver).await {
            Ok(received) => {
                if received {
                    recoveries = 0;
                }
                Ok(())
            }
            Err(IoError::BusOff) => {
                bus_off(shared, clock, &mut driver, &mut recoveries).await;
                bus.recover().await
            }
            Err(error) => Err(error),
        };
        match outcome {
            Err(IoError::Closed) => return,
            Err(IoError::Lost) => shared.update_status(|status| {
                status.can_losses = status.can_losses.saturating_add(1);
            }),
            // A failed recovery shows at the next use of the bus.
            Ok(()) | Err(IoError::BusOff) => {}
        }
    }
}

/// Publishes that the settings name a sensor on a link that this board does not have: there will be no sample.
pub fn refuse<M: RawMutex>(shared: &Shared<M>) {
    fail(shared, SensorFault::OtherLink);
}

/// Publishes why there will be no sample.
pub fn fail<M: RawMutex>(shared: &Shared<M>, fault: SensorFault) {
    shared.update_status(|status| status.sensor = Some(SensorState::Failed(fault)));
}

/// Sends what is due, then handles the first of these events: a frame, the next deadline, a telegram that requests a sample, the
/// operator's reset, or a test of the bus. Returns whether it was a frame.
async fn exchange<M: RawMutex, B: SensorBus>(
    shared: &Shared<M>,
    bus: &mut B,
    clock: &impl Clock,
    driver: &mut impl SensorDriver<Frame = B::Frame>,
) -> Result<bool, IoError> {
    let due = driver.poll_transmit(clock.now_us());
    shared.update_status(|status| {
        status.sensor = Some(driver.state());
        status.sensor_counters = driver.counters();
    });
    if let Some(frame) = due {
        // A bus without acknowledgement never has room; after the deadline of its answer the request is useless.
        let too_late = clock.wait_until(driver.next_deadline_us());
        if let Either::First(sent) = select(bus.send(&frame), too_late).await {
            sent?;
        }
    }
    let restart = shared.restart_sensor.wait();
    let asked = shared.wanted.wait();
    let deadline = clock.wait_until(driver.next_deadline_us());
    // Earlier ones have priority: rare events come first, the deadline is met in any case.
    let test = shared.bus_test.wait();
    match select5(restart, test, bus.receive(), asked, deadline).await {
        // A sensor that is starting is not restarted again.
        Either5::First(()) if driver.state() == SensorState::Starting => {}
        Either5::First(()) => driver.restart(),
        Either5::Second(()) => shared.bus_tested.signal(bus.loop_back().await),
        Either5::Third(frame) => {
            if let Some(reading) = driver.receive(&frame?, clock.now_us()) {
                shared.update_status(|status| status.sample = Some(last_sample(&reading)));
                shared.publish(sample(&reading));
            }
            return Ok(true);
        }
        Either5::Fourth(()) => driver.expedite(clock.now_us()),
        Either5::Fifth(()) => {}
    }
    Ok(false)
}

/// Waits until the controller may be brought back: a pause, and after too many recoveries the
/// operator's reset.
async fn bus_off<M: RawMutex>(
    shared: &Shared<M>,
    clock: &impl Clock,
    driver: &mut impl SensorDriver,
    recoveries: &mut u32,
) {
    shared.update_status(|status| {
        status.bus_offs = status.bus_offs.saturating_add(1);
        // So that no telegram waits for a sample.
        status.sensor = Some(SensorState::Failed(SensorFault::NoAnswer));
    });
    if *recoveries >= BUS_OFF_RETRIES {
        shared.restart_sensor.wait().await;
        driver.restart();
        *recoveries = 0;
    }
    *recoveries += 1;
    clock.wait_until(clock.now_us() + BUS_OFF_PAUSE_US).await;
}

fn last_sample(reading: &SensorReading) -> LastSample {
    LastSample {
        counter: reading.counter,
        at_us: reading.at_us,
        status: reading.status,
        saturated: reading.saturated,
    }
}

fn sample(reading: &SensorReading) -> SensorSample {
    SensorSample {
        counter: reading.counter,
        wrench: reading.wrench,
        counts: reading.counts,
        status: reading.status,
        saturated: reading.saturated,
    }
}
