//! The diagnosis in a sentence or two.

use crate::compare::TOLERATED_NOISE;
use crate::compare::sentence::listed;
use crate::diagnose::finding::{Diagnosis, TOGETHER, Verdict};
use crate::diagnose::noise::structure::Structure;
use crate::diagnose::wrench::left::RemainingStructure;
use softdock_report::number;

/// Share of the error from which the sentence mentions what is left.
const TOLD: f64 = 0.01;
/// Percentage from which all of the error is said to be left.
const ALL: f64 = 99.5;

/// Says what is missing, how far the error falls, and what is uncertain. `untestable` is the sentence for logs that cannot be
/// tested.
pub(crate) fn of(diagnosis: &Diagnosis, left: &[RemainingStructure], untestable: &str) -> String {
    match diagnosis.verdict {
        Verdict::Named => named(diagnosis),
        Verdict::NothingMissing => nothing_missing(diagnosis),
        Verdict::Unexplained => unexplained(diagnosis, left),
        Verdict::LogsDisagree => logs_disagree(diagnosis),
        Verdict::NotTestable => untestable.to_owned(),
    }
}

/// The sentence for logs of two rigs, preceded by the settings that differ.
pub(crate) fn of_two_rigs(settings: &str, sentence: &str) -> String {
    format!(
        "{settings}: they are of two rigs, and what differs may show as an error of the model. {sentence}"
    )
}

/// Title of an effect, or of several that are one rival together.
fn title(id: &str) -> String {
    if id.contains(TOGETHER) {
        let each: Vec<String> = id.split(TOGETHER).map(title).collect();
        return format!("{} together", listed(&each));
    }
    softdock_physics::effects::by_id(id).map_or_else(
        || format!("your own hypothesis `{id}`"),
        |effect| format!("{} ({id})", effect.title),
    )
}

fn nothing_missing(diagnosis: &Diagnosis) -> String {
    let level = diagnosis.residual_rms_sigma.after.rms();
    let remainder = &diagnosis.remainder;
    if remainder.share > 0.0 {
        return format!(
            "Nothing more of the catalogue stands out: of what the model explains {} is left with structure ({}), \
             {level:.2} in units of the model file's noise.",
            small_share(remainder.share),
            remainder.follows
        );
    }
    if level > TOLERATED_NOISE {
        return format!(
            "Nothing is missing that these logs show: what remains ({level:.2} in units of the model file's noise) is more than its \
             noise, and is not told from noise of another size or colour; `softdock compare` says where it stands."
        );
    }
    format!(
        "Nothing is missing: what remains ({level:.2} in units of the model file's noise) is noise."
    )
}

fn named(diagnosis: &Diagnosis) -> String {
    let names: Vec<String> = diagnosis.effects.iter().map(|id| title(id)).collect();
    let (before, after) = (
        diagnosis.residual_rms_sigma.before.rms(),
        diagnosis.residual_rms_sigma.after.rms(),
    );
    let data = match (diagnosis.unseen, diagnosis.of_all_logs.is_some()) {
        _ if diagnosis.in_sample => "the data of the fit",
        (true, true) => "the data of the test, which took part in the fit,",
        (true, false) => "unseen data",
        (false, true) => "the end of the log, which took part in the fit,",
        (false, false) => "the end of the log, which the fit has not seen,",
    };
    let with = if names.len() > 1 { "them" } else { "it" };
    let [from, to] = [before, after].map(|level| format!("{level:.2}"));
    let goes = match from == to {
        true => format!("stays at {to}"),
        false if after < before => format!("falls from {from} to {to}"),
        false => format!("goes from {from} to {to}"),
    };
    let mut text = format!("Missing: {}. With {with} the error on ", listed(&names));
    text.push_str(&match unconfirmed(diagnosis).filter(|_| from == to) {
        Some([first, last]) => format!(
            "the data of the fit falls from {first} to {last} in units of the model file's noise; on {data} it stays at {to}, which \
             does not confirm {with}."
        ),
        None => format!(
            "{data} {goes} in units of the model file's noise{}.",
            in_units(diagnosis)
        ),
    });
    text.push_str(&left_over(diagnosis, false));
    for rival in diagnosis.runner_up.iter().chain(&diagnosis.further_ties) {
        let others: Vec<String> = rival.not_told_from().map(title).collect();
        if !others.is_empty() {
            let others = others.join(", nor from ");
            text.push_str(&format!(
                " This log does not tell {} from {others}.",
                title(&rival.of)
            ));
        }
    }
    text
}

/// The errors before and after in N or N·m, in brackets; empty where another channel has an error, or the axes of the wrench differ
/// in noise.
fn in_units(diagnosis: &Diagnosis) -> String {
    let Some((errors, unit)) = diagnosis.residual_rms_sigma.of_wrench_alone() else {
        return String::new();
    };
    let [from, to] = errors.map(|error| number::significant(error, 3));
    match from == to {
        true => format!(" ({to} {unit} rms)"),
        false => format!(" (from {from} to {to} {unit} rms)"),
    }
}

/// Error on the data of the fit, before and after, as text. `None` if it does not fall, or there are no data besides.
fn unconfirmed(diagnosis: &Diagnosis) -> Option<[String; 2]> {
    let [first, .., last] = diagnosis.steps.as_slice() else {
        return None;
    };
    let is_of_fit = !diagnosis.in_sample && diagnosis.of_all_logs.is_none();
    let both = [first, last].map(|step| format!("{:.2}", step.train_error));
    (is_of_fit && last.train_error < first.train_error && both[0] != both[1]).then_some(both)
}

fn logs_disagree(diagnosis: &Diagnosis) -> String {
    let names: Vec<String> = diagnosis.disagreeing.iter().map(|id| title(id)).collect();
    format!(
        "The logs disagree: the amounts of what looks like {} differ from log to log. The logs are not of one machine in \
         one state, or the machine depends on something that the catalogue does not know (a frequency, a temperature).",
        listed(&names)
    )
}

fn unexplained(diagnosis: &Diagnosis, left: &[RemainingStructure]) -> String {
    let mut places: Vec<String> = left
        .iter()
        .filter(|l| l.any())
        .flat_map(RemainingStructure::structured)
        .map(|(channel, axis, each)| {
            let channel = channel.name().replace('_', " ");
            let words = each.last().map(Structure::words).unwrap_or_default();
            format!("{channel} {axis}: {words}")
        })
        .collect();
    places.dedup();
    let mut text = format!(
        "Something is missing that no effect of the catalogue accounts for. It shows in {}.",
        places.join("; ")
    );
    if !diagnosis.looks_like.is_empty() {
        let names: Vec<String> = diagnosis.looks_like.iter().map(|id| title(id)).collect();
        text.push_str(&format!(
            " In part it looks like {}.",
            names.join(", or like ")
        ));
    }
    let follows = diagnosis.remainder.follows.replace('_', " ");
    let is_told = follows
        .split("; ")
        .all(|one| places.iter().any(|place| place == one));
    text.push_str(&left_over(diagnosis, is_told));
    text
}

/// A share in percent, or an upper limit if it is tiny.
pub(crate) fn small_share(share: f64) -> String {
    /// Least share that is told in digits.
    const LEAST: f64 = 1e-4;
    match share < LEAST {
        true => format!("less than {} %", 100.0 * LEAST),
        false => format!("{} %", number::significant(100.0 * share, 2)),
    }
}

/// How much is left, and, unless that is told already, what it follows; empty if it is little. If nothing explains more than an offset does, all is left, and
/// the share is not mentioned.
fn left_over(diagnosis: &Diagnosis, is_told: bool) -> String {
    let remainder = &diagnosis.remainder;
    if remainder.share <= TOLD {
        return String::new();
    }
    let percent = 100.0 * remainder.share;
    if percent >= ALL {
        return match is_told {
            true => String::new(),
            false => format!(" What shows: {}.", remainder.follows),
        };
    }
    // Effects may be present, but too much is left for a name.
    let is_too_much = diagnosis.verdict == Verdict::Unexplained && !diagnosis.looks_like.is_empty();
    let limit = match is_too_much && remainder.share > remainder.allowed {
        true => format!(
            ", where effects are named up to {:.0} %",
            100.0 * remainder.allowed
        ),
        false => String::new(),
    };
    let follows = match is_told {
        true => String::new(),
        false => format!(" ({})", remainder.follows),
    };
    format!(" {percent:.0} % is left with structure{follows}{limit}.")
}
