//! What a model has already, fitted anew together with what is added: a weight that was found without an offset has taken a
//! part of it.

use crate::diagnose::{Estimate, Parameters, Report, fit_effects};
use crate::fit::judged::RISES;
use crate::fit::logs::refs;
use crate::fit::{Logs, Parameter, ParameterId, Refitted, refit_those};
use crate::levels::{BeforeAfter, ChannelLevels, error};
use anyhow::Result;
use softdock_io::recording::Recording;
use softdock_physics::model::prediction::predict;
use softdock_physics::model::{EffectModel, Model};
use std::collections::BTreeMap;

/// A model whose effects were fitted together, and their parameters.
type Fitted = (Model, Parameters);

/// Fits the effects that the model had anew, together with what was fitted or named beside them. The report says what that
/// gives, if it foretells unseen data better; what moved is returned. The nominal parameters stay.
///
/// # Errors
///
/// A recording that cannot be predicted.
pub fn refit_beside(model: &Model, report: &mut Report, logs: &Logs) -> Result<Vec<Refitted>> {
    let named = &report.diagnosis.effects;
    if named.is_empty() || !model.effects.iter().any(was_fitted) {
        return Ok(Vec::new());
    }
    let parts = logs.parted();
    let [train, test] = parts.each_ref().map(|logs| refs(logs));
    let (after, parameters) = match searched(model, named, logs)? {
        Some(searched) => searched,
        None => refitted(&report.after, &train)?,
    };
    let (before, now) = (error(&report.after, &test)?, error(&after, &test)?);
    let steps = &mut report.diagnosis.steps;
    let Some(last) = steps.last_mut().filter(|_| now < before * (1.0 - RISES)) else {
        return Ok(Vec::new());
    };
    (last.train_error, last.test_error) = (error(&after, &train)?, Some(now));
    let predictions = test.iter().map(|log| predict(&after, log));
    report.diagnosis.residual_rms_sigma = BeforeAfter {
        after: ChannelLevels::of(&predictions.collect::<Result<Vec<_>>>()?),
        ..report.diagnosis.residual_rms_sigma
    };
    for (id, all) in &mut report.diagnosis.parameters {
        all.extend(parameters.get(id).cloned().unwrap_or_default());
    }
    report.after = after;
    Ok(moved(model, &parameters))
}

/// Whether an effect was fitted, and not written by hand.
fn was_fitted(effect: &EffectModel) -> bool {
    !effect.interval_95.is_empty()
}

/// A search among all of them, which chooses their forms anew; None if it does not find them all.
fn searched(model: &Model, named: &[String], logs: &Logs) -> Result<Option<Fitted>> {
    let (fitted, others) = model.effects.iter().cloned().partition(was_fitted);
    let (fitted, others): (Vec<EffectModel>, Vec<EffectModel>) = (fitted, others);
    let bare = Model {
        effects: others,
        ..model.clone()
    };
    let ids = fitted.iter().map(|effect| &effect.id).chain(named);
    let ids: Vec<String> = ids.cloned().collect();
    let found = fit_effects(&bare, &ids, &logs.fitted(), &logs.unseen_ones())?;
    let is_found = |id: &String| found.diagnosis.effects.contains(id);
    if !ids.iter().all(is_found) {
        return Ok(None);
    }
    Ok(Some((found.after, found.diagnosis.parameters)))
}

/// All of them in the form that they have, moved until they fit.
fn refitted(after: &Model, train: &[&Recording]) -> Result<Fitted> {
    let of_effect = |parameter: &Parameter| matches!(parameter.id, ParameterId::Effect(..));
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

/// What of a model's effects has another value now.
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
