//! Requests about a running board: listen, stop, and the frames as server-sent events.

use super::problem::Problem;
use super::state::{Shared, work};
use axum::Json;
use axum::extract::State;
use axum::extract::rejection::JsonRejection;
use axum::http::StatusCode;
use axum::response::sse::{Event, KeepAlive, Sse};
use futures_util::Stream;
use futures_util::stream::unfold;
use serde::Deserialize;
use serde_json::{Value, json};
use softdock_io::address::address as address_of;
use std::convert::Infallible;
use std::sync::Arc;
use tokio::sync::broadcast::{Receiver, error::RecvError};

/// Address to which the board sends.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Address {
    listen: String,
}

pub(super) async fn start(
    State(bench): State<Shared>,
    address: Result<Json<Address>, JsonRejection>,
) -> Result<Json<Value>, Problem> {
    let Json(Address { listen }) = address?;
    let listen = address_of(&listen).map_err(anyhow::Error::msg)?;
    work(move || {
        let address = bench.live.start(listen)?;
        Ok(Json(json!({ "listen": address })))
    })
    .await
}

pub(super) async fn stop(State(bench): State<Shared>) -> Result<StatusCode, Problem> {
    work(move || {
        bench.live.stop();
        Ok(StatusCode::NO_CONTENT)
    })
    .await
}

pub(super) async fn frames(
    State(bench): State<Shared>,
) -> Sse<impl Stream<Item = Result<Event, Infallible>>> {
    let stream = unfold(bench.live.frames(), |frames| async {
        let (event, frames) = next(frames).await?;
        Some((Ok(event), frames))
    });
    Sse::new(stream).keep_alive(KeepAlive::default())
}

/// The next frame, or the number of frames that were dropped.
async fn next(mut frames: Receiver<Arc<Value>>) -> Option<(Event, Receiver<Arc<Value>>)> {
    let event = match frames.recv().await {
        Ok(frame) => Event::default().event("frame").data(frame.to_string()),
        Err(RecvError::Lagged(dropped)) => {
            Event::default().event("dropped").data(dropped.to_string())
        }
        Err(RecvError::Closed) => return None,
    };
    Some((event, frames))
}
