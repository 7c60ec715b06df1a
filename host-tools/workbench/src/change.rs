//! Changes of a model file: an addition that a job has prepared, its undoing, and the removal of an effect.
//!
//! A file is replaced atomically, and only if it still has the text that the page saw.

use super::files::fingerprint;
use super::models::open;
use super::problem::Problem;
use super::state::{Shared, Workbench, work};
use axum::Json;
use axum::extract::rejection::JsonRejection;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use softdock_physics::model::edit::ModelFile;

/// The answer to a change.
#[derive(Serialize)]
pub(super) struct Changed {
    written: bool,
    /// The difference that was or would be written, as a unified diff.
    difference: String,
    /// Fingerprint of the file as it is now.
    if_match: String,
}

/// Body of a request to write an addition.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Addition {
    /// Id of the job that prepared it.
    job: u64,
    /// Fingerprint of the file that the page saw.
    if_match: String,
    /// Whether an addition is written although it does not help on unseen data.
    #[serde(default)]
    force: bool,
}

pub(super) async fn add(
    State(bench): State<Shared>,
    Path(id): Path<String>,
    addition: Result<Json<Addition>, JsonRejection>,
) -> Result<Json<Changed>, Problem> {
    let Json(addition) = addition?;
    work(move || {
        let prepared = bench.jobs.prepared(addition.job)?;
        if prepared.model_id != id {
            let why = format!("job {} is about `{}`", addition.job, prepared.model_id);
            return Err(Problem::new(StatusCode::UNPROCESSABLE_ENTITY, why));
        }
        if let Some(doubt) = prepared.doubt.filter(|_| !addition.force) {
            return Err(Problem::new(StatusCode::UNPROCESSABLE_ENTITY, doubt));
        }
        let file = unchanged(&bench, &id, &[&addition.if_match, &prepared.if_match])?;
        let edited = file.edited(&prepared.after)?;
        edited.save()?;
        let if_match = fingerprint(edited.text());
        bench.before.keep(&id, &if_match, file.text());
        Ok(Json(Changed {
            written: true,
            difference: edited.difference().replace(&bench.folder.prefix(), ""),
            if_match,
        }))
    })
    .await
}

/// Body of a request to restore the text before the last change by the page.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Undoing {
    /// Fingerprint of the file that the page saw.
    if_match: String,
}

pub(super) async fn undo(
    State(bench): State<Shared>,
    Path(id): Path<String>,
    undoing: Result<Json<Undoing>, JsonRejection>,
) -> Result<Json<Changed>, Problem> {
    let Json(undoing) = undoing?;
    work(move || {
        let file = unchanged(&bench, &id, &[&undoing.if_match])?;
        let Some(text) = bench.before.text(&id, &undoing.if_match) else {
            let why = format!("nothing was written to `{id}` here that could be undone");
            return Err(Problem::new(StatusCode::UNPROCESSABLE_ENTITY, why));
        };
        let edited = file.with_text(text)?;
        edited.save()?;
        Ok(Json(Changed {
            written: true,
            difference: edited.difference().replace(&bench.folder.prefix(), ""),
            if_match: fingerprint(edited.text()),
        }))
    })
    .await
}

/// Body of a request to remove an effect; without `write` the difference is only shown.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Removal {
    /// Fingerprint of the file that the page saw.
    if_match: String,
    write: bool,
}

pub(super) async fn remove(
    State(bench): State<Shared>,
    Path((id, effect)): Path<(String, String)>,
    removal: Result<Json<Removal>, JsonRejection>,
) -> Result<Json<Changed>, Problem> {
    let Json(removal) = removal?;
    work(move || {
        let file = unchanged(&bench, &id, &[&removal.if_match])?;
        let edited = file.without_effect(&effect)?;
        let mut if_match = removal.if_match;
        if removal.write {
            edited.save()?;
            if_match = fingerprint(edited.text());
            bench.before.keep(&id, &if_match, file.text());
        }
        Ok(Json(Changed {
            written: removal.write,
            difference: edited.difference().replace(&bench.folder.prefix(), ""),
            if_match,
        }))
    })
    .await
}

/// Opens a model file. An error if its fingerprint is not that of `seen`.
fn unchanged(bench: &Workbench, id: &str, seen: &[&str]) -> Result<ModelFile, Problem> {
    let file = open(bench, id)?;
    let now = fingerprint(file.text());
    if seen.iter().any(|seen| *seen != now) {
        return Err(Problem::changed(format!(
            "`{id}` was changed by another program in the meantime and is left as it is; look at it again, \
             and diagnose again"
        )));
    }
    Ok(file)
}
