//! The board's own state: stack, Ethernet, how long its answers take, and how noisy its sensor is.

use super::super::Check;
use super::Answers;
use softdock_control::settings::Settings;
use softdock_link::service::{AnswerTimes, EthernetHealth, InputStatistics, Machine, StackUse};
use softdock_report::number::{percent, significant};

/// Share of the stack that may have been used.
const STACK_BUDGET: f64 = 0.8;
/// Share of a cycle that an answer may take: the robot's own network takes a part of the rest.
const ANSWER_BUDGET: f64 = 0.5;

pub(super) fn checks(answers: &Answers, settings: &Settings) -> Vec<Check> {
    let Some(machine) = &answers.machine else {
        return vec![Check::warning(
            "machine",
            "the firmware is too old to tell of its stack and its answers: flash a newer one",
        )];
    };
    let Machine {
        stack, ethernet, ..
    } = machine;
    let mut checks: Vec<Check> = stack.iter().map(self::stack).collect();
    checks.extend(ethernet.iter().map(self::ethernet));
    if machine.answers != AnswerTimes::NONE {
        checks.push(times(machine, settings.robot.cycle_s));
    }
    if machine.inputs != InputStatistics::NONE {
        checks.push(noise(&machine.inputs));
    }
    checks
}

fn stack(stack: &StackUse) -> Check {
    let name = "stack";
    let share = f64::from(stack.deepest) / f64::from(stack.available);
    let words = format!(
        "{} of {} bytes at its deepest since boot, {}",
        stack.deepest,
        stack.available,
        percent(share, 0)
    );
    match share <= STACK_BUDGET {
        true => Check::good(name, words),
        false => Check::warning(
            name,
            format!("{words}: too near to its end; send us the settings and the log"),
        ),
    }
}

fn ethernet(ethernet: &EthernetHealth) -> Check {
    let name = "Ethernet";
    let words = format!(
        "link lost {} times, reception brought back {} times since boot",
        ethernet.losses, ethernet.overruns
    );
    match (ethernet.link, ethernet.losses + ethernet.overruns) {
        (false, _) => Check::warning(
            name,
            format!(
                "no link, {words}: is the cable in, and does the other side offer 100 Mbit/s full duplex?"
            ),
        ),
        (true, 0) => Check::good(name, words),
        (true, _) => Check::warning(
            name,
            format!("{words}: look at the cable, and at who floods this network"),
        ),
    }
}

fn times(machine: &Machine, cycle_s: f64) -> Check {
    let (name, times) = ("answer time", &machine.answers);
    let work = machine.work.map_or_else(String::new, |work| {
        format!(", {} cycles of the processor at most", work.most)
    });
    let share = f64::from(times.longest_us) * 1e-6 / cycle_s;
    let words = format!(
        "{} µs, at most {} µs since boot ({} of a cycle){work}",
        times.last_us,
        times.longest_us,
        percent(share, 0)
    );
    match share <= ANSWER_BUDGET {
        true => Check::good(name, words),
        false => Check::warning(
            name,
            format!(
                "{words}, {} longer than a cycle: a faster law, a shorter `can.sample_wait_s`, or less on this network",
                times.late_answers()
            ),
        ),
    }
}

fn noise(inputs: &InputStatistics) -> Check {
    Check::good(
        "noise",
        format!(
            "force about {} N, torque about {} N·m rms; telegrams each {} µs ± about {} µs",
            significant(f64::from(inputs.force_noise_n), 2),
            significant(f64::from(inputs.torque_noise_n_m), 2),
            significant(f64::from(inputs.cycle_us), 5),
            significant(f64::from(inputs.cycle_deviation_us), 2)
        ),
    )
}
