//! Messages of a job as server-sent events. A client that connects later, or again, gets the earlier ones too.

use super::job::{Job, JobMessage};
use crate::problem::Problem;
use crate::state::Shared;
use axum::extract::{Path, State};
use axum::http::HeaderMap;
use axum::response::sse::{Event, KeepAlive, Sse};
use futures_util::Stream;
use futures_util::stream::unfold;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::sync::Arc;
use tokio::sync::watch;

/// A client of a job's messages.
struct Listener {
    job: Arc<Job>,
    count: watch::Receiver<usize>,
    /// Number of messages that were taken from the job.
    taken: usize,
    ready: VecDeque<JobMessage>,
    ended: bool,
}

impl Listener {
    /// The next message, with its number from 1; None after the last.
    async fn next(mut self) -> Option<((usize, JobMessage), Self)> {
        loop {
            if let Some(message) = self.ready.pop_front() {
                self.ended = message.is_last();
                let number = self.taken - self.ready.len();
                return Some(((number, message), self));
            }
            if self.ended {
                return None;
            }
            self.count.mark_unchanged();
            let over = self.job.has_ended();
            let more = self.job.messages_from(self.taken);
            if more.is_empty() {
                // All messages of a job that has ended were delivered.
                if over {
                    return None;
                }
                self.count.changed().await.ok()?;
            }
            self.taken += more.len();
            self.ready.extend(more);
        }
    }
}

pub(crate) async fn events(
    State(bench): State<Shared>,
    Path(id): Path<u64>,
    headers: HeaderMap,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>>>, Problem> {
    let job = bench.jobs.job(id)?;
    let last = headers
        .get("last-event-id")
        .and_then(|id| id.to_str().ok()?.parse().ok());
    let listener = Listener {
        count: job.subscribe(),
        job,
        taken: last.unwrap_or(0),
        ready: VecDeque::new(),
        ended: false,
    };
    let stream = unfold(listener, |listener| async {
        let ((number, message), listener) = listener.next().await?;
        let event = Event::default().id(number.to_string()).event(message.kind);
        Some((Ok(event.data(message.value.to_string())), listener))
    });
    Ok(Sse::new(stream).keep_alive(KeepAlive::default()))
}
