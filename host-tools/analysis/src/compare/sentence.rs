//! Where the model fails, in words.

use super::Source;
use super::errors::AxisError;
use super::explain::Explanation;
use super::failure::Failure;
use super::noise::NoiseLevel;
use super::regime::{Regime, quantity};
use super::series::ROUND_OFF_SIGMA;
use softdock_physics::model::{Channel, Model, WrenchMeaning};
use softdock_report::number;

/// Further failures with at least this share of the error are mentioned.
const MENTIONED_SHARE: f64 = 0.1;
/// Most further failures that are mentioned.
const MOST_MENTIONED: usize = 3;
/// If the named phases take at least this share of the time, the error has no place in time.
const EVERYWHERE: f64 = 0.6;
/// If they take this share, they are the whole recording.
const ALL: f64 = 0.995;

/// From this ratio on the noise of the motion makes another unit of the expected noise than that of the reading alone is.
const ANOTHER_UNIT: f64 = 1.2;
/// Beside a regime, phases with less than this share of the error say nothing new.
const PLACE_SHARE: f64 = 0.5;

/// The whole finding. `strays`: see [`FreeSimulation::strays`](super::FreeSimulation::strays).
pub(super) fn whole(errors: &[AxisError], failures: &[Failure], strays: bool) -> String {
    let Some(worst) = failures.first() else {
        return at_noise(errors, strays);
    };
    let mut text = worst.sentence.clone();
    let others: Vec<String> = failures
        .iter()
        .skip(1)
        .filter(|f| f.share >= MENTIONED_SHARE)
        .take(MOST_MENTIONED)
        .map(|f| format!("{} {} ({})", f.channel, f.axis, short(f)))
        .collect();
    if !others.is_empty() {
        text += &format!(" It also fails in {}.", listed(&others));
    }
    text
}

/// One axis in which the model fails: how large the error is, what it follows, and when it shows.
pub(super) fn of_failure(
    source: &Source<'_>,
    errors: &[AxisError],
    failure: &Failure,
    noise: &[NoiseLevel],
) -> String {
    let (channel, axis, model) = (failure.channel, failure.axis, source.model);
    let mut found: Vec<String> = Vec::new();
    found.extend(failure.regime.as_ref().map(Regime::clause));
    found.extend(place(failure));
    let says_offset = failure.regime.as_ref().is_some_and(Regime::says_offset);
    // A factor says nothing about a wrench that is predicted as zero.
    let is_nothing = channel == Channel::Wrench && model.sensor.wrench == WrenchMeaning::Free;
    let says_nothing = |e: &&Explanation| is_nothing && matches!(e, Explanation::Factor(_));
    let explanation = failure.explanation.as_ref().filter(|e| !says_nothing(e));
    let new = explanation.filter(|e| !(says_offset && matches!(e, Explanation::Offset(_))));
    found.extend(new.map(|explanation| description(model, failure, explanation)));
    found.extend(coarse(failure, noise));
    let fails = match source.is_within_motion(channel) {
        true => format!("Position and velocity of the log contradict each other in {axis}"),
        false => format!("The model fails in {channel} {axis}"),
    };
    format!(
        "{fails}: {}. {}.",
        size(failure, errors),
        capitalised(&found.join("; "))
    )
}

/// How large the error is.
fn size(failure: &Failure, errors: &[AxisError]) -> String {
    let of = |e: &&AxisError| e.channel == failure.channel && e.axis == failure.axis;
    errors.iter().find(of).map_or(String::new(), |error| {
        let rms = quantity(error.summary().rms, failure.channel.unit(failure.axis));
        format!("the error is {rms} rms, {}", times_the_noise(error, 2))
    })
}

/// How many times the expected noise an error is, and the noise of the reading alone where that is another unit.
fn times_the_noise(error: &AxisError, digits: usize) -> String {
    let (expected, of_reading) = (error.overall().rms(), error.summary().rms_sigma);
    let [times, alone] = [expected, of_reading].map(|times| number::significant(times, digits));
    match of_reading > ANOTHER_UNIT * expected {
        true => format!(
            "{times} times the expected noise ({alone} times [noise] alone, the unit of a diagnosis: the noise of the motion is not in \
             that)"
        ),
        false => format!("{times} times the expected noise"),
    }
}

/// The resolution of the measurement, if it is coarser than its noise.
fn coarse(failure: &Failure, noise: &[NoiseLevel]) -> Option<String> {
    let of = |n: &&NoiseLevel| n.channel == failure.channel && n.axis == failure.axis;
    let step = noise.iter().find(of)?.step?;
    let unit = failure.channel.unit(failure.axis);
    Some(format!(
        "the measurement comes in steps of {}, which alone make {} rms",
        quantity(step, unit),
        quantity(step / 12.0_f64.sqrt(), unit)
    ))
}

fn short(failure: &Failure) -> String {
    let regime = failure.regime.as_ref().map(Regime::short);
    let offset = match failure.explanation {
        Some(Explanation::Offset(offset)) => Some(format!(
            "shifted by {}",
            quantity(offset.value, failure.channel.unit(failure.axis))
        )),
        _ => None,
    };
    regime.or(offset).unwrap_or_else(|| phase_names(failure))
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(char::to_uppercase);
    first.into_iter().flatten().chain(letters).collect()
}

fn at_noise(errors: &[AxisError], strays: bool) -> String {
    if errors.iter().all(|e| e.overall().count == 0) {
        return "Nothing in this recording can be predicted: it holds no measured motion and no \
                sensor sample."
            .to_owned();
    }
    let is_lost = |e: &&AxisError| e.channel == Channel::Wrench && e.overall().count == 0;
    if let Some(lost) = errors.iter().find(is_lost) {
        return format!(
            "Nothing of {} {} is predicted: what the model has of it comes later than the stretches of this log are long.",
            lost.channel, lost.axis
        );
    }
    let worst = errors
        .iter()
        .max_by(|a, b| a.overall().rms().total_cmp(&b.overall().rms()));
    if worst.is_some_and(|e| e.overall().rms() < ROUND_OFF_SIGMA) {
        return "Model and recording do not differ at all, not even by noise: the recording holds no wrench and no \
                commanded velocity, which would test the model, or it was simulated without noise."
            .to_owned();
    }
    let largest = worst.map_or(String::new(), |e| {
        let (channel, axis) = (e.channel, e.axis);
        format!(
            ", the largest in {channel} {axis} with {}",
            times_the_noise(e, 3)
        )
    });
    if strays {
        return format!(
            "Instant by instant every error is at the noise{largest}; simulated forward the model is off by more than a tenth of the motion. \
             Either the noise adds up to that, or something is missing that is smaller than the noise of an instant: `softdock \
             diagnose` weighs all instants together."
        );
    }
    format!("The model agrees with the recording: every error is at the noise{largest}.")
}

/// Phases and times of an error. None if a regime says more: the error is everywhere, or these phases hold too little of it.
fn place(failure: &Failure) -> Option<String> {
    let share: f64 = failure.phases.iter().map(|p| p.share).sum();
    let percent = number::percent(share, 0);
    let (from, to) = (failure.worst.from_s, failure.worst.to_s);
    let names = phase_names(failure);
    if failure.time_share >= EVERYWHERE {
        let spread = match failure.time_share > ALL {
            true => "the error is spread over the whole recording".to_owned(),
            false => format!(
                "the error is spread over the recording, {percent} of it in {names}, which take {} of \
                 the time",
                number::percent(failure.time_share, 0)
            ),
        };
        return failure.regime.is_none().then_some(spread);
    }
    if failure.regime.is_some() && share < PLACE_SHARE {
        return None;
    }
    let whose = if failure.regime.is_some() {
        ""
    } else {
        "of the error beyond the noise "
    };
    let stands = format!("{percent} {whose}stands in {names}");
    Some(if failure.windows == 1 {
        format!("{stands} ({from:.3} s to {to:.3} s)")
    } else {
        let windows = failure.windows;
        format!("{stands} (in {windows} windows, most from {from:.3} s to {to:.3} s)")
    })
}

fn phase_names(failure: &Failure) -> String {
    let names: Vec<String> = failure.phases.iter().map(|p| p.phase.words()).collect();
    listed(&names)
}

fn description(model: &Model, failure: &Failure, explanation: &Explanation) -> String {
    let subject = match failure.channel {
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
            "{subject} is {} times ({}) the predicted there",
            number::significant(factor.value, 3),
            range(factor.low, factor.high, 1)
        ),
        Explanation::Offset(offset) => format!(
            "{subject} is shifted by {} {} ({}) there",
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
pub(crate) fn listed(items: &[String]) -> String {
    match items {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}
