//! Jobs: work that takes longer than a request may. They run one at a time, report their progress, and can be cancelled.

pub(super) mod events;
mod job;
pub(super) mod queue;
mod request;
mod run;
mod search;
pub(super) mod selection;
pub(super) mod simulation;

use super::problem::Problem;
use super::state::{Shared, work};
use axum::Json;
use axum::extract::rejection::JsonRejection;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use request::Request;
use serde_json::{Value, json};

pub(super) async fn start(
    State(bench): State<Shared>,
    request: Result<Json<Request>, JsonRejection>,
) -> Result<(StatusCode, Json<Value>), Problem> {
    let Json(request) = request?;
    work(move || {
        let work = request.prepared(&bench)?;
        let id = bench.jobs.submit(work)?;
        Ok((StatusCode::ACCEPTED, Json(json!({ "id": id }))))
    })
    .await
}

pub(super) async fn cancel(
    State(bench): State<Shared>,
    Path(id): Path<u64>,
) -> Result<StatusCode, Problem> {
    bench.jobs.job(id)?.cancel();
    Ok(StatusCode::NO_CONTENT)
}

pub(super) async fn result(
    State(bench): State<Shared>,
    Path(id): Path<u64>,
) -> Result<Json<Value>, Problem> {
    bench.jobs.job(id)?.result().map(Json)
}
