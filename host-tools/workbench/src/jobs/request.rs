//! Requests for jobs.

use super::job::JobFn;
use super::run::Run;
use super::search::{Question, Search};
use super::selection::Selection;
use super::simulation::Simulation;
use crate::problem::Problem;
use crate::state::Shared;
use serde::Deserialize;
use serde_json::Value;
use softdock_physics::model::Hypothesis;

/// A request for a job.
#[derive(Clone, Debug, Deserialize)]
#[serde(try_from = "Posted")]
pub(crate) enum Request {
    /// A diagnosis: which effects are missing?
    Diagnose(Selection),
    /// A fit of all parameters together.
    Fit(Selection),
    /// A fit of effects of the catalogue or of the model file, or of a hypothesis that is in no file.
    Add(Wanted),
    /// A run of a scenario on the simulated rig.
    Run(Simulation),
}

/// The effects to fit, together if there are several.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Wanted {
    /// The model and the recordings.
    selection: Selection,
    /// Ids of the effects.
    #[serde(default)]
    effect: Option<Ids>,
    /// A hypothesis, in place of effects.
    #[serde(default)]
    hypothesis: Option<Hypothesis>,
}

/// An id, or a list of them.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged, expecting = "expected the id of an effect or a list of ids")]
pub(super) enum Ids {
    One(String),
    Several(Vec<String>),
}

impl From<Ids> for Vec<String> {
    fn from(ids: Ids) -> Self {
        match ids {
            Ids::One(id) => vec![id],
            Ids::Several(ids) => ids,
        }
    }
}

/// A request as it is sent. Its arguments stay a JSON value until their kind is known: serde's own buffering breaks numbers
/// if any crate enables `arbitrary_precision` of serde_json.
#[derive(Deserialize)]
struct Posted {
    kind: Kind,
    args: Value,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    Diagnose,
    Fit,
    Add,
    Run,
}

impl TryFrom<Posted> for Request {
    type Error = serde_json::Error;

    fn try_from(Posted { kind, args }: Posted) -> Result<Self, serde_json::Error> {
        Ok(match kind {
            Kind::Diagnose => Self::Diagnose(serde_json::from_value(args)?),
            Kind::Fit => Self::Fit(serde_json::from_value(args)?),
            Kind::Add => Self::Add(serde_json::from_value(args)?),
            Kind::Run => Self::Run(serde_json::from_value(args)?),
        })
    }
}

impl Request {
    /// Opens the files of the request and returns the work.
    ///
    /// # Errors
    ///
    /// A file cannot be read, an effect is unknown, a hypothesis does not fit, nothing can be concluded from the recordings,
    /// or the recording to write exists.
    pub(super) fn prepared(self, bench: &Shared) -> Result<JobFn, Problem> {
        let (selection, question) = match self {
            Self::Run(wish) => {
                let run = Run::new(bench, wish)?;
                return Ok(Box::new(move |job| Ok((run.run(job)?, None))));
            }
            Self::Diagnose(selection) => (selection, Question::Diagnose),
            Self::Fit(selection) => (selection, Question::Fit),
            Self::Add(wanted) => (
                wanted.selection,
                Question::effects(wanted.effect.map(Vec::from), wanted.hypothesis)?,
            ),
        };
        let search = Search::new(bench, selection, question)?;
        Ok(Box::new(move |job| search.run(job)))
    }
}
