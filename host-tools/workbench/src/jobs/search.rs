//! A diagnosis, the fit of some effects, or the fit of all parameters. Each prepares a change of the model file.

use super::job::{Job, Prepared};
use super::selection::Selection;
use crate::problem::Problem;
use crate::state::Workbench;
use anyhow::Result;
use axum::http::StatusCode;
use serde::Serialize;
use serde_json::{Value, json};
use softdock_analysis::add::{Addition, add_effects, model_after, refit_beside, useless};
use softdock_analysis::diagnose::{Report, diagnose_watched};
use softdock_analysis::fit::judged::Judged;
use softdock_analysis::fit::{Logs, Refitted};
use softdock_physics::model::edit::ModelFile;
use softdock_physics::model::{Hypothesis, Model};

/// A question about a model and recordings.
pub(super) enum Question {
    /// Which effects are missing?
    Diagnose,
    /// What are the values of all parameters together?
    Fit,
    /// What do these effects explain together, with a hypothesis if it is one that is in no file?
    Effects(Vec<String>, Option<Hypothesis>),
}

impl Question {
    /// The question about effects or a hypothesis; without either the question which effects are missing.
    ///
    /// # Errors
    ///
    /// Both effects and a hypothesis are given.
    pub(super) fn effects(
        effects: Option<Vec<String>>,
        hypothesis: Option<Hypothesis>,
    ) -> Result<Self, Problem> {
        match (effects, hypothesis) {
            (Some(_), Some(_)) => Err(Problem::new(
                StatusCode::UNPROCESSABLE_ENTITY,
                "expected `effect` or `hypothesis`, received both; a hypothesis that the model file has is an effect like others",
            )),
            (None, Some(own)) => Ok(Self::Effects(vec![own.id.clone()], Some(own))),
            (Some(ids), None) => Ok(Self::Effects(ids, None)),
            (None, None) => Ok(Self::Diagnose),
        }
    }
}

/// What a search has found.
struct SearchResult {
    report: Report,
    /// Effects of the model whose parameters changed by the joint fit.
    moved: Vec<Refitted>,
    /// Why the result should not be believed; None if nothing is against it.
    doubt: Option<String>,
}

/// A question and its files.
pub(super) struct Search {
    model_id: String,
    /// Prefix of all paths, which a page does not see.
    root: String,
    file: ModelFile,
    if_match: String,
    logs: Logs,
    /// The model, with the hypothesis if there is one.
    model: Model,
    question: Question,
}

/// The document that the command prints, with additions for the page.
#[derive(Serialize)]
struct Document<'a, T> {
    #[serde(flatten)]
    printed: T,
    if_match: &'a str,
    doubt: &'a Option<String>,
}

impl Search {
    pub(super) fn new(
        bench: &Workbench,
        selection: Selection,
        question: Question,
    ) -> Result<Self, Problem> {
        let opened = selection.open(bench)?;
        let mut model = opened.file.model().clone();
        if let Question::Effects(_, Some(own)) = &question {
            model
                .hypotheses
                .retain(|other| other.id != own.id || other == own);
            if !model.hypotheses.contains(own) {
                model.hypotheses.push(own.clone());
            }
        }
        model.validate().map_err(anyhow::Error::from)?;
        if let Question::Effects(ids, _) = &question {
            for id in ids {
                model.effect(id).map_err(anyhow::Error::from)?;
            }
        }
        Ok(Self {
            model_id: selection.model,
            root: bench.folder.prefix(),
            file: opened.file,
            if_match: opened.if_match,
            logs: opened.logs?,
            model,
            question,
        })
    }

    /// Answers the question. Returns the document of the result, and the change that can be written.
    pub(super) fn run(self, job: &Job) -> Result<(Value, Option<Prepared>)> {
        if let Question::Fit = self.question {
            return self.fit(job);
        }
        let SearchResult {
            report,
            moved,
            doubt,
        } = self.search(job)?;
        let diagnosis = &report.diagnosis;
        let after = model_after(&self.model, &report, &self.logs.names);
        let adds = !diagnosis.effects.is_empty();
        let difference = if adds {
            self.difference(&after)?
        } else {
            String::new()
        };
        let doubt = doubt.or_else(|| useless(&diagnosis.steps, self.logs.judged_name()));
        let document = self.document(
            Addition {
                diagnosis,
                moved: &moved,
                written: false,
                difference: &difference,
            },
            &doubt,
        );
        Ok((document, adds.then(|| self.prepared(after, doubt))))
    }

    fn fit(self, job: &Job) -> Result<(Value, Option<Prepared>)> {
        let progress = |share: f64, what: &str| stage(job, share, what);
        let fit = Judged::fit(&self.model, &self.logs, &progress)?;
        let difference = self.difference(&fit.after)?;
        let document = self.document(fit.document(false, &difference), &fit.doubt);
        Ok((document, Some(self.prepared(fit.after, fit.doubt))))
    }

    fn difference(&self, after: &Model) -> Result<String> {
        let edited = self.file.edited(after)?;
        Ok(edited.difference().replace(&self.root, ""))
    }

    fn document(&self, printed: impl Serialize, doubt: &Option<String>) -> Value {
        json!(Document {
            printed,
            if_match: &self.if_match,
            doubt,
        })
    }

    fn prepared(self, after: Model, doubt: Option<String>) -> Prepared {
        Prepared {
            model_id: self.model_id,
            if_match: self.if_match,
            after,
            doubt,
        }
    }

    /// Searches for effects, or fits those that the question names.
    fn search(&self, job: &Job) -> Result<SearchResult> {
        let progress = |share: f64, what: &str| stage(job, share, what);
        let Question::Effects(ids, _) = &self.question else {
            let (fit, test) = (&self.logs.fitted()[..], &self.logs.unseen_ones()[..]);
            let tried = |trial: &_| job.tell("candidate", json!(trial));
            let mut report = diagnose_watched(&self.model, fit, test, &progress, &tried)?;
            let notes = self.logs.notes.iter().cloned();
            report.diagnosis.notes.splice(0..0, notes);
            let moved = refit_beside(&self.model, &mut report, &self.logs)?;
            return Ok(SearchResult {
                report,
                moved,
                doubt: None,
            });
        };
        progress(0.1, &format!("fitting {}", ids.join(" and ")));
        let added = |forced| add_effects(&self.model, ids, &self.logs, forced);
        let (doubt, (report, moved)) = match added(false) {
            Ok(added) => (None, added),
            // A single effect is fitted all the same, as the user wants to see why it does not help. Of several none is
            // forced.
            Err(why) if ids.len() > 1 => return Err(why),
            Err(why) => match added(true) {
                Ok(added) => (Some(format!("{why:#}")), added),
                Err(_) => return Err(why),
            },
        };
        Ok(SearchResult {
            report,
            moved,
            doubt,
        })
    }
}

fn stage(job: &Job, share: f64, what: &str) {
    job.tell("stage", json!({"share": share, "what": what}));
}
