//! The sensor's samples.

use super::Check;
use softdock_app::record::CycleRecord;
use softdock_control::settings::Settings;
use softdock_io::recording::Recording;
use softdock_report::number;
use softdock_statistics::{Noise, noise_floor};
use std::ops::Range;

/// Share of cycles without a new sample that a link in order has.
const WITHOUT: f64 = 0.01;
/// Noise from which on a load can hardly be controlled, relative to the load that forbids a start.
const NOISY: f64 = 0.1;
/// Noise below this is round-off, N and N·m.
const UNSEEN: f64 = 1e-6;
/// Velocity below which the robot rests, m/s and rad/s.
const RESTS: f64 = 1e-3;
/// Cycles at rest at either end between which a drift is judged.
const ENDS: usize = 50;

/// Axes of a wrench.
const FORCE_AND_TORQUE: [Range<usize>; 2] = [0..3, 3..6];

pub(super) fn checks(recording: &Recording, settings: Option<&Settings>) -> Vec<Check> {
    let cycles = recording.cycles.as_slice();
    let measured = |c: &&CycleRecord| c.inputs.sensor.wrench.iter().all(|v| v.is_finite());
    if !cycles.iter().any(|c| measured(&c)) {
        return vec![Check::bad("sensor", "no reading of a sensor is recorded")];
    }
    // Rows before the first sample hold no reading, only the compensation of the tool's weight.
    let first = cycles.iter().position(|c| c.inputs.sensor.counter > 0);
    let cycles = cycles.get(first.unwrap_or(0)..).unwrap_or_default();
    let defaults = Settings::default();
    let settings = settings.unwrap_or(&defaults);
    vec![
        rate(cycles, settings),
        status(cycles, settings),
        noise(cycles, settings),
        drift(cycles, settings),
        load(cycles, settings),
    ]
}

fn rate(cycles: &[CycleRecord], settings: &Settings) -> Check {
    let name = "sensor rate";
    let old = cycles.iter().filter(|c| c.trace.sensor_age > 0).count();
    let oldest = cycles.iter().map(|c| c.trace.sensor_age).max().unwrap_or(0);
    let share = old as f64 / cycles.len().max(1) as f64;
    let words = format!(
        "a new sample in {} of the cycles, the oldest {oldest} cycles old",
        number::percent(1.0 - share, 1)
    );
    if oldest > settings.sensor.stale_after_cycles {
        Check::bad(
            name,
            format!("{words}: look at the CAN bus, its termination and its supply"),
        )
    } else if share > WITHOUT {
        Check::warning(name, format!("{words}; is another node busy on the bus?"))
    } else {
        Check::good(name, words)
    }
}

fn status(cycles: &[CycleRecord], settings: &Settings) -> Check {
    let name = "sensor status";
    let bits = cycles.iter().fold(0, |all, c| all | c.inputs.sensor.status);
    let saturated = cycles.iter().filter(|c| c.inputs.sensor.saturated).count();
    if saturated > 0 {
        return Check::bad(
            name,
            format!("a gauge was at its range in {saturated} cycles: all six axes were wrong then"),
        );
    }
    if bits & !settings.sensor.ignored_status_bits != 0 {
        return Check::bad(name, format!("status bits {bits:#06x} were set"));
    }
    if bits != 0 {
        return Check::warning(
            name,
            format!("status bits {bits:#06x} were set and are ignored"),
        );
    }
    let words = |c: &CycleRecord| c.inputs.sensor.counts;
    let counted = cycles.iter().any(|c| words(c) != [0; 6]);
    let frozen = counted
        && cycles
            .windows(2)
            .all(|pair| words(&pair[0]) == words(&pair[1]));
    if frozen && cycles.len() > ENDS {
        return Check::warning(
            name,
            "no gauge ever changed by a count: is it simulated, or stuck?",
        );
    }
    Check::good(name, "no error bit, no saturated gauge")
}

fn noise(cycles: &[CycleRecord], settings: &Settings) -> Check {
    let name = "sensor noise";
    let of_axis = |axis: usize| {
        let series: Vec<f64> = cycles
            .iter()
            .map(|c| c.inputs.sensor.wrench[axis])
            .collect();
        noise_floor(&series, Noise::White, None)
    };
    let worst = FORCE_AND_TORQUE.map(|axes| axes.filter_map(of_axis).fold(0.0, f64::max));
    if worst.iter().all(|sigma| *sigma < UNSEEN) {
        return Check::good(name, "none is seen");
    }
    let words = format!("{}, one sigma of the worst axes", words(worst));
    if is_beyond(worst, NOISY, settings) {
        Check::warning(
            name,
            format!("{words}: look at shield and grounding, and at the robot's drives"),
        )
    } else {
        Check::good(name, words)
    }
}

fn drift(cycles: &[CycleRecord], settings: &Settings) -> Check {
    let name = "sensor drift";
    let rests = |c: &&CycleRecord| {
        let v = c.trace.executed_velocity;
        !c.trace.mode.moves() && v.iter().all(|v| v.abs() < RESTS)
    };
    let still: Vec<&CycleRecord> = cycles.iter().filter(rests).collect();
    if still.len() < 4 * ENDS {
        return Check::warning(
            name,
            "the robot hardly rests outside of a run: record some seconds in `hold` to see it",
        );
    }
    let mean = |part: &[&CycleRecord], axis: usize| {
        part.iter().map(|c| c.trace.wrench_at_m[axis]).sum::<f64>() / part.len() as f64
    };
    let ends = (&still[..ENDS], &still[still.len() - ENDS..]);
    let change = |axis: usize| (mean(ends.1, axis) - mean(ends.0, axis)).abs();
    let worst = FORCE_AND_TORQUE.map(|axes| axes.map(change).fold(0.0, f64::max));
    let lasts_s = still[still.len() - 1].trace.time_s - still[0].trace.time_s;
    let words = format!(
        "the compensated load at rest changed by {} in {lasts_s:.0} s",
        words(worst)
    );
    if is_beyond(worst, NOISY, settings) {
        Check::warning(
            name,
            format!("{words}: warm up, take the zero, or calibrate the tool's weight"),
        )
    } else {
        Check::good(name, words)
    }
}

/// A robot in free space feels nothing; a force at rest is a wrong weight or zero, a torque alone a wrong centre of
/// mass.
fn load(cycles: &[CycleRecord], settings: &Settings) -> Check {
    let name = "force at rest";
    let resting = |axes: Range<usize>| {
        let still = cycles.iter().filter(|c| !c.trace.mode.moves());
        let squares = still.map(|c| {
            c.trace.wrench_at_m[axes.clone()]
                .iter()
                .map(|v| v * v)
                .sum()
        });
        let sizes = squares.map(f64::sqrt).filter(|size| size.is_finite());
        softdock_statistics::median(&mut sizes.collect::<Vec<f64>>())
    };
    let [Some(force), Some(torque)] = FORCE_AND_TORQUE.map(resting) else {
        return Check::warning(name, "no cycle outside of a run is recorded");
    };
    let load = [force, torque];
    let words = format!("{} compensated", words(load));
    let most = format!(
        "{} N and {} N·m",
        settings.start.max_force_n, settings.start.max_torque_n_m
    );
    if is_beyond(load, 1.0, settings) {
        Check::bad(
            name,
            format!(
                "{words}, arming needs less than {most}: `softdock calibrate sensor`, or in hold `softdock params \
                 mode zero`"
            ),
        )
    } else if is_beyond(load, 0.5, settings) {
        Check::warning(
            name,
            format!("{words}, not far from the {most} that forbid arming"),
        )
    } else {
        Check::good(name, words)
    }
}

/// A force and a torque, N and N·m.
fn words([force, torque]: [f64; 2]) -> String {
    let [force, torque] = [force, torque].map(|size| number::significant(size, 2));
    format!("{force} N and {torque} N·m")
}

/// Whether a force or a torque is beyond this share of what forbids a start.
fn is_beyond([force, torque]: [f64; 2], share: f64, settings: &Settings) -> bool {
    let start = &settings.start;
    force > share * start.max_force_n || torque > share * start.max_torque_n_m
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::State;

    /// Arming refuses a torque, too: a wrong centre of mass leaves no force.
    #[test]
    fn a_torque_at_rest_is_judged_by_its_own_limit() {
        let settings = Settings::default();
        let most = settings.start.max_torque_n_m;
        for (share, state) in [(1.2, State::Bad), (0.7, State::Warning), (0.2, State::Good)] {
            let mut cycle = CycleRecord::default();
            cycle.trace.wrench_at_m[5] = share * most;
            assert_eq!(load(&[cycle], &settings).state, state, "{share}");
        }
    }
}
