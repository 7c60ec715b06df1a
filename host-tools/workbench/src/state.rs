//! State that all handlers share.

use super::access::Reach;
use super::before::Before;
use super::connections::ActiveRequest;
use super::files::Files;
use super::folder::Folder;
use super::jobs::queue::Jobs;
use super::jobs::simulation::Simulator;
use super::live::Live;
use super::problem::Problem;
use axum::http::StatusCode;
use std::sync::Arc;

/// State of the workbench.
pub(super) struct Workbench {
    pub(super) folder: Folder,
    pub(super) files: Files,
    pub(super) jobs: Jobs,
    pub(super) before: Before,
    pub(super) live: Live,
    pub(super) simulator: Box<Simulator>,
    pub(super) reach: Reach,
    /// Token that only the page knows.
    pub(super) token: String,
    pub(super) port: u16,
}

/// The state as handlers get it.
pub(super) type Shared = Arc<Workbench>;

/// Runs work that keeps a core busy on a thread of its own, so that other requests are still answered.
pub(super) async fn work<T: Send + 'static>(
    does: impl FnOnce() -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    let _request = ActiveRequest::begin();
    let ended = tokio::task::spawn_blocking(does).await;
    ended.unwrap_or_else(|_| {
        Err(Problem::new(
            StatusCode::INTERNAL_SERVER_ERROR,
            "the question could not be answered: this is an error of softdock",
        ))
    })
}
