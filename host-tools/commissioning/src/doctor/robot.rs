//! The robot's link.

use super::Check;
use softdock_app::record::CycleRecord;
use softdock_control::io::Sequence;
use softdock_control::settings::Settings;
use softdock_io::recording::Recording;
use softdock_link::rsi::poscorr_clamps;
use softdock_report::number;

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
    vec![
        pace(cycles, cycle_s),
        lost(cycles),
        late(cycles),
        pose(cycles),
        clamp(cycles),
    ]
}

/// Time stamps of neighbouring telegrams, as a histogram.
fn pace(cycles: &[CycleRecord], cycle_s: f64) -> Check {
    let name = "robot cycle";
    let nominal = (cycle_s * 1e3).round() as u64;
    let steps = cycles.windows(2).filter(|pair| {
        pair[1].inputs.robot.sequence == Sequence::Next
            && pair[1].trace.cycle == pair[0].trace.cycle.wrapping_add(1)
    });
    let mut histogram = std::collections::BTreeMap::<u64, usize>::new();
    for pair in steps {
        let (before, after) = (pair[0].inputs.robot.counter, pair[1].inputs.robot.counter);
        *histogram.entry(after.wrapping_sub(before)).or_default() += 1;
    }
    let words: Vec<String> = histogram
        .iter()
        .map(|(ms, n)| format!("{n} of {ms} ms"))
        .collect();
    let words = words.join(", ");
    match histogram.keys().all(|ms| *ms == nominal) {
        true if histogram.is_empty() => Check::warning(name, "no two telegrams follow each other"),
        true => Check::good(name, words),
        false => Check::bad(
            name,
            format!(
                "{words}, and the settings say {nominal} ms: set `control.robot.cycle_s`, or \
                 RSI_ON's #IPO or #IPO_FAST"
            ),
        ),
    }
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

fn clamp(cycles: &[CycleRecord]) -> Check {
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
                number::significant(n as f64 * 0.004, 2)
            ),
        ),
    }
}
