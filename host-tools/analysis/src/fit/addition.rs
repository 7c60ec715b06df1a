//! What was fitted or named goes into the model.

use super::record::{self, Names};
use crate::diagnose::{Diagnosis, Report, Step};
use serde::Serialize;
use softdock_physics::model::edit::rounded;
use softdock_physics::model::{EffectModel, Model};

/// What `add` says: the diagnosis, and what becomes of the model file.
#[derive(Clone, Debug, Serialize)]
pub struct Addition<'a> {
    /// What was fitted, or named.
    #[serde(flatten)]
    pub diagnosis: &'a Diagnosis,
    /// The file was changed.
    pub written: bool,
    /// What was or would be changed, as a unified diff.
    pub difference: &'a str,
}

/// The model with what was named, in the digits of a model file, and the history.
pub fn model_after(model: &Model, report: &Report, names: &Names) -> Model {
    let mut after = model.clone();
    for id in &report.diagnosis.effects {
        let fitted = report.after.effects.iter().find(|effect| effect.id == *id);
        after.effects.extend(fitted.map(|effect| EffectModel {
            fitted_on: Some(names.train.clone()),
            ..in_digits(effect)
        }));
    }
    record::append(&mut after.history, names, &report.diagnosis.steps);
    after
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

/// Why a step is not worth writing: the error on unseen data does not fall.
pub fn useless(steps: &[Step], unseen: &str) -> Option<String> {
    steps.windows(2).find_map(|pair| {
        let (before, after) = (pair[0].test_error?, pair[1].test_error?);
        let falls = after < before; // not so for NaN
        (!falls).then(|| {
            format!(
                "`{}` does not help: the error on {unseen}, which the fit has not seen, goes from \
                 {before:.3} to {after:.3} (on the data of the fit from {:.3} to {:.3})",
                pair[1].effect, pair[0].train_error, pair[1].train_error
            )
        })
    })
}
