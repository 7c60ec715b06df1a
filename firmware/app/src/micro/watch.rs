//! The onlooker: logs changes of the shared state. It runs below the control cycle, which writes
//! no log itself.

use crate::board::Clock;
use crate::shared::{LinkCounters, Shared, Status};
use defmt::{Debug2Format, error, info, warn};
use embassy_sync::blocking_mutex::raw::RawMutex;

/// How often it looks, µs.
const PERIOD_US: u64 = 50_000;
/// Least time between two lines of counters, µs: a flood of bad telegrams must not become a flood
/// of lines.
const COUNTERS_PERIOD_US: u64 = 1_000_000;

/// Logs changes of mode, faults, refused commands, robot, sensor and counters for ever.
pub async fn run<M: RawMutex>(shared: &Shared<M>, clock: &impl Clock) -> ! {
    // From the state at boot on: a quick start is a change as well.
    let mut last = Status::default();
    let mut counted = last;
    let mut counters_at_us = 0;
    loop {
        let now_us = clock.now_us();
        let now = shared.status();
        report_changes(&last, &now);
        let robot_left = last.connected && !now.connected;
        last = now;
        if troubles(&now) != troubles(&counted) && now_us >= counters_at_us || robot_left {
            report_counters(&now);
            counted = now;
            counters_at_us = now_us + COUNTERS_PERIOD_US;
        }
        clock.wait_until(now_us + PERIOD_US).await;
    }
}

fn report_changes(last: &Status, now: &Status) {
    if now.connected != last.connected {
        match now.connected {
            true => info!("robot connected"),
            false => info!("robot silent"),
        }
    }
    if now.mode != last.mode {
        info!("mode {}", Debug2Format(&now.mode));
    }
    if let Some(fault) = now.fault.filter(|_| now.fault != last.fault) {
        error!(
            "fault {}: expected {=f64}, received {=f64}; `reset` when it is mended",
            Debug2Format(&fault.code),
            fault.expected,
            fault.received
        );
    }
    if let Some((command, refusal)) = now.refusal.filter(|_| now.refusal != last.refusal) {
        warn!(
            "{} refused: {}",
            Debug2Format(&command),
            Debug2Format(&refusal)
        );
    }
    if let Some(sensor) = now.sensor.filter(|_| now.sensor != last.sensor) {
        info!("sensor {}", Debug2Format(&sensor));
    }
}

/// The state without what changes while all is well.
fn troubles(status: &Status) -> Status {
    Status {
        link: LinkCounters {
            cycles: 0,
            ..status.link
        },
        sensor_counters: status.sensor_counters,
        bus_offs: status.bus_offs,
        can_losses: status.can_losses,
        ..Status::default()
    }
}

fn report_counters(status: &Status) {
    let link = &status.link;
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
