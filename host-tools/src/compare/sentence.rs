//! Where the model fails, in words.

use super::errors::AxisError;
use super::explain::Explanation;
use super::failure::Failure;
use crate::model::{Channel, Model};
use crate::report::number;

/// Further failures with at least this share of the error are mentioned.
const MENTIONED_SHARE: f64 = 0.1;
/// Most further failures that are mentioned.
const MOST_MENTIONED: usize = 3;
/// Named phases that take at least this share of the time are not a place.
const EVERYWHERE: f64 = 0.6;

/// The whole finding.
pub(super) fn whole(model: &Model, errors: &[AxisError], failures: &[Failure]) -> String {
    let Some(worst) = failures.first() else {
        return at_noise(errors);
    };
    let mut text = format!(
        "The model fails in {} {}: {}",
        worst.channel,
        worst.axis,
        place(worst)
    );
    if let Some(explanation) = &worst.explanation {
        text += &format!("; {}", description(model, worst, explanation));
    }
    text.push('.');
    let others: Vec<String> = failures
        .iter()
        .skip(1)
        .filter(|f| f.share >= MENTIONED_SHARE)
        .take(MOST_MENTIONED)
        .map(|f| format!("{} {} ({})", f.channel, f.axis, phase_names(f)))
        .collect();
    if !others.is_empty() {
        text += &format!(" It also fails in {}.", listed(&others));
    }
    text
}

fn at_noise(errors: &[AxisError]) -> String {
    if errors.iter().all(|e| e.overall().count == 0) {
        return "Nothing in this recording can be predicted: it holds no measured motion and no \
                sensor sample."
            .to_owned();
    }
    let worst = errors
        .iter()
        .max_by(|a, b| a.overall().rms().total_cmp(&b.overall().rms()));
    let largest = worst.map_or(String::new(), |e| {
        let times = number::significant(e.overall().rms(), 3);
        let (channel, axis) = (e.channel, e.axis);
        format!(", the largest in {channel} {axis} with {times} times the expected noise")
    });
    format!("The model agrees with the recording: every error is at the noise{largest}.")
}

/// Which phases and when.
fn place(failure: &Failure) -> String {
    let share: f64 = failure.phases.iter().map(|p| p.share).sum();
    let percent = number::percent(share, 0);
    let (from, to) = (failure.worst.from_s, failure.worst.to_s);
    let names = phase_names(failure);
    if failure.time_share >= EVERYWHERE {
        return format!(
            "the error is spread over the recording, {percent} of it in {names}, which take {} of \
             the time",
            number::percent(failure.time_share, 0)
        );
    }
    let stands = format!("{percent} of the error beyond the noise stands in {names}");
    if failure.windows == 1 {
        format!("{stands} ({from:.3} s to {to:.3} s)")
    } else {
        let windows = failure.windows;
        format!("{stands} (in {windows} windows, most from {from:.3} s to {to:.3} s)")
    }
}

fn phase_names(failure: &Failure) -> String {
    let names: Vec<String> = failure.phases.iter().map(|p| p.phase.words()).collect();
    listed(&names)
}

fn description(model: &Model, failure: &Failure, explanation: &Explanation) -> String {
    let quantity = match failure.channel {
        Channel::ExecutedVelocity => "the executed velocity",
        Channel::Wrench if failure.axis.is_rotation() => "the torque",
        Channel::Wrench => "the force",
        Channel::ModelVelocity => "the change of the model velocity",
        Channel::Pose => "the step of the pose",
    };
    match explanation {
        Explanation::Late(late) => {
            let ideal = model.actuator.transport_delay_s == 0.0 && model.actuator.lag_s == 0.0;
            let of = if ideal {
                "the command"
            } else {
                "what the model expects"
            };
            let (value, side) = (
                late.value.abs() * 1e3,
                if late.value > 0.0 {
                    "behind"
                } else {
                    "ahead of"
                },
            );
            let (low, high) = if late.value > 0.0 {
                (late.low, late.high)
            } else {
                (-late.high, -late.low)
            };
            format!(
                "the robot is {} ms ({} ms) {side} {of} there",
                number::significant(value, 3),
                range(low * 1e3, high * 1e3, 1)
            )
        }
        Explanation::Factor(factor) => format!(
            "{quantity} is {} times ({}) the predicted there",
            number::significant(factor.value, 3),
            range(factor.low, factor.high, 1)
        ),
        Explanation::Offset(offset) => format!(
            "{quantity} is shifted by {} {} ({}) there",
            number::significant(offset.value, 3),
            failure.channel.unit(failure.axis),
            range(offset.low, offset.high, 1)
        ),
    }
}

/// A 95 % interval: "31.6 to 32.4".
fn range(low: f64, high: f64, digits: usize) -> String {
    let interval = number::interval(low, high, digits);
    interval.trim_matches(['[', ']']).replacen(", ", " to ", 1)
}

/// "a", "a and b", "a, b and c".
fn listed(items: &[String]) -> String {
    match items {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}
