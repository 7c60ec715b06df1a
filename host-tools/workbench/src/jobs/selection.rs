//! A model and recordings of the folder that a page selects, and whether a diagnosis is possible with them: what prevents it,
//! and what is lacking.

use crate::files::fingerprint;
use crate::models::open;
use crate::problem::Problem;
use crate::state::{Shared, Workbench, work};
use anyhow::Result;
use axum::Json;
use axum::extract::State;
use axum::extract::rejection::JsonRejection;
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use softdock_analysis::fit::Logs;
use softdock_physics::model::edit::ModelFile;
use std::path::PathBuf;

/// A model and recordings of the folder.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Selection {
    pub(super) model: String,
    /// Ids of the recordings to fit on.
    fit: Vec<String>,
    /// Ids of the unseen recordings; without them the end of the others is held back.
    #[serde(default)]
    test: Vec<String>,
}

/// A selection with its files opened.
pub(super) struct Opened {
    pub(super) file: ModelFile,
    pub(super) if_match: String,
    /// The recordings, or why nothing can be concluded from them.
    pub(super) logs: Result<Logs>,
}

impl Selection {
    /// # Errors
    ///
    /// An id names no file, or the model cannot be read.
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
        let file = open(bench, &self.model)?;
        let (fit, test) = (paths(&self.fit)?, paths(&self.test)?);
        let root = bench.folder.prefix();
        let logs = Logs::open(file.model(), &fit, &test)
            .map(|logs| self.named(logs, &root))
            .map_err(|error| anyhow::anyhow!("{}", format!("{error:#}").replace(&root, "")));
        Ok(Opened {
            if_match: fingerprint(file.text()),
            file,
            logs,
        })
    }

    /// The recordings, named by their ids.
    fn named(&self, logs: Logs, root: &str) -> Logs {
        let mut logs = logs.named(&self.fit, &self.test);
        for note in &mut logs.notes {
            *note = note.replace(root, "");
        }
        logs
    }
}

/// The answer to a check: a diagnosis is possible if nothing prevents it.
#[derive(Serialize)]
pub(crate) struct Check {
    ready: bool,
    /// Why a diagnosis is not possible; None if it is.
    against: Option<String>,
    /// What a diagnosis of these recordings cannot determine, and what they make suspect.
    lacking: Vec<String>,
}

pub(crate) async fn check(
    State(bench): State<Shared>,
    selection: Result<Json<Selection>, JsonRejection>,
) -> Result<Json<Check>, Problem> {
    let Json(selection) = selection?;
    work(move || {
        let opened = selection.open(&bench)?;
        Ok(Json(match opened.logs {
            Ok(logs) => Check {
                ready: true,
                against: None,
                lacking: logs.notes,
            },
            Err(error) => Check {
                ready: false,
                against: Some(format!("{error:#}")),
                lacking: Vec::new(),
            },
        }))
    })
    .await
}
