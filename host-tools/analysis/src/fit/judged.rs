//! A fit of all parameters, judged on unseen data: what `fit` prints and writes.

use super::logs::refs;
use super::record;
use super::{Logs, Refitted, Undetermined, refit};
use crate::levels::{Step, error};
use anyhow::Result;
use serde::Serialize;
use softdock_physics::model::{HistoryStep, Model};

/// Least relative change of the error on unseen data that is not taken for chance.
pub(crate) const RISES: f64 = 1e-3;

/// Result of a fit: parameters, the error before and after, and the model to write.
#[derive(Clone, Debug)]
pub struct Judged {
    /// Parameters that the recordings determine.
    pub parameters: Vec<Refitted>,
    /// Parameters that they do not determine.
    pub undetermined: Vec<Undetermined>,
    /// Errors of the model before and after the fit.
    pub steps: [Step; 2],
    /// Model to write: with the fitted values and the history.
    pub after: Model,
    /// Why it should not be written: the error on unseen data rises. None if it does not.
    pub doubt: Option<String>,
    /// Effects each of which can be left out alone without a larger error on unseen data.
    pub needless: Vec<Needless>,
}

/// An effect that does not lower the error on unseen data.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Needless {
    /// Its id.
    pub effect: String,
    /// Error on unseen data without it, all else as fitted.
    pub test_error: f64,
}

/// What `fit --json` prints.
#[derive(Clone, Debug, Serialize)]
pub struct Document<'a> {
    /// What the recordings determine.
    pub parameters: &'a [Refitted],
    /// What they do not.
    pub undetermined: &'a [Undetermined],
    /// The error before and after.
    pub steps: &'a [Step; 2],
    /// Effects without which the error on unseen data is no larger.
    pub needless: &'a [Needless],
    /// The file was changed.
    pub written: bool,
    /// What was or would be changed, as a unified diff.
    pub difference: &'a str,
}

impl Judged {
    /// Fits all parameters; without an unseen recording the end of the others is held back, if it moves enough.
    ///
    /// # Errors
    ///
    /// A recording that cannot be predicted, or a model without anything to fit.
    pub fn fit(model: &Model, logs: &Logs, progress: &dyn Fn(f64, &str)) -> Result<Self> {
        let parts = logs.parted();
        let [train, test] = parts.each_ref().map(|logs| refs(logs));
        let found = refit(model, &train, progress)?;
        let step = |effect: &str, model: &Model| -> Result<Step> {
            Ok(Step {
                effect: effect.to_owned(),
                train_error: error(model, &train)?,
                test_error: logs.on_unseen(error(model, &test)?),
            })
        };
        let steps = [
            step(HistoryStep::NOMINAL, model)?,
            step(HistoryStep::REFIT, &found.after)?,
        ];
        let mut after = found.after;
        let needless = match steps[1].test_error {
            Some(with_all) => needless(&after, with_all, &|model| error(model, &test))?,
            None => Vec::new(),
        };
        for effect in &mut after.effects {
            let name = format!("{}.", effect.id);
            if found.parameters.iter().any(|p| p.name.starts_with(&name)) {
                effect.fitted_on = Some(logs.names.train.clone());
            }
        }
        record::append(&mut after.history, &logs.names, &steps);
        Ok(Self {
            doubt: doubt(&steps, logs.judged_name()),
            parameters: found.parameters,
            undetermined: found.undetermined,
            steps,
            after,
            needless,
        })
    }

    /// What `fit --json` prints.
    pub fn document<'a>(&'a self, written: bool, difference: &'a str) -> Document<'a> {
        Document {
            parameters: &self.parameters,
            undetermined: &self.undetermined,
            steps: &self.steps,
            needless: &self.needless,
            written,
            difference,
        }
    }
}

/// Effects of a model without which the error on unseen data is not larger than with them.
fn needless(
    model: &Model,
    with_all: f64,
    error: &dyn Fn(&Model) -> Result<f64>,
) -> Result<Vec<Needless>> {
    let mut needless = Vec::new();
    for place in 0..model.effects.len() {
        let mut without = model.clone();
        let effect = without.effects.remove(place).id;
        let test_error = error(&without)?;
        if test_error <= with_all * (1.0 + RISES) {
            needless.push(Needless { effect, test_error });
        }
    }
    Ok(needless)
}

fn doubt(steps: &[Step; 2], judged: &str) -> Option<String> {
    let [before, after] = steps.each_ref().map(Step::judged);
    let holds = after <= before * (1.0 + RISES); // not so for NaN
    (!holds).then(|| {
        format!("the fit does not help: the error on {judged} goes from {before:.3} to {after:.3}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_physics::model::EffectModel;

    #[test]
    fn an_effect_without_which_the_error_is_no_larger_is_named() {
        let mut model = Model::default();
        for id in ["guide_coulomb", "guide_viscous"] {
            model.effects.push(EffectModel {
                id: id.to_owned(),
                ..EffectModel::default()
            });
        }
        // Dry friction explains half of the error, viscous friction nothing.
        let error = |model: &Model| {
            let dry = model.effects.iter().any(|e| e.id == "guide_coulomb");
            Ok(if dry { 1.0 } else { 2.0 })
        };
        let found = needless(&model, 1.0, &error).unwrap();
        let ids: Vec<&str> = found.iter().map(|n| n.effect.as_str()).collect();
        assert_eq!(ids, ["guide_viscous"]);
    }

    #[test]
    fn a_fit_that_makes_the_unseen_error_larger_is_doubted() {
        let step = |test_error| Step {
            effect: String::new(),
            train_error: 1.0,
            test_error,
        };
        for (after, doubted) in [(0.9, false), (1.0005, false), (1.1, true), (f64::NAN, true)] {
            let steps = [step(Some(1.0)), step(Some(after))];
            assert_eq!(doubt(&steps, "test.mcap").is_some(), doubted, "{after}");
        }
    }
}
