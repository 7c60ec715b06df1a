//! Models of the folder, and their predictions.

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

/// Sections that mark a TOML file as a model, although it cannot be read as one.
const SECTIONS: [&str; 4] = ["[actuator", "[[contact", "[noise", "[[effect"];

/// A model in the list.
#[derive(Serialize)]
pub(super) struct Listed {
    id: String,
    /// Time of the last change of the file, seconds since 1970.
    when: u64,
    /// Ids of its effects.
    effects: Vec<String>,
    /// Why the model cannot be used; None if it can.
    error: Option<String>,
}

/// A model file for the page, with its fingerprint.
#[derive(Serialize)]
pub(super) struct ModelDocument {
    id: String,
    text: String,
    /// Fingerprint, to be sent with a change of the file.
    if_match: String,
    model: Model,
}

/// Opens a model file.
pub(super) fn open(bench: &Workbench, id: &str) -> Result<ModelFile, Problem> {
    let path = bench.folder.file(id, "toml")?;
    ModelFile::open(&path).map_err(|error| named(bench, error))
}

/// An error in which the file has the name that the page knows.
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
) -> Result<Json<ModelDocument>, Problem> {
    work(move || {
        let file = open(&bench, &id)?;
        Ok(Json(ModelDocument {
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

/// Query of a comparison.
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

/// Query of a plot of one axis.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Drawn {
    recording: String,
    model: String,
    /// Id of a job: if given, the model is that with the job's change.
    job: Option<u64>,
    channel: Channel,
    axis: Axis,
}

/// Time, measured and predicted values, and the expected standard deviation of their difference.
pub(super) async fn prediction(
    State(bench): State<Shared>,
    drawn: Result<Query<Drawn>, QueryRejection>,
) -> Result<Response, Problem> {
    let Query(drawn) = drawn?;
    work(move || {
        let model = match drawn.job {
            Some(job) => bench.jobs.model_after(job)?,
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
