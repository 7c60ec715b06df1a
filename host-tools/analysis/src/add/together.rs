//! Fits the effects that a model has anew, together with those that are added: a weight that was found without an offset has
//! absorbed a part of it.

use crate::compare::sentence::listed;
use crate::diagnose::{Estimate, Parameters, Report, evidence, fit_effect, fit_effects};
use crate::fit::judged::RISES;
use crate::fit::logs::refs;
use crate::fit::{Logs, Parameter, ParameterId, Refitted, refit_those};
use crate::levels::{BeforeAfter, Step, error};
use anyhow::{Result, bail};
use softdock_io::recording::Recording;
use softdock_physics::model::prediction::{Prediction, predict};
use softdock_physics::model::{EffectModel, HistoryStep, Model, allowed_parameters};
use std::collections::BTreeMap;

/// A model whose effects were fitted together, and their parameters.
type Fitted = (Model, Parameters);

/// Fits the effects of a model anew, together with those that were fitted or named beside them, or several of the latter
/// together. Two ways are tried: least squares in the forms that the effects have, and, if the model had fitted effects, a search
/// that chooses the forms. If one of them foretells unseen data better than the report, it replaces the report's answer. Returns
/// the parameters that the model had and that changed. Nominal parameters stay.
///
/// # Errors
///
/// A recording that cannot be predicted.
pub fn refit_beside(model: &Model, report: &mut Report, logs: &Logs) -> Result<Vec<Refitted>> {
    let named = &report.diagnosis.effects;
    let has_fitted = model.effects.iter().any(EffectModel::was_fitted);
    if named.is_empty() || (named.len() < 2 && !has_fitted) {
        return Ok(Vec::new());
    }
    let parts = logs.parted();
    let [train, test] = parts.each_ref().map(|logs| refs(logs));
    let mut ways = vec![refitted(&report.after, model.effects.len(), &train)?];
    if has_fitted {
        let (found, finds_all) = search(model, named, logs)?;
        // A fit that has used the rows of TEST cannot be compared by its error on them.
        if finds_all && found.diagnosis.of_all_logs.is_none() {
            ways.push((found.after, found.diagnosis.parameters));
        }
    }
    let errors = ways.iter().map(|way| error(&way.0, &test));
    let errors = errors.collect::<Result<Vec<f64>>>()?;
    let least = ways.into_iter().zip(errors);
    let Some(((after, parameters), now)) = least.min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Ok(Vec::new());
    };
    let before = error(&report.after, &test)?;
    let falls = now < before * (1.0 - RISES); // not so for NaN
    if !falls {
        return Ok(Vec::new());
    }
    // Errors are those of the whole logs: a diagnosis may have used a stretch of each.
    let done = report.diagnosis.steps.iter().skip(1);
    let ids: Vec<String> = done.map(|step| step.effect.clone()).collect();
    report.diagnosis.steps = steps(model, &ids, &after, [&train, &test], logs)?;
    let [before, now] = [model, &after].map(|model| predictions(model, &test));
    report.diagnosis.residual_rms_sigma = BeforeAfter::of(&before?, &now?);
    for (id, all) in &mut report.diagnosis.parameters {
        all.extend(parameters.get(id).cloned().unwrap_or_default());
    }
    report.diagnosis.is_of_fit();
    report.after = after;
    Ok(moved(model, &parameters))
}

/// Fits effects that are refused while the others are held together with these: a viscous friction that was fitted alone may have
/// absorbed all of a dry one, and more. A search chooses the forms; effects that it does not find get their parameters by least
/// squares in their plain forms. The result counts only if the error on unseen data falls by as much as a named effect needs,
/// compared with the model before and with the others fitted anew without them; otherwise None. `forced`: it always counts.
///
/// # Errors
///
/// A recording that cannot be predicted; of forced effects one of which these logs determine no parameter.
pub(super) fn found_beside(
    model: &Model,
    ids: &[String],
    logs: &Logs,
    forced: bool,
) -> Result<Option<(Report, Vec<Refitted>)>> {
    let new = model.effects.len();
    if ids.len() < 2 && !model.effects.iter().any(EffectModel::was_fitted) {
        return Ok(None);
    }
    let parts = logs.parted();
    let [train, test] = parts.each_ref().map(|logs| refs(logs));
    let (mut report, finds_all) = search(model, ids, logs)?;
    let missing = |id: &&String| finds_all || !report.diagnosis.effects.contains(id);
    let missing: Vec<String> = ids.iter().filter(missing).cloned().collect();
    if !finds_all {
        let start = with_all(model, ids, &report.after, forced.then_some(logs))?;
        let (after, parameters) = refitted(&start, new, &train)?;
        let mut idle = missing.iter().filter(|id| !parameters.contains_key(*id));
        if let Some(idle) = idle.next().filter(|_| forced) {
            bail!(
                "nothing was added: these logs determine no parameter of `{idle}` beside the others, which would stand in the model \
                 without doing anything; leave it out, or see where it acts (softdock effects show {idle})"
            );
        }
        report.after = after;
        report.diagnosis.is_of_fit();
        report.diagnosis.parameters = parameters;
        report.diagnosis.sentence = by_least_squares(ids);
    }
    let mut others = report.after.clone();
    others.effects.retain(|one| !missing.contains(&one.id));
    let without = error(&refitted(&others, new, &train)?.0, &test)?;
    let steps = steps(model, ids, &report.after, [&train, &test], logs)?;
    let errors = [steps.first(), steps.last()].map(|step| step.map(Step::judged));
    let [before, now] = errors.map(|error| error.unwrap_or(f64::NAN));
    let falls = now * evidence::RISES < before.min(without); // not so for NaN
    let is_shown = falls && ids.iter().all(|id| is_sure(&report, id));
    if !is_shown && !forced {
        return Ok(None);
    }
    let [before, now] = [model, &report.after].map(|model| predictions(model, &test));
    let (before, now) = (before?, now?);
    let moved = moved(model, &report.diagnosis.parameters);
    let diagnosis = &mut report.diagnosis;
    diagnosis.effects = ids.to_vec();
    diagnosis
        .parameters
        .retain(|effect, _| ids.contains(effect));
    diagnosis.steps = steps;
    diagnosis.residual_rms_sigma = BeforeAfter::of(&before, &now);
    if let Some((before, now)) = before.into_iter().zip(now).next() {
        (report.before_prediction, report.after_prediction) = (before, now);
    }
    Ok(Some((report, moved)))
}

fn by_least_squares(ids: &[String]) -> String {
    let quoted: Vec<String> = ids.iter().map(|id| format!("`{id}`")).collect();
    let are = if ids.len() < 2 { "is" } else { "are" };
    format!(
        "{} {are} fitted by least squares, together with what the model has.",
        listed(&quoted)
    )
}

/// Errors of all logs after each added effect. Every step has the parameters of the joint fit.
fn steps(
    model: &Model,
    ids: &[String],
    after: &Model,
    [train, test]: [&[&Recording]; 2],
    logs: &Logs,
) -> Result<Vec<Step>> {
    let step = |count: usize| -> Result<Step> {
        let mut with = after.clone();
        let later = ids.get(count..).unwrap_or_default();
        with.effects.retain(|one| !later.contains(&one.id));
        let (with, effect) = match count.checked_sub(1).and_then(|last| ids.get(last)) {
            Some(last) => (&with, last.as_str()),
            None => (model, HistoryStep::NOMINAL),
        };
        Ok(Step {
            effect: effect.to_owned(),
            train_error: error(with, train)?,
            test_error: logs.on_unseen(error(with, test)?),
        })
    };
    (0..=ids.len()).map(step).collect()
}

fn predictions(model: &Model, logs: &[&Recording]) -> Result<Vec<Prediction>> {
    logs.iter().map(|log| predict(model, log)).collect()
}

/// Whether the interval of at least one of its parameters excludes 0.
pub(super) fn is_sure(report: &Report, id: &str) -> bool {
    let amounts = report.diagnosis.parameters.get(id);
    amounts.is_some_and(|all| all.values().any(|one| one.low * one.high > 0.0))
}

/// The model with the effects `ids` in the forms and values that a search has found. An effect that was not found is fitted to
/// `logs` beside the ones before it, if there are `logs`; where that fails, it starts in its plain form with default values, in
/// which it does nothing.
fn with_all(model: &Model, ids: &[String], found: &Model, logs: Option<&Logs>) -> Result<Model> {
    let mut with = model.clone();
    for id in ids {
        let of = |model: &Model| model.effects.iter().find(|one| one.id == *id).cloned();
        let alone = || {
            let logs = logs?;
            let report = fit_effect(&with, id, &logs.fitted(), &logs.unseen_ones(), true);
            of(&report.ok()?.after)
        };
        let known = of(found).or_else(alone);
        with.effects
            .push(known.map_or_else(|| plain(model, id), Ok)?);
    }
    Ok(with)
}

fn plain(model: &Model, id: &str) -> Result<EffectModel> {
    let parameters = allowed_parameters(model, model.effect(id)?).into_iter();
    let parameters = parameters.map(|allowed| (allowed.name.to_owned(), allowed.default));
    Ok(EffectModel {
        id: id.to_owned(),
        parameters: parameters.collect(),
        ..EffectModel::default()
    })
}

/// Searches all fitted and named effects together, which chooses their forms anew. Also returns whether all of them are found.
fn search(model: &Model, named: &[String], logs: &Logs) -> Result<(Report, bool)> {
    let (fitted, others) = model
        .effects
        .iter()
        .cloned()
        .partition(EffectModel::was_fitted);
    let (fitted, others): (Vec<EffectModel>, Vec<EffectModel>) = (fitted, others);
    let bare = Model {
        effects: others,
        ..model.clone()
    };
    let ids = fitted.iter().map(|effect| &effect.id).chain(named);
    let ids: Vec<String> = ids.cloned().collect();
    let found = fit_effects(&bare, &ids, &logs.fitted(), &logs.unseen_ones(), false)?;
    let is_found = |id: &String| found.diagnosis.effects.contains(id);
    let finds_all = ids.iter().all(is_found);
    Ok((found, finds_all))
}

/// Least-squares fit of all effects that were fitted before, and of those with indices from `new` on, in the forms that they
/// have. Effects that were written by hand stay.
fn refitted(after: &Model, new: usize, train: &[&Recording]) -> Result<Fitted> {
    let is_open = |place: usize| place >= new || after.effects[place].was_fitted();
    if !(0..after.effects.len()).any(is_open) {
        return Ok((after.clone(), Parameters::new()));
    }
    let of_effect = |parameter: &Parameter| match parameter.id {
        ParameterId::Effect(place, _) => is_open(place),
        _ => false,
    };
    let found = refit_those(after, train, &of_effect, &|_, _| {})?;
    let mut parameters = Parameters::new();
    for one in found.parameters {
        let Some((effect, name)) = one.name.split_once('.') else {
            continue;
        };
        let estimate = Estimate {
            value: one.value,
            unit: one.unit.to_owned(),
            low: one.low,
            high: one.high,
        };
        let all = parameters.entry(effect.to_owned()).or_default();
        all.insert(name.to_owned(), estimate);
    }
    Ok((found.after, parameters))
}

/// Parameters of the model's effects whose values have changed.
fn moved(model: &Model, now: &Parameters) -> Vec<Refitted> {
    let nothing = BTreeMap::new();
    let effects = model.effects.iter().flat_map(|effect| {
        let all = now.get(&effect.id).unwrap_or(&nothing);
        all.iter().filter_map(|(name, estimate)| {
            let before = *effect.parameters.get(name)?;
            (before != estimate.value).then(|| Refitted {
                name: format!("{}.{name}", effect.id),
                unit: estimate.unit.clone(),
                before,
                value: estimate.value,
                low: estimate.low,
                high: estimate.high,
                prior_share: 0.0,
                kept: false,
                note: None,
            })
        })
    });
    effects.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Effects of a bearing have other names and ranges.
    #[test]
    fn a_plain_form_is_one_that_a_model_file_may_hold() {
        for axis in ["x", "rx"] {
            let text = format!("[rig]\nactive_axes = [\"{axis}\"]\n");
            let model = Model::from_toml(&text, "model.toml").unwrap();
            for id in ["guide_coulomb", "guide_stribeck", "guide_hysteresis"] {
                let values = plain(&model, id).unwrap().parameters;
                for allowed in allowed_parameters(&model, model.effect(id).unwrap()) {
                    let value = values[allowed.name];
                    let range = allowed.low..=allowed.high;
                    assert!(range.contains(&value), "{id}: {allowed:?} is {value}");
                }
            }
        }
    }
}
