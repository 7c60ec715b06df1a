//! Scenarios of the folder, for runs on the simulated rig.

use super::problem::Problem;
use super::state::{Shared, work};
use axum::Json;
use axum::extract::State;
use serde::Serialize;

/// Sections of which a scenario has both, and no other file.
const SECTIONS: [&str; 2] = ["[rig", "[board"];

/// A scenario as it is listed.
#[derive(Serialize)]
pub(super) struct Listed {
    id: String,
    /// When the file was changed last, seconds since 1970.
    when: u64,
}

pub(super) async fn list(State(bench): State<Shared>) -> Result<Json<Vec<Listed>>, Problem> {
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
