//! Adds fitted or named effects to the model, and fits the effects that it had anew beside them.

mod together;

pub use together::refit_beside;

use crate::compare::sentence::listed;
use crate::diagnose::{Diagnosis, Ranked, Report, ensure_lacks, fit_effect, fit_effects};
use crate::fit::record::{self, Names};
use crate::fit::{Logs, Refitted};
use crate::levels::Step;
use anyhow::{Result, ensure};
use serde::Serialize;
use softdock_physics::model::edit::rounded;
use softdock_physics::model::{EffectModel, Model};

/// What `add` says: the diagnosis, and what becomes of the model file.
#[derive(Clone, Debug, Serialize)]
pub struct Addition<'a> {
    /// Effects that were fitted or named.
    #[serde(flatten)]
    pub diagnosis: &'a Diagnosis,
    /// Parameters that the model had before, fitted anew.
    #[serde(skip_serializing_if = "<[Refitted]>::is_empty")]
    pub moved: &'a [Refitted],
    /// The file was changed.
    pub written: bool,
    /// What was or would be changed, as a unified diff.
    pub difference: &'a str,
}

/// Fits one effect. The effects that the model had are fitted anew beside it, as together they may show what one alone does not.
/// `forced`: also if the evidence is too small. Returns the parameters of these other effects that changed, too.
///
/// # Errors
///
/// Those of [`fit_effect`].
pub fn add_effect(
    model: &Model,
    id: &str,
    logs: &Logs,
    forced: bool,
) -> Result<(Report, Vec<Refitted>)> {
    ensure_lacks(model, id)?;
    let fit = |forced| fit_effect(model, id, &logs.fitted(), &logs.unseen_ones(), forced);
    let alone = match fit(forced) {
        Ok(mut report) => {
            let moved = refit_beside(model, &mut report, logs)?;
            return Ok((report, moved));
        }
        Err(alone) => alone,
    };
    if let Ok(mut report) = fit(true) {
        let moved = refit_beside(model, &mut report, logs)?;
        if !moved.is_empty() && together::is_sure(&report, id) {
            return Ok((report, moved));
        }
    }
    together::found_beside(model, &[id.to_owned()], logs, false)?.ok_or(alone)
}

/// Fits one effect as [`add_effect`] does, or several together in the forms that suit the logs. The effects that the model had
/// are fitted anew beside them. Returns the parameters of these that changed, too.
///
/// # Errors
///
/// Those of [`add_effect`] and [`fit_effects`]; no effect, or one twice. Of several that are not `forced`: one whose evidence
/// beside the others is too small and without which the error on unseen data is as small.
pub fn add_effects(
    model: &Model,
    ids: &[String],
    logs: &Logs,
    forced: bool,
) -> Result<(Report, Vec<Refitted>)> {
    ensure!(
        !ids.is_empty(),
        "expected at least one effect, received none"
    );
    for (n, id) in ids.iter().enumerate() {
        ensure!(
            !ids[..n].contains(id),
            "expected each effect once, received `{id}` twice"
        );
    }
    match ids {
        [id] => add_effect(model, id, logs, forced),
        several => add_together(model, several, logs, forced),
    }
}

fn add_together(
    model: &Model,
    ids: &[String],
    logs: &Logs,
    forced: bool,
) -> Result<(Report, Vec<Refitted>)> {
    let mut report = fit_effects(model, ids, &logs.fitted(), &logs.unseen_ones(), true)?;
    let is_found = |id: &&String| report.diagnosis.effects.contains(id);
    if !ids.iter().all(|id| is_found(&id))
        && let Some(all) = together::found_beside(model, ids, logs, forced)?
    {
        return Ok(all);
    }
    let (found, missing): (Vec<&String>, Vec<&String>) = ids.iter().partition(is_found);
    let quoted = |ids: &[&String]| {
        let quoted: Vec<String> = ids.iter().map(|id| format!("`{id}`")).collect();
        listed(&quoted)
    };
    ensure!(
        !found.is_empty(),
        "nothing was added: these logs pay for the parameters of none of {}; `softdock diagnose` says what they show{}",
        quoted(&missing),
        refused(&report, &missing)
    );
    ensure!(
        missing.is_empty(),
        "nothing was added: beside {} these logs do not pay for the parameters of {}; leave out what does not pay, or take \
         logs that excite it (softdock effects show EFFECT), or --force, which adds all of them{}",
        quoted(&found),
        quoted(&missing),
        refused(&report, &missing)
    );
    let moved = refit_beside(model, &mut report, logs)?;
    Ok((report, moved))
}

/// Reasons why effects are refused that no hypothesis could contain, as the end of a sentence. Empty where their evidence alone
/// is too small.
fn refused(report: &Report, missing: &[&String]) -> String {
    let why = |id: &String| {
        let ranked = report.diagnosis.ranked.iter();
        let tried: Vec<&Ranked> = ranked.filter(|one| one.effects.contains(id)).collect();
        let fewest = tried.iter().min_by_key(|one| one.effects.len())?;
        let all = tried.iter().all(|one| one.refused.is_some());
        let reason = fewest.refused.as_ref().filter(|_| all)?;
        Some(format!(
            "; with {} it is refused: {reason}",
            fewest.effects.join(" + ")
        ))
    };
    missing.iter().filter_map(|id| why(id)).collect()
}

/// The model with the named effects, rounded as in a model file, and the history.
pub fn model_after(model: &Model, report: &Report, names: &Names) -> Model {
    let mut after = model.clone();
    let diagnosis = &report.diagnosis;
    let of_test = diagnosis.of_all_logs.as_ref().and(names.test.as_ref());
    let of = match of_test.filter(|_| diagnosis.unseen) {
        Some(test) => format!("{}, {test}", names.train),
        None => names.train.clone(),
    };
    let found = |id: &str| report.after.effects.iter().find(|effect| effect.id == id);
    for effect in &mut after.effects {
        match found(&effect.id) {
            Some(refitted) if refitted.parameters != effect.parameters => {
                *effect = fitted_on(refitted, &of);
            }
            _ => {}
        }
    }
    let named = report.diagnosis.effects.iter().filter_map(|id| found(id));
    after
        .effects
        .extend(named.map(|effect| fitted_on(effect, &of)));
    record::append(&mut after.history, names, &report.diagnosis.steps);
    after
}

fn fitted_on(effect: &EffectModel, recordings: &str) -> EffectModel {
    EffectModel {
        fitted_on: Some(recordings.to_owned()),
        ..in_digits(effect)
    }
}

fn in_digits(effect: &EffectModel) -> EffectModel {
    let mut effect = effect.clone();
    effect
        .parameters
        .values_mut()
        .for_each(|v| *v = rounded(*v));
    effect
        .interval_95
        .retain(|_, ends| ends.iter().all(|end| end.is_finite()));
    effect
        .interval_95
        .values_mut()
        .for_each(|ends| *ends = ends.map(rounded));
    effect
}

/// Why an addition should not be written: the error on what is `judged` (unseen data where there is some) does not fall. All
/// steps are judged together: a friction that one log shows in one direction alone may stand for half of a weight, and only both
/// together lower the error. None if the error falls.
pub fn useless(steps: &[Step], judged: &str) -> Option<String> {
    let (first, last) = (steps.first()?, steps.last()?);
    let (before, after) = (first.judged(), last.judged());
    let falls = after < before; // not so for NaN
    let added: Vec<String> = steps[1..]
        .iter()
        .map(|s| format!("`{}`", s.effect))
        .collect();
    (!falls && !added.is_empty()).then(|| {
        let (names, verb) = (
            added.join(", "),
            if added.len() == 1 { "does" } else { "do" },
        );
        let of_fit = match last.test_error {
            Some(_) => format!(
                " (on the data of the fit from {:.3} to {:.3})",
                first.train_error, last.train_error
            ),
            None => String::new(),
        };
        format!(
            "{names} {verb} not help: the error on {judged} goes from {before:.3} to {after:.3}{of_fit}"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(effect: &str, test_error: f64) -> Step {
        Step {
            effect: effect.to_owned(),
            train_error: test_error,
            test_error: Some(test_error),
        }
    }

    /// A weight and a friction that pull against each other on the unseen log.
    #[test]
    fn what_is_added_together_is_judged_together() {
        let steps = [
            step("", 2.9),
            step("guide_coulomb", 5.1),
            step("bearing_gravity", 0.3),
        ];
        assert_eq!(useless(&steps, "test.mcap"), None);
        let said = useless(&steps[..2], "test.mcap").unwrap();
        assert!(
            said.contains("`guide_coulomb` does not help") && said.contains("5.100"),
            "{said}"
        );
        let worse = [
            step("", 0.2),
            step("guide_coulomb", 0.1),
            step("bearing_gravity", 0.3),
        ];
        assert!(
            useless(&worse, "test.mcap")
                .unwrap()
                .contains("`guide_coulomb`, `bearing_gravity` do not help")
        );
    }
}
