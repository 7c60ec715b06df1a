//! Models of the folder, and what they predict.

use super::files::fingerprint;
use super::problem::Problem;
use super::recordings::blob;
use super::state::{Shared, Workbench, work};
use axum::Json;
use axum::extract::rejection::{JsonRejection, QueryRejection};
use axum::extract::{Path, Query, State};
use axum::response::Response;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use softdock_analysis::fit::record::Fall;
use softdock_physics::model::edit::ModelFile;
use softdock_physics::model::prediction::Prediction;
use softdock_physics::model::{Axis, Channel, Model};

/// Sections by which a TOML file that cannot be read as a model is one all the same.
const SECTIONS: [&str; 4] = ["[actuator", "[[contact", "[noise", "[[effect"];

/// A model as it is listed.
#[derive(Serialize)]
pub(super) struct Listed {
    id: String,
    /// When the file was changed last, seconds since 1970.
    when: u64,
    /// Ids of its effects.
    effects: Vec<String>,
    /// Why it cannot be used.
    error: Option<String>,
}

/// A model file as the page sees it, with what proves that it saw it.
#[derive(Serialize)]
pub(super) struct Seen {
    id: String,
    text: String,
    /// To be sent with a change of the file.
    if_match: String,
    model: Model,
}

/// A model file.
pub(super) fn open(bench: &Workbench, id: &str) -> Result<ModelFile, Problem> {
    let path = bench.folder.file(id, "toml")?;
    ModelFile::open(&path).map_err(|error| named(bench, error))
}

/// An error with the file's name as the page knows it.
pub(super) fn named(bench: &Workbench, error: anyhow::Error) -> Problem {
    Problem::from(error).without(&bench.folder.prefix())
}

pub(super) async fn list(State(bench): State<Shared>) -> Result<Json<Vec<Listed>>, Problem> {
    let listed = move || {
        let found = bench.folder.list("toml").into_iter().filter_map(|found| {
            let text = std::fs::read_to_string(&found.path).ok()?;
            let (effects, error) = match Model::from_toml(&text, &found.id) {
                Ok(model) => (model.effects.into_iter().map(|e| e.id).collect(), None),
                Err(error) if SECTIONS.iter().filter(|s| text.contains(**s)).count() > 1 => {
                    (Vec::new(), Some(format!("{error:#}")))
                }
                Err(_) => return None,
            };
            Some(Listed {
                id: found.id,
                when: found.changed_s,
                effects,
                error,
            })
        });
        Ok(Json(found.collect()))
    };
    work(listed).await
}

pub(super) async fn one(
    State(bench): State<Shared>,
    Path(id): Path<String>,
) -> Result<Json<Seen>, Problem> {
    work(move || {
        let file = open(&bench, &id)?;
        Ok(Json(Seen {
            id,
            if_match: fingerprint(file.text()),
            text: file.text().to_owned(),
            model: file.model().clone(),
        }))
    })
    .await
}

pub(super) async fn history(
    State(bench): State<Shared>,
    Path(id): Path<String>,
) -> Result<Json<Value>, Problem> {
    let of = move || Ok(Json(json!(Fall::of(&open(&bench, &id)?.model().history))));
    work(of).await
}

/// What is compared.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Pair {
    model: String,
    recording: String,
}

pub(super) async fn compare(
    State(bench): State<Shared>,
    pair: Result<Json<Pair>, JsonRejection>,
) -> Result<Json<Value>, Problem> {
    let Json(pair) = pair?;
    work(move || {
        let file = open(&bench, &pair.model)?;
        let recording = bench.files.recording(&bench.folder, &pair.recording)?;
        let comparison = softdock_analysis::compare::compare(file.model(), &recording)?;
        Ok(Json(json!(comparison)))
    })
    .await
}

/// What is drawn.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Drawn {
    recording: String,
    model: String,
    /// The model with what this job has found, instead.
    job: Option<u64>,
    channel: Channel,
    axis: Axis,
}

/// Time, measured, predicted, and the noise to expect of their difference (one standard deviation).
pub(super) async fn prediction(
    State(bench): State<Shared>,
    drawn: Result<Query<Drawn>, QueryRejection>,
) -> Result<Response, Problem> {
    let Query(drawn) = drawn?;
    work(move || {
        let model = match drawn.job {
            Some(job) => bench.jobs.after(job)?,
            None => open(&bench, &drawn.model)?.model().clone(),
        };
        let prediction = bench
            .files
            .prediction(&bench.folder, &model, &drawn.recording)?;
        blob(&columns(&prediction, drawn.channel, drawn.axis))
    })
    .await
}

fn columns(prediction: &Prediction, channel: Channel, axis: Axis) -> [Vec<f64>; 4] {
    let values = prediction.channel(channel);
    let i = axis.index();
    let cycles = 0..prediction.time_s.len();
    [
        prediction.time_s.clone(),
        values.measured.iter().map(|row| row[i]).collect(),
        values
            .predicted
            .iter()
            .map(|row| row.map_or(f64::NAN, |row| row[i]))
            .collect(),
        cycles.map(|n| values.expected_sigma(n, axis)).collect(),
    ]
}
