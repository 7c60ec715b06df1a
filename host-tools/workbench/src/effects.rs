//! The catalogue of effects: as `softdock effects --json`.

use super::problem::Problem;
use axum::Json;
use axum::extract::Path;
use serde_json::{Value, json};
use softdock_analysis::effects::{CATALOGUE, Effect, by_id};

pub(super) async fn list() -> Json<Value> {
    Json(json!({ "effects": CATALOGUE }))
}

pub(super) async fn one(Path(id): Path<String>) -> Result<Json<&'static Effect>, Problem> {
    find(&id).map(Json)
}

fn find(id: &str) -> Result<&'static Effect, Problem> {
    by_id(id).ok_or_else(|| Problem::not_found(format!("there is no effect `{id}`")))
}
