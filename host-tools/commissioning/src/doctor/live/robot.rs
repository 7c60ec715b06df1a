//! The robot's link.

use super::super::{Check, robot};
use super::Answers;
use softdock_control::settings::Settings;
use softdock_link::rsi::poscorr_clamps;
use softdock_link::service::{Health, RobotHealth};
use softdock_report::number;

/// How far the pace of the telegrams may be from that of the settings.
const PACE: f64 = 0.1;

pub(super) fn checks(answers: &Answers, settings: &Settings) -> Vec<Check> {
    let name = "robot link";
    // A telegram may be overdue at the very moment of the question.
    let [before, now] = &answers.counters;
    if !answers.status.robot && now.cycles <= before.cycles {
        return vec![Check::warning(
            name,
            "the robot sends no telegrams: start RSI; if it runs, does its configuration name this board \
             (`softdock robot-config`), and can they reach each other?",
        )];
    }
    let mut checks = vec![senders(answers), lost(answers)];
    if let Some([first, last]) = &answers.health {
        checks.push(pace(first, last, settings.robot.cycle_s));
        if let (Some(before), Some(now)) = (first.robot, last.robot) {
            checks.extend([late(&before, &now), pose(&now), clamp(&now)]);
        }
    }
    checks
}

/// Telegrams per second, by the board's clock.
pub(super) fn per_second(first: &Health, last: &Health, count: u64) -> Option<f64> {
    let passed_ms = last.uptime_ms.checked_sub(first.uptime_ms)?;
    (passed_ms > 0).then(|| count as f64 * 1e3 / passed_ms as f64)
}

fn pace(first: &Health, last: &Health, cycle_s: f64) -> Check {
    let name = "robot cycle";
    let cycles = last.cycles.saturating_sub(first.cycles);
    let Some(rate) = per_second(first, last, cycles) else {
        return Check::warning(name, "the board started over while it was watched");
    };
    let nominal = 1.0 / cycle_s;
    let words = format!("{} cycles per second", number::significant(rate, 3));
    match (rate / nominal - 1.0).abs() < PACE {
        true => Check::good(name, words),
        false => Check::warning(
            name,
            format!(
                "{words}, and the settings say {}: set `control.robot.cycle_s`, or RSI_ON's #IPO or \
                 #IPO_FAST; or the network loses telegrams",
                number::significant(nominal, 3)
            ),
        ),
    }
}

fn senders(answers: &Answers) -> Check {
    let (name, counters) = ("robot link", &answers.counters[1]);
    let words = format!(
        "connected; {} cycles in {} runs since boot",
        counters.cycles, counters.runs
    );
    if counters.malformed > 0 {
        return Check::warning(
            name,
            format!(
                "{words}, and {} telegrams could not be read: give the robot the configuration of \
                 `softdock robot-config`",
                counters.malformed
            ),
        );
    }
    if counters.foreign > 0 {
        return Check::warning(
            name,
            format!(
                "{words}, and {} datagrams of other senders: set `rsi.robot_ip`, and find out who sends them",
                counters.foreign
            ),
        );
    }
    Check::good(name, words)
}

fn lost(answers: &Answers) -> Check {
    let (name, counters) = ("lost telegrams", &answers.counters[1]);
    // An overtaken one is missing in the sequence, too, if a cycle came after it.
    let missed = counters.lost.max(counters.overtaken);
    let share = f64::from(missed) / counters.cycles.max(1) as f64;
    let words = format!(
        "{} lost, {} overtaken, {} twice, of {} since boot",
        counters.lost, counters.overtaken, counters.duplicates, counters.cycles
    );
    if missed == 0 {
        Check::good(name, words)
    } else if share < robot::LOST {
        Check::warning(name, format!("{words}; look at cable and switch"))
    } else {
        Check::bad(
            name,
            format!("{words}; give the robot a cable or a switch of its own"),
        )
    }
}

fn late(before: &RobotHealth, now: &RobotHealth) -> Check {
    let name = "late answers";
    // The robot's counter starts from zero in each run.
    let rise = now.late_answers.saturating_sub(before.late_answers);
    match now.late_answers {
        0 => Check::good(name, "the robot counted none"),
        n => Check::warning(
            name,
            format!(
                "the robot counted {n} in its run, {rise} of them while it was watched; as many as \
                 `Timeout` of its ETHERNET object end the run"
            ),
        ),
    }
}

fn pose(now: &RobotHealth) -> Check {
    let name = "robot pose";
    match now.pose {
        true => Check::good(name, "in the last telegram"),
        false => Check::bad(
            name,
            "missing: add DEF_RIst to the robot's configuration (`softdock robot-config`)",
        ),
    }
}

fn clamp(now: &RobotHealth) -> Check {
    let name = "POSCORR";
    let status = now.poscorr_stat;
    match poscorr_clamps(status) {
        false => Check::good(name, "does not clamp, as far as its status is sent"),
        true => Check::bad(
            name,
            format!(
                "clamps (status {status:#04x}): move the robot back, or widen its limits beyond `control.limits.box_m`"
            ),
        ),
    }
}
