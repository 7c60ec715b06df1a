//! Waiting, running and completed jobs.

use super::job::{Job, JobFn, Prepared};
use crate::problem::Problem;
use axum::http::StatusCode;
use softdock_physics::model::Model;
use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;

/// Largest number of waiting jobs.
const QUEUE: usize = 8;
/// Number of jobs whose results are kept.
const KEPT: usize = 32;

/// All jobs, in order.
pub(crate) struct Jobs {
    queue: SyncSender<(Arc<Job>, JobFn)>,
    list: Mutex<List>,
}

#[derive(Default)]
struct List {
    jobs: VecDeque<(u64, Arc<Job>)>,
    last: u64,
}

impl Jobs {
    /// Starts the thread that runs the jobs.
    pub(crate) fn start() -> Self {
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

    pub(super) fn submit(&self, work: JobFn) -> Result<u64, Problem> {
        let job = Arc::new(Job::default());
        let mut list = self.list();
        self.queue
            .try_send((job.clone(), work))
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

    pub(super) fn job(&self, id: u64) -> Result<Arc<Job>, Problem> {
        let list = self.list();
        let found = list.jobs.iter().find(|(own, _)| *own == id);
        let missing = || Problem::not_found(format!("there is no job {id} (any more)"));
        found.map(|(_, job)| job.clone()).ok_or_else(missing)
    }

    /// The change of the model file that a job has prepared.
    pub(crate) fn prepared(&self, id: u64) -> Result<Prepared, Problem> {
        let none = || Problem::not_found(format!("job {id} has found nothing to add"));
        self.job(id)?.prepared().ok_or_else(none)
    }

    /// The model with the change that a job has prepared.
    pub(crate) fn model_after(&self, id: u64) -> Result<Model, Problem> {
        self.prepared(id).map(|prepared| prepared.after)
    }
}

/// Runs one job after the other, until the workbench ends.
fn does(waiting: &Receiver<(Arc<Job>, JobFn)>) {
    while let Ok((job, work)) = waiting.recv() {
        job.run(work);
    }
}
