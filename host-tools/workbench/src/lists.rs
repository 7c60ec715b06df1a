//! Short answers: the session, the catalogue of effects as `softdock effects --json` prints it, and the scenarios of the
//! folder for runs on the simulated rig.

use super::problem::Problem;
use super::state::{Shared, work};
use axum::Json;
use axum::extract::{Path, State};
use serde::Serialize;
use serde_json::{Value, json};
use softdock_physics::effects::{CATALOGUE, Effect, named};
use std::net::SocketAddr;

/// The answer of `GET /api/session`.
#[derive(Serialize)]
pub(super) struct Session {
    /// Version and git hash of this program.
    version: String,
    /// Path of the folder.
    root: String,
    /// Token that all requests but GET have to contain.
    csrf: String,
    /// Names of the supported functions.
    capabilities: [&'static str; 6],
    /// UDP address on which a board is listened to; None if none is.
    live: Option<SocketAddr>,
}

pub(super) async fn session(State(bench): State<Shared>) -> Json<Session> {
    Json(Session {
        version: softdock_io::identity::text(),
        root: bench.folder.root().display().to_string(),
        csrf: bench.token.clone(),
        live: bench.live.address(),
        capabilities: ["compare", "diagnose", "add", "fit", "run", "live"],
    })
}

pub(super) async fn effects() -> Json<Value> {
    Json(json!({ "effects": CATALOGUE }))
}

pub(super) async fn effect(Path(id): Path<String>) -> Result<Json<&'static Effect>, Problem> {
    let found = named(&id);
    found
        .map(Json)
        .map_err(|why| Problem::not_found(why.to_string()))
}

/// Sections that a scenario has, and no other file has both of.
const SECTIONS: [&str; 2] = ["[rig", "[board"];

/// A scenario in the list.
#[derive(Serialize)]
pub(super) struct Listed {
    id: String,
    /// Time of the last change of the file, seconds since 1970.
    when: u64,
}

pub(super) async fn scenarios(State(bench): State<Shared>) -> Result<Json<Vec<Listed>>, Problem> {
    let listed = move || {
        let found = bench.folder.list("toml").into_iter().filter(|found| {
            let text = std::fs::read_to_string(&found.path).unwrap_or_default();
            let has = |section: &str| text.lines().any(|line| line.starts_with(section));
            SECTIONS.into_iter().all(has)
        });
        let listed = found.map(|found| Listed {
            id: found.id,
            when: found.changed_s,
        });
        Ok(Json(listed.collect()))
    };
    work(listed).await
}
