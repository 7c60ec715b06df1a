//! What a job tells, as server-sent events. Whoever comes later, or again, gets what came before.

use super::job::{Job, Told};
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

/// A listener and what it has got.
struct Listener {
    job: Arc<Job>,
    count: watch::Receiver<usize>,
    /// Number of things that were taken from the job.
    taken: usize,
    ready: VecDeque<Told>,
    ended: bool,
}

impl Listener {
    /// The next thing, with its number from 1; none after the last.
    async fn next(mut self) -> Option<((usize, Told), Self)> {
        loop {
            if let Some(told) = self.ready.pop_front() {
                self.ended = told.is_last();
                let number = self.taken - self.ready.len();
                return Some(((number, told), self));
            }
            if self.ended {
                return None;
            }
            self.count.mark_unchanged();
            let over = self.job.has_ended();
            let more = self.job.told(self.taken);
            if more.is_empty() {
                // Who has heard all of a job that has ended waits for nothing.
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
        count: job.watched(),
        job,
        taken: last.unwrap_or(0),
        ready: VecDeque::new(),
        ended: false,
    };
    let stream = unfold(listener, |listener| async {
        let ((number, told), listener) = listener.next().await?;
        let event = Event::default().id(number.to_string()).event(told.kind);
        Some((Ok(event.data(told.value.to_string())), listener))
    });
    Ok(Sse::new(stream).keep_alive(KeepAlive::default()))
}
