//! The monitor: logs changes of the shared state. It runs at a lower priority than the control cycle, which writes no log itself.
//! It also checks the depth of the stack.

use super::SHARED;
use super::clock::UptimeClock;
use crate::board::Clock;
use crate::shared::{Change, LinkCounters, Status};
use defmt::{Debug2Format, Display2Format, error, info, warn};
use softdock_link::sensor::SensorCounters;
use softdock_link::service::StackUse;

/// Period of the check of the stack, µs: finding the end of the paint takes 0.2 ms.
const STACK_PERIOD_US: u64 = 1_000_000;
/// Share of the stack above which its depth is worth a line, %.
const STACK_ALARM: u32 = 80;
/// How often the state is compared, µs.
const PERIOD_US: u64 = 50_000;
/// Shortest time between two lines of the link's counters, µs: a flood of bad telegrams must not flood the log.
const LINK_PERIOD_US: u64 = 1_000_000;
/// Shortest time between two lines of the sensor's counters, µs. They rise continuously without a sensor, which the sensor's
/// state reports already.
const SENSOR_PERIOD_US: u64 = 10_000_000;

/// Logs changes of mode, faults, refused commands, robot, sensor and counters for ever; for the
/// executor of what may wait.
#[embassy_executor::task]
pub async fn monitor() -> ! {
    let (shared, clock) = (&SHARED, &UptimeClock);
    // Starts from the state at boot, so that a quick start is logged as a change.
    let mut last = Status::default();
    let mut link = Counted::new(LINK_PERIOD_US, LinkCounters::default());
    let mut sensor = Counted::new(SENSOR_PERIOD_US, (SensorCounters::default(), 0, 0));
    let mut stack_us = 0;
    loop {
        let now_us = clock.now_us();
        if now_us >= stack_us {
            stack_us = now_us + STACK_PERIOD_US;
            look_at_stack();
        }
        let now = shared.status();
        now.changes_since(&last).for_each(report);
        let robot_left = last.connected && !now.connected;
        last = now;
        // Cycles increase in normal operation; they are logged together with the others.
        let troubles = LinkCounters {
            cycles: 0,
            ..now.link
        };
        if link.is_due(troubles, now_us) || robot_left {
            report_link(&now.link);
        }
        let counters = (now.sensor_counters, now.bus_offs, now.can_losses);
        if sensor.is_due(counters, now_us) {
            report_sensor(&now);
        }
        clock.wait_until(now_us + PERIOD_US).await;
    }
}

/// The stack is painted at reset; intact paint shows memory that was never used.
fn look_at_stack() {
    let available = cortex_m_stack::stack_size();
    let now = StackUse {
        deepest: available - cortex_m_stack::stack_painted(),
        available,
    };
    let last = SHARED.machine().stack.map_or(0, |stack| stack.deepest);
    if now.deepest > last
        && u64::from(now.deepest) * 100 > u64::from(available) * u64::from(STACK_ALARM)
    {
        warn!(
            "the stack was {=u32} of {=u32} bytes deep",
            now.deepest, available
        );
    }
    SHARED.update_machine(|machine| machine.stack = Some(now));
}

/// Counters as they were logged last.
struct Counted<T> {
    period_us: u64,
    logged: T,
    next_us: u64,
}

impl<T: PartialEq> Counted<T> {
    fn new(period_us: u64, logged: T) -> Self {
        Self {
            period_us,
            logged,
            next_us: 0,
        }
    }

    /// Whether they have changed and may be logged again.
    fn is_due(&mut self, now: T, now_us: u64) -> bool {
        let due = now != self.logged && now_us >= self.next_us;
        if due {
            self.logged = now;
            self.next_us = now_us + self.period_us;
        }
        due
    }
}

fn report(change: Change) {
    match change {
        Change::Connected(true) => info!("robot connected"),
        Change::Connected(false) => info!("robot silent"),
        Change::Mode(mode) => info!("mode {}", Debug2Format(&mode)),
        Change::Fault(fault) => error!(
            "fault {}, {}: expected {=f64}, received {=f64}; `reset` when it is mended",
            Debug2Format(&fault.code),
            Display2Format(&fault.code),
            fault.expected,
            fault.received
        ),
        Change::Refusal(command, refusal) => warn!(
            "{=str} refused: {}",
            command.word(),
            Display2Format(&refusal)
        ),
        Change::Sensor(sensor) => info!("sensor {}", Debug2Format(&sensor)),
    }
}

fn report_link(link: &LinkCounters) {
    info!(
        "{=u64} cycles, {=u32} lost, {=u32} twice, {=u32} overtaken, {=u32} malformed, {=u32} foreign, {=u32} runs",
        link.cycles,
        link.lost,
        link.duplicates,
        link.overtaken,
        link.malformed,
        link.foreign,
        link.runs
    );
}

fn report_sensor(status: &Status) {
    let sensor = &status.sensor_counters;
    info!(
        "sensor: {=u32} timeouts, {=u32} retries, {=u32} late, {=u32} unpaired, {=u32} unknown, {=u32} invalid; CAN: {=u32} bus-off, {=u32} losses",
        sensor.timeouts,
        sensor.retries,
        sensor.late,
        sensor.unpaired,
        sensor.unknown,
        sensor.invalid,
        status.bus_offs,
        status.can_losses
    );
}
