//! The catalogue of effects: as `softdock effects --json`.

use super::problem::Problem;
use axum::Json;
use axum::extract::Path;
use serde_json::{Value, json};
use softdock_physics::effects::{CATALOGUE, Effect, named};

pub(super) async fn list() -> Json<Value> {
    Json(json!({ "effects": CATALOGUE }))
}

pub(super) async fn one(Path(id): Path<String>) -> Result<Json<&'static Effect>, Problem> {
    let found = named(&id);
    found
        .map(Json)
        .map_err(|why| Problem::not_found(why.to_string()))
}
