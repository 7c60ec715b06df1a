//! Can a diagnosis of these recordings say anything? What stands against it, and what is lacking.

use super::selection::Selection;
use crate::problem::Problem;
use crate::state::{Shared, work};
use axum::Json;
use axum::extract::State;
use axum::extract::rejection::JsonRejection;
use serde::Serialize;

/// The answer: a diagnosis is possible if nothing stands against it.
#[derive(Serialize)]
pub(crate) struct Check {
    ready: bool,
    /// Why a diagnosis is not possible.
    against: Option<String>,
    /// What it cannot say with these recordings, and what they let suspect.
    lacking: Vec<String>,
}

pub(crate) async fn check(
    State(bench): State<Shared>,
    selection: Result<Json<Selection>, JsonRejection>,
) -> Result<Json<Check>, Problem> {
    let Json(selection) = selection?;
    work(move || {
        let opened = selection.open(&bench)?;
        Ok(Json(match opened.logs {
            Ok(logs) => Check {
                ready: true,
                against: None,
                lacking: logs.notes,
            },
            Err(error) => Check {
                ready: false,
                against: Some(format!("{error:#}")),
                lacking: Vec::new(),
            },
        }))
    })
    .await
}
