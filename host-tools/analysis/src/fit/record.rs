//! The history in a model file: how the error fell, step by step.

use crate::levels::Step;
use serde::Serialize;
use softdock_physics::model::HistoryStep;
use softdock_physics::model::edit::rounded;

/// Relative change of the error since the last step that shows an edit by hand.
const EDITED: f64 = 0.01;

/// Names of the recordings of a step, as the history keeps them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Names {
    /// The recording of the fit.
    pub train: String,
    /// The recording that the fit has not seen, if there is one.
    pub test: Option<String>,
}

/// How the error fell: the steps of a history. Every key is written, also one without a value.
#[derive(Clone, Debug, Serialize)]
pub struct Fall<'a> {
    /// The steps, in their order.
    pub steps: Vec<FallStep<'a>>,
}

/// One step of a history.
#[derive(Clone, Debug, Serialize)]
pub struct FallStep<'a> {
    effect: &'a str,
    train: &'a str,
    train_error: f64,
    test: Option<&'a str>,
    test_error: Option<f64>,
}

impl<'a> Fall<'a> {
    /// The steps of a history.
    pub fn of(history: &'a [HistoryStep]) -> Self {
        let steps = history.iter().map(|s| FallStep {
            effect: &s.effect,
            train: &s.train,
            train_error: s.train_error,
            test: s.test.as_deref(),
            test_error: s.test_error,
        });
        Self {
            steps: steps.collect(),
        }
    }
}

/// Appends steps to a history; the first of them is the model before anything was done.
///
/// That one is only written where it is news: at the beginning, for other recordings than those of
/// the last step, or when somebody has changed the model by hand since.
pub fn append(history: &mut Vec<HistoryStep>, names: &Names, steps: &[Step]) {
    let Some((before, done)) = steps.split_first() else {
        return;
    };
    let step = |effect: &str, step: &Step| HistoryStep {
        effect: effect.to_owned(),
        train: names.train.clone(),
        train_error: rounded(step.train_error),
        test: names.test.clone(),
        test_error: step.test_error.map(rounded),
    };
    let same_logs = |s: &&HistoryStep| s.train == names.train && s.test == names.test;
    match history.last().filter(same_logs) {
        None => history.push(step(HistoryStep::NOMINAL, before)),
        Some(last) if (last.train_error / before.train_error - 1.0).abs() > EDITED => {
            history.push(step(HistoryStep::EDITED, before));
        }
        Some(_) => {}
    }
    history.extend(done.iter().map(|s| step(&s.effect, s)));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(effect: &str, train_error: f64) -> Step {
        Step {
            effect: effect.to_owned(),
            train_error,
            test_error: Some(train_error + 0.5),
        }
    }

    fn names(train: &str) -> Names {
        Names {
            train: train.to_owned(),
            test: None,
        }
    }

    #[test]
    fn the_state_before_is_written_only_where_it_is_news() {
        let mut history = Vec::new();
        let said = |history: &[HistoryStep]| -> Vec<String> {
            history.iter().map(|s| s.effect.clone()).collect()
        };
        append(
            &mut history,
            &names("a"),
            &[step("nominal", 9.0), step("backlash", 4.0)],
        );
        append(
            &mut history,
            &names("a"),
            &[step("nominal", 4.001), step("refit", 3.0)],
        );
        assert_eq!(said(&history), ["nominal", "backlash", "refit"]);
        append(
            &mut history,
            &names("a"),
            &[step("nominal", 2.5), step("refit", 2.0)],
        );
        assert_eq!(said(&history)[3..], ["edited", "refit"]);
        append(
            &mut history,
            &names("b"),
            &[step("nominal", 2.0), step("refit", 1.5)],
        );
        assert_eq!(said(&history)[5..], ["nominal", "refit"]);
    }
}
