//! What a job does: a diagnosis, or the fit of one effect. Both prepare an addition to the model file.

use super::job::Job;
use crate::files::fingerprint;
use crate::models::open;
use crate::problem::Problem;
use crate::server::Workbench;
use anyhow::Result;
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use softdock_analysis::diagnose::{Report, diagnose_watched, fit_effect};
use softdock_analysis::fit::Logs;
use softdock_analysis::fit::addition::{Addition, model_after, useless};
use softdock_analysis::fit::record::Names;
use softdock_analysis::model::edit::ModelFile;
use softdock_analysis::model::{Hypothesis, Model};
use std::path::PathBuf;

/// A model and recordings of the folder.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Selection {
    model: String,
    /// To fit on.
    fit: Vec<String>,
    /// Unseen; without them the end of the others is held back.
    #[serde(default)]
    test: Vec<String>,
}

/// A selection with its files.
pub(super) struct Opened {
    file: ModelFile,
    if_match: String,
    /// The recordings, or why nothing can be concluded from them.
    pub(super) logs: Result<Logs>,
}

impl Selection {
    /// # Errors
    ///
    /// An id of no file, or a model that cannot be read.
    pub(super) fn open(&self, bench: &Workbench) -> Result<Opened, Problem> {
        if self.fit.is_empty() {
            return Err(Problem::new(
                StatusCode::UNPROCESSABLE_ENTITY,
                "expected at least one recording to fit on",
            ));
        }
        let paths = |ids: &[String]| -> Result<Vec<PathBuf>, Problem> {
            ids.iter().map(|id| bench.folder.file(id, "mcap")).collect()
        };
        let (file, text) = open(bench, &self.model)?;
        let (fit, test) = (paths(&self.fit)?, paths(&self.test)?);
        let root = bench.folder.prefix();
        let logs = Logs::open(file.model(), &fit, &test)
            .map(|logs| self.named(logs, &root))
            .map_err(|error| anyhow::anyhow!("{}", format!("{error:#}").replace(&root, "")));
        Ok(Opened {
            file,
            if_match: fingerprint(&text),
            logs,
        })
    }

    /// The recordings under the names that they have in the folder.
    fn named(&self, mut logs: Logs, root: &str) -> Logs {
        logs.names = Names::of(&self.fit, &self.test);
        for note in &mut logs.notes {
            *note = note.replace(root, "");
        }
        logs
    }
}

/// What a page asks for.
#[derive(Clone, Debug, Deserialize)]
#[serde(try_from = "Posted")]
pub(crate) enum Request {
    /// What is missing?
    Diagnose(Selection),
    /// One effect of the catalogue or of the model file, or a hypothesis that no file has.
    Add(Wanted),
}

/// The effect that is fitted.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Wanted {
    /// The model and the recordings.
    selection: Selection,
    /// Its id.
    #[serde(default)]
    effect: Option<String>,
    /// A hypothesis instead.
    #[serde(default)]
    hypothesis: Option<Hypothesis>,
}

/// A request as it comes. Its arguments are read when their kind is known: what serde keeps of a number until then is
/// none any more where a crate asks serde_json for all of its digits.
#[derive(Deserialize)]
struct Posted {
    kind: Kind,
    args: Value,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    Diagnose,
    Add,
}

impl TryFrom<Posted> for Request {
    type Error = serde_json::Error;

    fn try_from(Posted { kind, args }: Posted) -> Result<Self, serde_json::Error> {
        Ok(match kind {
            Kind::Diagnose => Self::Diagnose(serde_json::from_value(args)?),
            Kind::Add => Self::Add(serde_json::from_value(args)?),
        })
    }
}

/// A request with its files.
pub(super) struct Task {
    model_id: String,
    /// What paths begin with that a page does not know.
    root: String,
    file: ModelFile,
    if_match: String,
    logs: Logs,
    /// The model, with a hypothesis of its own if there is one.
    model: Model,
    /// The one effect that is fitted.
    effect: Option<String>,
}

/// An addition to a model file.
#[derive(Clone, Debug)]
pub(crate) struct Prepared {
    /// The file.
    pub(crate) model_id: String,
    /// Of the file that it was made for.
    pub(crate) if_match: String,
    /// What the file will say.
    pub(crate) after: Model,
    /// Why it should not be written.
    pub(crate) doubt: Option<String>,
}

/// What `add --json` prints, and what the page needs beside it.
#[derive(Serialize)]
struct Document<'a> {
    #[serde(flatten)]
    addition: Addition<'a>,
    if_match: &'a str,
    doubt: &'a Option<String>,
}

impl Task {
    /// Opens the files of a request.
    ///
    /// # Errors
    ///
    /// Files that cannot be read, an unknown effect, a hypothesis that does not fit, or recordings from
    /// which nothing can be concluded.
    pub(super) fn new(bench: &Workbench, request: Request) -> Result<Self, Problem> {
        let (selection, effect, hypothesis) = match request {
            Request::Diagnose(selection) => (selection, None, None),
            Request::Add(Wanted {
                selection,
                effect,
                hypothesis,
            }) => (selection, effect, hypothesis),
        };
        let opened = selection.open(bench)?;
        let mut model = opened.file.model().clone();
        let own = hypothesis.map(|own| {
            let id = own.id.clone();
            model
                .hypotheses
                .retain(|other| other.id != id || other == &own);
            if !model.hypotheses.contains(&own) {
                model.hypotheses.push(own);
            }
            id
        });
        model.validate().map_err(anyhow::Error::from)?;
        let effect = own.or(effect);
        if let Some(id) = &effect {
            model.effect(id).map_err(anyhow::Error::from)?;
        }
        Ok(Self {
            model_id: selection.model,
            root: bench.folder.prefix(),
            file: opened.file,
            if_match: opened.if_match,
            logs: opened.logs?,
            model,
            effect,
        })
    }

    /// Does it: the document of the result, and what can be written.
    pub(super) fn run(self, job: &Job) -> Result<(Value, Option<Prepared>)> {
        let (report, doubt) = self.found(job)?;
        let diagnosis = &report.diagnosis;
        let after = model_after(&self.model, &report, &self.logs.names);
        let adds = !diagnosis.effects.is_empty();
        let difference = if adds {
            self.file
                .edited(&after)?
                .difference()
                .replace(&self.root, "")
        } else {
            String::new()
        };
        let doubt = doubt.or_else(|| useless(&diagnosis.steps, self.logs.unseen()));
        let document = json!(Document {
            addition: Addition {
                diagnosis,
                written: false,
                difference: &difference,
            },
            if_match: &self.if_match,
            doubt: &doubt,
        });
        let prepared = adds.then_some(Prepared {
            model_id: self.model_id,
            if_match: self.if_match,
            after,
            doubt,
        });
        Ok((document, prepared))
    }

    /// What is found, and why it should not be believed.
    fn found(&self, job: &Job) -> Result<(Report, Option<String>)> {
        let (fit, test) = (&self.logs.fitted()[..], &self.logs.unseen_ones()[..]);
        let progress =
            |share: f64, what: &str| job.tell("stage", json!({"share": share, "what": what}));
        let Some(id) = &self.effect else {
            let tried = |trial: &_| job.tell("candidate", json!(trial));
            let mut report = diagnose_watched(&self.model, fit, test, &progress, &tried)?;
            report
                .diagnosis
                .notes
                .splice(0..0, self.logs.notes.iter().cloned());
            return Ok((report, None));
        };
        progress(0.1, &format!("fitting {id}"));
        match fit_effect(&self.model, id, fit, test, false) {
            Ok(report) => Ok((report, None)),
            // It is shown all the same: who asks for it wants to see why not.
            Err(why) => match fit_effect(&self.model, id, fit, test, true) {
                Ok(report) => Ok((report, Some(format!("{why:#}")))),
                Err(_) => Err(why),
            },
        }
    }
}
