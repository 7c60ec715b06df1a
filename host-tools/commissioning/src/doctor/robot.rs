//! The robot's link.

use super::{Check, State};
use softdock_app::record::CycleRecord;
use softdock_control::io::Sequence;
use softdock_control::settings::Settings;
use softdock_io::recording::Recording;
use softdock_link::rsi::poscorr_clamps;
use softdock_report::number;
use std::collections::BTreeMap;

/// Share of lost telegrams from which on a network needs repair.
pub(super) const LOST: f64 = 1e-3;

pub(super) fn checks(recording: &Recording, settings: Option<&Settings>) -> Vec<Check> {
    let cycles = recording.cycles.as_slice();
    if cycles.iter().all(|c| c.inputs.robot.counter == 0) {
        return vec![Check::warning(
            "robot link",
            "no telegram of a robot is recorded",
        )];
    }
    let cycle_s = settings.map_or(0.004, |s| s.robot.cycle_s);
    let pace = pace(cycles, cycle_s);
    let lost = match pace.state {
        // They are counted in cycles.
        State::Bad => Check::warning(
            "lost telegrams",
            "not judged: the settings say another cycle",
        ),
        State::Good | State::Warning => lost(cycles),
    };
    vec![
        pace,
        lost,
        late(cycles),
        pose(cycles),
        clamp(cycles, cycle_s),
    ]
}

/// Time stamps of neighbouring telegrams, as a histogram. The cycle is the mean of those about the commonest: some
/// controllers step unevenly, and what is lost makes steps of twice the cycle and more.
fn pace(cycles: &[CycleRecord], cycle_s: f64) -> Check {
    let name = "robot cycle";
    let nominal = (cycle_s * 1e3).round() as u64;
    let steps = cycles.windows(2).filter(|pair| {
        pair[1].inputs.robot.sequence != Sequence::NewRun
            && pair[1].trace.cycle == pair[0].trace.cycle.wrapping_add(1)
    });
    let mut histogram = BTreeMap::<u64, usize>::new();
    for pair in steps {
        let (before, after) = (pair[0].inputs.robot.counter, pair[1].inputs.robot.counter);
        *histogram.entry(after.wrapping_sub(before)).or_default() += 1;
    }
    let words: Vec<String> = histogram
        .iter()
        .map(|(ms, n)| format!("{n} of {ms} ms"))
        .collect();
    let words = words.join(", ");
    match cycle_ms(&histogram) {
        None => Check::warning(name, "no two telegrams follow each other"),
        Some(cycle) if cycle == nominal => Check::good(name, words),
        Some(_) => Check::bad(
            name,
            format!(
                "{words}, and the settings say {nominal} ms: set `control.robot.cycle_s`, or \
                 RSI_ON's #IPO or #IPO_FAST"
            ),
        ),
    }
}

/// Cycle of telegrams with such steps, ms: how many there are of each.
fn cycle_ms(steps: &BTreeMap<u64, usize>) -> Option<u64> {
    let (commonest, _) = steps.iter().max_by_key(|(_, count)| **count)?;
    let about = |ms: &u64| 2 * ms > *commonest && *ms < 2 * commonest;
    let near = steps.iter().filter(|(ms, _)| about(ms));
    let sums = near.fold((0, 0), |(time, count), (ms, n)| {
        (time + ms * *n as u64, count + n)
    });
    Some((sums.0 as f64 / sums.1 as f64).round() as u64)
}

fn lost(cycles: &[CycleRecord]) -> Check {
    let name = "lost telegrams";
    let gaps = cycles.iter().map(|c| match c.inputs.robot.sequence {
        Sequence::Gap(lost) => u64::from(lost),
        Sequence::Next | Sequence::NewRun => 0,
    });
    let lost: u64 = gaps.sum();
    let share = lost as f64 / cycles.len().max(1) as f64;
    let words = format!("{lost} of {}", cycles.len());
    if lost == 0 {
        Check::good(name, "none")
    } else if share < LOST {
        Check::warning(name, format!("{words}; look at cable and switch"))
    } else {
        Check::bad(
            name,
            format!("{words}; give the robot a cable or a switch of its own"),
        )
    }
}

fn late(cycles: &[CycleRecord]) -> Check {
    let name = "late answers";
    let rise: u64 = cycles
        .windows(2)
        .filter(|pair| pair[1].inputs.robot.sequence != Sequence::NewRun)
        .map(|pair| {
            let [before, after] = [0, 1].map(|k: usize| pair[k].inputs.robot.late_answers);
            u64::from(after.saturating_sub(before))
        })
        .sum();
    match rise {
        0 => Check::good(name, "the robot counted none"),
        n => Check::warning(
            name,
            format!(
                "the robot counted {n}; as many as `Timeout` of its ETHERNET object end the run"
            ),
        ),
    }
}

fn pose(cycles: &[CycleRecord]) -> Check {
    let name = "robot pose";
    let without = cycles
        .iter()
        .filter(|c| c.inputs.robot.pose.is_none())
        .count();
    match without {
        0 => Check::good(name, "in every telegram"),
        n => Check::bad(
            name,
            format!(
                "missing in {n} telegrams: add DEF_RIst to the robot's configuration (`softdock robot-config`)"
            ),
        ),
    }
}

fn clamp(cycles: &[CycleRecord], cycle_s: f64) -> Check {
    let name = "POSCORR";
    let clamped = cycles
        .iter()
        .filter(|c| poscorr_clamps(c.inputs.robot.status))
        .count();
    match clamped {
        0 => Check::good(name, "did not clamp, as far as its status is sent"),
        n => Check::bad(
            name,
            format!(
                "clamped in {n} cycles ({} s): widen its limits beyond `control.limits.box_m`",
                number::significant(n as f64 * cycle_s, 2)
            ),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_link::rsi as link;
    use softdock_link::rsi::SequenceTracker;

    /// Telegrams with these steps of their time stamps, as the board takes them with a cycle of 4 ms.
    fn telegrams(steps_ms: impl IntoIterator<Item = u64>) -> Recording {
        let mut tracker = SequenceTracker::new(4, 50);
        let mut stamp = 1000;
        tracker.classify(stamp);
        let cycle = |(n, step_ms): (usize, u64)| {
            stamp += step_ms;
            let mut cycle = CycleRecord::default();
            cycle.trace.cycle = n as u64;
            cycle.inputs.robot.counter = stamp;
            cycle.inputs.robot.sequence = match tracker.classify(stamp) {
                link::Sequence::Gap { lost } => Sequence::Gap(lost),
                _ => Sequence::Next,
            };
            cycle.inputs.robot.status = 3;
            cycle
        };
        Recording {
            cycles: steps_ms.into_iter().enumerate().map(cycle).collect(),
            ..Recording::default()
        }
    }

    fn check(recording: &Recording, settings: Option<&Settings>, name: &str) -> Check {
        let all = checks(recording, settings);
        all.into_iter().find(|check| check.name == name).unwrap()
    }

    /// A robot in #IPO and settings of #IPO_FAST: nothing is lost in the network.
    #[test]
    fn another_cycle_than_that_of_the_settings_is_named_as_such() {
        let slow = telegrams([12; 100]);
        let cycle = check(&slow, None, "robot cycle");
        assert_eq!(cycle.state, State::Bad);
        assert!(cycle.message.contains("cycle_s"), "{}", cycle.message);
        assert_eq!(check(&slow, None, "lost telegrams").state, State::Warning);
    }

    #[test]
    fn uneven_steps_and_losses_leave_the_cycle() {
        let uneven = telegrams((0..100).map(|n| if n % 2 == 0 { 3 } else { 5 }));
        assert_eq!(check(&uneven, None, "robot cycle").state, State::Good);
        let lossy = telegrams((0..100).map(|n| if n % 10 == 0 { 12 } else { 4 }));
        assert_eq!(check(&lossy, None, "robot cycle").state, State::Good);
        assert_eq!(check(&lossy, None, "lost telegrams").state, State::Bad);
    }

    #[test]
    fn the_time_in_which_poscorr_clamps_is_in_cycles_of_the_settings() {
        let mut settings = Settings::default();
        settings.robot.cycle_s = 0.012;
        let clamp = check(&telegrams([12; 100]), Some(&settings), "POSCORR");
        assert!(
            clamp.message.contains("100 cycles (1.2 s)"),
            "{}",
            clamp.message
        );
    }
}
