//! A listener with a limited number of connections; further ones wait in the system's queue.
//!
//! A connection without traffic is closed after a while: one with an incomplete request, one whose client does not read, or
//! one that a browser keeps open for later. A connection whose answer is being computed is kept.

use axum::extract::Request;
use axum::extract::connect_info::{ConnectInfo, Connected};
use axum::middleware::Next;
use axum::response::Response;
use axum::serve::{IncomingStream, Listener};
use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{Instant, Sleep, sleep};

/// Largest number of connections: a browser opens six for each of its tabs.
pub(super) const MOST: usize = 64;
/// Time without traffic after which a connection is closed; event streams send something every 15 s.
const SILENCE: Duration = Duration::from_secs(60);

/// A listener that takes a place of the semaphore for each connection; several listeners may share one.
pub(super) struct Bounded {
    pub(super) listener: TcpListener,
    pub(super) places: Arc<Semaphore>,
}

/// Number of answers that are being computed for a connection.
#[derive(Clone, Default)]
pub(super) struct ActiveRequests(Arc<AtomicUsize>);

tokio::task_local! {
    static ACTIVE_REQUESTS: ActiveRequests;
}

impl Connected<IncomingStream<'_, Bounded>> for ActiveRequests {
    fn connect_info(stream: IncomingStream<'_, Bounded>) -> Self {
        stream.io().active.clone()
    }
}

/// Makes the connection known to the handler of a request.
pub(super) async fn with_connection(
    ConnectInfo(active): ConnectInfo<ActiveRequests>,
    request: Request,
    next: Next,
) -> Response {
    ACTIVE_REQUESTS.scope(active, next.run(request)).await
}

/// Marks an answer as being computed until this is dropped; meanwhile its connection is kept.
pub(super) struct ActiveRequest(Option<ActiveRequests>);

impl ActiveRequest {
    pub(super) fn begin() -> Self {
        let active = ACTIVE_REQUESTS.try_with(ActiveRequests::clone).ok();
        if let Some(ActiveRequests(count)) = &active {
            count.fetch_add(1, Ordering::Relaxed);
        }
        Self(active)
    }
}

impl Drop for ActiveRequest {
    fn drop(&mut self) {
        if let Some(ActiveRequests(count)) = &self.0 {
            count.fetch_sub(1, Ordering::Relaxed);
        }
    }
}

/// A connection that releases its place when it is dropped.
pub(super) struct Connection<S> {
    stream: S,
    /// Expires when there was no traffic for [`SILENCE`].
    silent: Pin<Box<Sleep>>,
    active: ActiveRequests,
    _place: Option<OwnedSemaphorePermit>,
}

impl Listener for Bounded {
    type Io = Connection<TcpStream>;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Self::Io, SocketAddr) {
        // The semaphore is never closed.
        let place = self.places.clone().acquire_owned().await.ok();
        let (stream, from) = Listener::accept(&mut self.listener).await;
        (Connection::new(stream, place), from)
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }
}

impl<S> Connection<S> {
    fn new(stream: S, place: Option<OwnedSemaphorePermit>) -> Self {
        Self {
            stream,
            silent: Box::pin(sleep(SILENCE)),
            active: ActiveRequests::default(),
            _place: place,
        }
    }

    /// Handles the result of an attempt to read or write: traffic restarts the timeout, waiting is limited by it.
    fn moved<T>(
        &mut self,
        context: &mut Context<'_>,
        attempt: Poll<io::Result<T>>,
    ) -> Poll<io::Result<T>> {
        if attempt.is_ready() {
            self.silent.as_mut().reset(Instant::now() + SILENCE);
            return attempt;
        }
        while self.silent.as_mut().poll(context).is_ready() {
            if self.active.0.load(Ordering::Relaxed) == 0 {
                return Poll::Ready(Err(io::ErrorKind::TimedOut.into()));
            }
            self.silent.as_mut().reset(Instant::now() + SILENCE);
        }
        Poll::Pending
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Connection<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let read = Pin::new(&mut self.stream).poll_read(context, buffer);
        self.moved(context, read)
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Connection<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.moved(context, written)
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::{AsyncReadExt, AsyncWriteExt, duplex};

    #[tokio::test(start_paused = true)]
    async fn who_says_nothing_loses_its_place() {
        let places = Arc::new(Semaphore::new(1));
        let place = places.clone().acquire_owned().await.ok();
        let (mut client, server) = duplex(16);
        let mut connection = Connection::new(server, place);
        let served = tokio::spawn(async move {
            let mut heard = Vec::new();
            let ended = connection.read_to_end(&mut heard).await;
            (heard, ended.unwrap_err().kind())
        });
        // The connection stays as long as bytes arrive, however slowly.
        for _ in 0..3 {
            client.write_all(b"x").await.unwrap();
            tokio::time::sleep(SILENCE / 2).await;
            assert_eq!(places.available_permits(), 0);
        }
        let (heard, why) = served.await.unwrap();
        assert_eq!(
            (heard.as_slice(), why),
            (&b"xxx"[..], io::ErrorKind::TimedOut)
        );
        assert_eq!(places.available_permits(), 1);
    }

    #[tokio::test(start_paused = true)]
    async fn who_waits_for_an_answer_keeps_its_place() {
        let (_client, server) = duplex(16);
        let mut connection = Connection::new(server, None);
        let begin = async { ActiveRequest::begin() };
        let request = ACTIVE_REQUESTS
            .scope(connection.active.clone(), begin)
            .await;
        let mut nothing = [0];
        let waited = tokio::time::timeout(5 * SILENCE, connection.read(&mut nothing)).await;
        assert!(waited.is_err());
        drop(request);
        let ended = connection.read(&mut nothing).await;
        assert_eq!(ended.unwrap_err().kind(), io::ErrorKind::TimedOut);
    }

    #[tokio::test(start_paused = true)]
    async fn who_does_not_read_loses_its_place() {
        let (_client, server) = duplex(16);
        let mut connection = Connection::new(server, None);
        let ended = connection.write_all(&[0; 64]).await;
        assert_eq!(ended.unwrap_err().kind(), io::ErrorKind::TimedOut);
    }
}
