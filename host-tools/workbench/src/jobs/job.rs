//! One job: its messages, and how it ends.

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

/// A message of a job.
#[derive(Clone, Debug)]
pub(super) struct JobMessage {
    /// Kind of the message: `stage`, `candidate`, and at the end `result` or `error`.
    pub(super) kind: &'static str,
    pub(super) value: Value,
}

/// A change of the model file that a job has prepared.
#[derive(Clone, Debug)]
pub(crate) struct Prepared {
    /// Id of the file.
    pub(crate) model_id: String,
    /// Fingerprint of the file that it was prepared for.
    pub(crate) if_match: String,
    /// The model after the change.
    pub(crate) after: Model,
    /// Why it should not be written; None if nothing is against it.
    pub(crate) doubt: Option<String>,
}

/// The work of a job. It reports its progress, and returns the document of the result and a change that can be written.
pub(super) type JobFn = Box<dyn FnOnce(&Job) -> Result<(Value, Option<Prepared>)> + Send>;

/// A job that is waiting, running or has ended.
pub(super) struct Job {
    state: Mutex<State>,
    /// Number of messages.
    count: watch::Sender<usize>,
    cancelled: AtomicBool,
}

#[derive(Default)]
struct State {
    messages: Vec<JobMessage>,
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

/// Panic payload that ends a cancelled job by unwinding.
struct Cancelled;

impl Job {
    /// Does the work. Whatever happens, also a panic, the job ends with a result or an error.
    pub(super) fn run(&self, work: JobFn) {
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

    /// Sends a message. If the job was cancelled, the work is ended by unwinding: there is no other way out of the middle of
    /// a search.
    pub(super) fn tell(&self, kind: &'static str, value: Value) {
        if self.tell_if_wanted(kind, value).is_break() {
            resume_unwind(Box::new(Cancelled));
        }
    }

    /// Sends a message, or breaks if the job was cancelled: for work that has to clean up.
    pub(super) fn tell_if_wanted(&self, kind: &'static str, value: Value) -> ControlFlow<()> {
        let message = JobMessage { kind, value };
        if self.is_cancelled() && !message.is_last() {
            return ControlFlow::Break(());
        }
        let mut state = self.state();
        state.messages.push(message);
        self.count.send_replace(state.messages.len());
        ControlFlow::Continue(())
    }

    /// Cancels the job: it ends with its next message.
    pub(super) fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether the job was cancelled.
    pub(super) fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Messages from number `from` on.
    pub(super) fn messages_from(&self, from: usize) -> Vec<JobMessage> {
        self.state().messages.iter().skip(from).cloned().collect()
    }

    /// A receiver that is notified of each message.
    pub(super) fn subscribe(&self) -> watch::Receiver<usize> {
        self.count.subscribe()
    }

    pub(super) fn prepared(&self) -> Option<Prepared> {
        self.state().prepared.clone()
    }

    pub(super) fn has_ended(&self) -> bool {
        let state = self.state();
        state.messages.last().is_some_and(JobMessage::is_last)
    }

    /// The result of a job that has ended.
    pub(super) fn result(&self) -> Result<Value, Problem> {
        let last = self.state().messages.last().cloned();
        match last {
            Some(JobMessage {
                kind: "result",
                value,
            }) => Ok(value),
            Some(JobMessage {
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

impl JobMessage {
    /// Whether this is the last message of a job.
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
        assert_eq!(job.messages_from(0).len(), 2);
    }
}
