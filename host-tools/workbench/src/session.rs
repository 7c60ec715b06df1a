//! What the page has to know first.

use super::state::Shared;
use axum::Json;
use axum::extract::State;
use serde::Serialize;
use std::net::SocketAddr;

/// The answer of `GET /api/session`.
#[derive(Serialize)]
pub(super) struct Session {
    /// Firmware, version and git hash of this program.
    version: String,
    /// The folder.
    root: String,
    /// Token of everything that is not GET.
    csrf: String,
    /// What can be asked for.
    capabilities: [&'static str; 6],
    /// UDP address on which a board is listened to.
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
