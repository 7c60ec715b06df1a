//! Work that takes longer than an answer may: it is done one at a time, tells how far it is, and can be
//! ended.

mod check;
mod events;
mod job;
mod search;
mod selection;
mod simulation;
mod task;

pub(super) use check::check;
pub(super) use events::events;
pub use simulation::{Simulation, Simulator};

use super::problem::Problem;
use super::server::{Shared, work};
use axum::Json;
use axum::extract::rejection::JsonRejection;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use job::Job;
use serde_json::{Value, json};
use softdock_physics::model::Model;
use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use task::{Prepared, Request, Task};

/// Jobs that may wait.
const QUEUE: usize = 8;
/// Jobs whose results are kept.
const KEPT: usize = 32;

/// All jobs, in their order.
pub(super) struct Jobs {
    queue: SyncSender<(Arc<Job>, Task)>,
    list: Mutex<List>,
}

#[derive(Default)]
struct List {
    jobs: VecDeque<(u64, Arc<Job>)>,
    last: u64,
}

impl Jobs {
    /// Starts the thread that does them.
    pub(super) fn start() -> Self {
        let (queue, waiting) = sync_channel(QUEUE);
        thread::spawn(move || does(&waiting));
        Self {
            queue,
            list: Mutex::default(),
        }
    }

    fn list(&self) -> MutexGuard<'_, List> {
        self.list.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn submit(&self, task: Task) -> Result<u64, Problem> {
        let job = Arc::new(Job::default());
        let mut list = self.list();
        self.queue
            .try_send((job.clone(), task))
            .map_err(|error| match error {
                TrySendError::Full(_) => Problem::new(
                    StatusCode::TOO_MANY_REQUESTS,
                    format!(
                        "{QUEUE} jobs are waiting already; end one of them, or try again later"
                    ),
                ),
                TrySendError::Disconnected(_) => Problem::new(
                    StatusCode::INTERNAL_SERVER_ERROR,
                    "no jobs are done any more: start the workbench again",
                ),
            })?;
        list.last += 1;
        let id = list.last;
        list.jobs.push_back((id, job));
        while list.jobs.len() > KEPT && list.jobs.front().is_some_and(|(_, job)| job.has_ended()) {
            list.jobs.pop_front();
        }
        Ok(id)
    }

    fn job(&self, id: u64) -> Result<Arc<Job>, Problem> {
        let list = self.list();
        let found = list.jobs.iter().find(|(own, _)| *own == id);
        let missing = || Problem::not_found(format!("there is no job {id} (any more)"));
        found.map(|(_, job)| job.clone()).ok_or_else(missing)
    }

    /// What a job has prepared for the model file.
    pub(super) fn prepared(&self, id: u64) -> Result<Prepared, Problem> {
        let none = || Problem::not_found(format!("job {id} has found nothing to add"));
        self.job(id)?.prepared().ok_or_else(none)
    }

    /// The model with what a job has found.
    pub(super) fn after(&self, id: u64) -> Result<Model, Problem> {
        self.prepared(id).map(|prepared| prepared.after)
    }
}

/// Does one job after the other, until the workbench ends.
fn does(waiting: &Receiver<(Arc<Job>, Task)>) {
    while let Ok((job, task)) = waiting.recv() {
        job.run(task);
    }
}

pub(super) async fn start(
    State(bench): State<Shared>,
    request: Result<Json<Request>, JsonRejection>,
) -> Result<(StatusCode, Json<Value>), Problem> {
    let Json(request) = request?;
    work(move || {
        let task = Task::new(&bench, request)?;
        let id = bench.jobs.submit(task)?;
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
