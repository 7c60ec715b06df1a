//! A bounded queue from a thread to a task.

use softdock_app::board::IoError;
use std::collections::VecDeque;
use std::future::poll_fn;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};

#[derive(Debug)]
struct State<T> {
    items: VecDeque<T>,
    waker: Option<Waker>,
    closed: bool,
}

/// Both ends of the queue.
#[derive(Debug)]
pub(super) struct Mailbox<T> {
    state: Arc<Mutex<State<T>>>,
    capacity: usize,
}

impl<T> Clone for Mailbox<T> {
    fn clone(&self) -> Self {
        Self {
            state: self.state.clone(),
            capacity: self.capacity,
        }
    }
}

impl<T> Mailbox<T> {
    pub(super) fn new(capacity: usize) -> Self {
        let state = State {
            items: VecDeque::new(),
            waker: None,
            closed: false,
        };
        Self {
            state: Arc::new(Mutex::new(state)),
            capacity,
        }
    }

    /// Adds an item; the oldest makes room, as in a network card's ring.
    pub(super) fn push(&self, item: T) {
        let mut state = self.lock();
        if state.items.len() >= self.capacity {
            state.items.pop_front();
        }
        state.items.push_back(item);
        if let Some(waker) = state.waker.take() {
            waker.wake();
        }
    }

    /// Ends the task's waiting.
    pub(super) fn close(&self) {
        let mut state = self.lock();
        state.closed = true;
        if let Some(waker) = state.waker.take() {
            waker.wake();
        }
    }

    pub(super) fn try_take(&self) -> Option<T> {
        self.lock().items.pop_front()
    }

    pub(super) async fn take(&self) -> Result<T, IoError> {
        poll_fn(|context| self.poll_take(context)).await
    }

    pub(super) fn poll_take(&self, context: &mut Context<'_>) -> Poll<Result<T, IoError>> {
        let mut state = self.lock();
        if state.closed {
            return Poll::Ready(Err(IoError::Closed));
        }
        match state.items.pop_front() {
            Some(item) => Poll::Ready(Ok(item)),
            None => {
                state.waker = Some(context.waker().clone());
                Poll::Pending
            }
        }
    }

    fn lock(&self) -> MutexGuard<'_, State<T>> {
        // Nothing that holds the lock can panic half-way through a change.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
