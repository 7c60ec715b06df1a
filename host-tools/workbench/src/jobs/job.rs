//! One job: what it has told, and how it ends.

use crate::problem::Problem;
use anyhow::Result;
use axum::http::StatusCode;
use serde_json::{Value, json};
use softdock_physics::model::Model;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tokio::sync::watch;

/// Something that a job tells.
#[derive(Clone, Debug)]
pub(super) struct Told {
    /// `stage`, `candidate`, and last of all `result` or `error`.
    pub(super) kind: &'static str,
    pub(super) value: Value,
}

/// What a job has for the model file.
#[derive(Clone, Debug)]
pub(crate) struct Prepared {
    /// The file.
    pub(crate) model_id: String,
    /// Of the file that it was made for.
    pub(crate) if_match: String,
    /// What the file will say.
    pub(crate) after: Model,
    /// Why it should not be written.
    pub(crate) doubt: Option<String>,
}

/// What a job does: it tells how far it is, and gives the document of the result and what can be written.
pub(super) type Work = Box<dyn FnOnce(&Job) -> Result<(Value, Option<Prepared>)> + Send>;

/// A job that waits, runs or has ended.
pub(super) struct Job {
    state: Mutex<State>,
    /// Number of things told.
    count: watch::Sender<usize>,
    cancelled: AtomicBool,
}

#[derive(Default)]
struct State {
    told: Vec<Told>,
    prepared: Option<Prepared>,
}

impl Default for Job {
    fn default() -> Self {
        Self {
            state: Mutex::default(),
            count: watch::Sender::new(0),
            cancelled: AtomicBool::new(false),
        }
    }
}

/// What unwinds a job that was cancelled.
struct Cancelled;

impl Job {
    /// Does the work; whatever happens in it, the job ends with a result or an error.
    pub(super) fn run(&self, work: Work) {
        let work = AssertUnwindSafe(|| work(self));
        let ended = catch_unwind(work).unwrap_or_else(|why| {
            Err(if why.is::<Cancelled>() {
                anyhow::anyhow!("ended on request")
            } else {
                anyhow::anyhow!("the work broke off: this is an error of softdock")
            })
        });
        match ended {
            Ok((result, prepared)) => {
                self.state().prepared = prepared;
                self.tell("result", result);
            }
            Err(error) => self.tell("error", json!({ "error": format!("{error:#}") })),
        }
    }

    /// Tells something to whoever listens. If nobody wants the result any more, the work ends here: it is unwound, as
    /// it has no other way out of the middle of a search.
    pub(super) fn tell(&self, kind: &'static str, value: Value) {
        if self.tell_if_wanted(kind, value).is_break() {
            resume_unwind(Box::new(Cancelled));
        }
    }

    /// Tells something, or says that nobody wants the result any more: for work that has something to clear away.
    pub(super) fn tell_if_wanted(&self, kind: &'static str, value: Value) -> ControlFlow<()> {
        let told = Told { kind, value };
        if self.is_cancelled() && !told.is_last() {
            return ControlFlow::Break(());
        }
        let mut state = self.state();
        state.told.push(told);
        self.count.send_replace(state.told.len());
        ControlFlow::Continue(())
    }

    /// Ends the job when it next tells something.
    pub(super) fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Nobody wants the result any more.
    pub(super) fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// What was told from number `from` on.
    pub(super) fn told(&self, from: usize) -> Vec<Told> {
        self.state().told.iter().skip(from).cloned().collect()
    }

    /// Changes with every thing told.
    pub(super) fn watched(&self) -> watch::Receiver<usize> {
        self.count.subscribe()
    }

    pub(super) fn prepared(&self) -> Option<Prepared> {
        self.state().prepared.clone()
    }

    pub(super) fn has_ended(&self) -> bool {
        let state = self.state();
        state.told.last().is_some_and(Told::is_last)
    }

    /// The result, once it is there.
    pub(super) fn result(&self) -> Result<Value, Problem> {
        let last = self.state().told.last().cloned();
        match last {
            Some(Told {
                kind: "result",
                value,
            }) => Ok(value),
            Some(Told {
                kind: "error",
                value,
            }) => {
                let why = value["error"].as_str().unwrap_or_default();
                Err(Problem::new(StatusCode::UNPROCESSABLE_ENTITY, why))
            }
            _ => Err(Problem::not_found("the job has not ended yet")),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Told {
    /// Nothing comes after it.
    pub(super) fn is_last(&self) -> bool {
        matches!(self.kind, "result" | "error")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cancelled_job_ends_where_it_next_tells_something() {
        let job = Job::default();
        job.tell("stage", json!(1));
        job.cancel();
        let ended = catch_unwind(AssertUnwindSafe(|| job.tell("stage", json!(2))));
        assert!(ended.unwrap_err().is::<Cancelled>());
        assert!(job.tell_if_wanted("stage", json!(3)).is_break());
        job.tell("error", json!({"error": "ended on request"}));
        assert!(job.has_ended());
        assert_eq!(job.told(0).len(), 2);
    }
}
