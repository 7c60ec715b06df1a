//! The sensor and its bus.

use super::super::Check;
use super::Answers;
use super::robot::per_second;
use softdock_control::settings::Settings;
use softdock_link::service::{Health, SensorHealth};
use softdock_report::number;

/// Share of the cycles that need a sample of their own.
const FRESH: f64 = 0.99;

pub(super) fn checks(answers: &Answers, settings: &Settings) -> Vec<Check> {
    let mut checks = vec![driver(answers)];
    if let Some([first, last]) = &answers.health {
        match (first.sensor, last.sensor) {
            (before, Some(now)) => checks.extend([
                rate((first, before), (last, now), settings),
                status(&now, settings),
            ]),
            (_, None) => checks.push(Check::bad(
                "sensor rate",
                "no sample came since boot: look at the sensor's cable and its supply, on CAN at the termination",
            )),
        }
    }
    checks.push(bus(answers));
    checks
}

fn driver(answers: &Answers) -> Check {
    let name = "sensor";
    match answers.status.sensor.as_str() {
        "Running" => Check::good(name, "Running"),
        "" => Check::bad(name, "its driver has not started"),
        state => Check::bad(
            name,
            format!(
                "{state}: {}; `softdock params mode reset` starts it anew",
                advice(state)
            ),
        ),
    }
}

/// Advice for a state of the driver, by the beginning of its name, which may be cut off.
fn advice(state: &str) -> &'static str {
    let fault = state.trim_start_matches("Failed(");
    [
        ("OtherLink", "the settings and the image differ in what the sensor is on; `cargo firmware -- --sensor ethercat` builds the other image"),
        ("BitTiming", "the board's CAN controller does not run at the sensor's rate: this image was built with other clocks"),
        ("NoSubDevice", "frames come back that no sensor has seen: is its IN port connected, without a switch in between?"),
        ("SubDevices", "connect the sensor alone"),
        ("Vendor", "is this the ATI sensor?"),
        ("Product", "is this an Axia80 or an EtherCAT F/T?"),
        ("PdoBytes", "another tool has changed what the sensor sends: restore its defaults"),
        ("Object", "its calibration cannot be read: is its firmware that of the manual?"),
        ("StartUp", "it does not become operational: switch it off and on"),
        ("NotOperational", "it left OP: look at its supply, switch it off and on"),
        ("Standing", "its sample counter stands: switch it off and on"),
    ]
    .iter()
    .find(|(name, _)| fault.starts_with(name))
    .map_or(
        "is it powered, is its cable in, are `can.sensor`, `can.base_id` and `ethercat.enabled` right?",
        |(_, advice)| advice,
    )
}

fn rate(
    (first, before): (&Health, Option<SensorHealth>),
    (last, now): (&Health, SensorHealth),
    settings: &Settings,
) -> Check {
    let name = "sensor rate";
    let before = before.map_or(0, |sample| sample.counter);
    let samples = u64::from(now.counter.wrapping_sub(before));
    let cycles = last.cycles.saturating_sub(first.cycles);
    let Some(rate) = per_second(first, last, samples) else {
        return Check::warning(name, "the board started over while it was watched");
    };
    let words = format!(
        "{} samples per second, the newest {} ms old",
        number::significant(rate, 3),
        now.age_ms
    );
    let stale_ms = f64::from(settings.sensor.stale_after_cycles) * settings.robot.cycle_s * 1e3;
    if samples == 0 || f64::from(now.age_ms) > stale_ms {
        Check::bad(
            name,
            format!(
                "{words}: look at the sensor's cable and its supply, on CAN at the termination"
            ),
        )
    } else if (samples as f64) < FRESH * cycles as f64 {
        Check::warning(
            name,
            format!("{words}, less than cycles; is another node busy on the bus?"),
        )
    } else {
        Check::good(name, words)
    }
}

fn status(now: &SensorHealth, settings: &Settings) -> Check {
    let (name, bits) = ("sensor status", now.status);
    if now.saturated {
        Check::bad(
            name,
            "a gauge is at its range, so all six axes are wrong: take the load off the sensor",
        )
    } else if bits & !settings.sensor.ignored_status_bits != 0 {
        Check::bad(
            name,
            format!("status bits {bits:#06x} are set: see the sensor's manual"),
        )
    } else if bits != 0 {
        Check::warning(name, format!("status bits {bits:#06x} are set and ignored"))
    } else {
        Check::good(name, "no error bit, no saturated gauge")
    }
}

fn bus(answers: &Answers) -> Check {
    let name = "CAN bus";
    let [first, last] = &answers.counters;
    let wrong = |c: &softdock_link::service::Counters| {
        [
            c.sensor_timeouts,
            c.sensor_late,
            c.sensor_unpaired,
            c.sensor_invalid,
            c.bus_offs,
            c.can_losses,
        ]
        .map(u64::from)
        .iter()
        .sum::<u64>()
    };
    let words = format!(
        "since boot {} requests without answer, {} late, {} unpaired, {} unreadable; {} times bus-off, {} losses",
        last.sensor_timeouts,
        last.sensor_late,
        last.sensor_unpaired,
        last.sensor_invalid,
        last.bus_offs,
        last.can_losses
    );
    let (before, now) = (wrong(first), wrong(last));
    if now > before {
        Check::warning(
            name,
            format!(
                "{words}, and {} of all that just now: look at cable, termination and supply",
                now - before
            ),
        )
    } else if last.bus_offs > 0 {
        Check::warning(
            name,
            format!("{words}; is the bit rate right, is the bus terminated at both ends?"),
        )
    } else {
        Check::good(name, words)
    }
}
