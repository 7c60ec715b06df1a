//! Recordings of the folder, and recorded quantities as series of numbers.

use super::files::{About, fingerprint};
use super::folder::FolderFile;
use super::problem::Problem;
use super::state::{Shared, Workbench, work};
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Path, Query, State};
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use softdock_io::recording::{Column, Outline};

/// A recording in the list.
#[derive(Serialize)]
pub(super) struct Listed {
    id: String,
    bytes: u64,
    /// Time of the last change of the file, seconds since 1970.
    when: u64,
    #[serde(flatten)]
    about: About,
}

/// Description of a recording from both ends of its file; a file that was cut off is read up to the cut.
fn about(bench: &Workbench, found: &FolderFile) -> About {
    let read = || {
        let recording = bench.files.recording(&bench.folder, &found.id)?;
        Ok(Outline::of(&recording))
    };
    let outline: Result<Outline, Problem> = Outline::read(&found.path).map_or_else(read, Ok);
    match outline {
        Ok(outline) => About::Read {
            cycles: outline.cycles,
            duration_s: outline.duration_s,
            cycle_s: outline.duration_s / outline.cycles.saturating_sub(1).max(1) as f64,
            settings_hash: fingerprint(&outline.header.settings_toml),
            firmware: outline.header.identity,
            truncated: outline.cut,
        },
        Err(problem) => broken(bench, problem),
    }
}

fn broken(bench: &Workbench, problem: Problem) -> About {
    let problem = problem.without(&bench.folder.prefix());
    About::Broken {
        error: problem.sentence().to_owned(),
    }
}

pub(super) async fn list(State(bench): State<Shared>) -> Result<Json<Vec<Listed>>, Problem> {
    let of = move || {
        let found = bench.folder.list("mcap").into_iter();
        Ok(Json(found.map(|found| listed(&bench, found)).collect()))
    };
    work(of).await
}

fn listed(bench: &Workbench, found: FolderFile) -> Listed {
    let about = bench.files.about(&found, || about(bench, &found));
    Listed {
        about: about.unwrap_or_else(|problem| broken(bench, problem)),
        id: found.id,
        bytes: found.bytes,
        when: found.changed_s,
    }
}

pub(super) async fn channels(
    State(bench): State<Shared>,
    Path(id): Path<String>,
) -> Result<Json<Vec<Column>>, Problem> {
    work(move || Ok(Json(bench.files.recording(&bench.folder, &id)?.columns()))).await
}

/// Query of recorded series.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Wanted {
    /// Names of columns, separated by commas.
    c: String,
    /// First time, s.
    from: Option<f64>,
    /// Last time, s.
    to: Option<f64>,
}

/// Time and the requested columns, in the format of [`blob`].
pub(super) async fn series(
    State(bench): State<Shared>,
    Path(id): Path<String>,
    wanted: Result<Query<Wanted>, QueryRejection>,
) -> Result<Response, Problem> {
    let Query(wanted) = wanted?;
    work(move || {
        let recording = bench.files.recording(&bench.folder, &id)?;
        let names: Vec<&str> = wanted.c.split(',').collect();
        let found = recording.series(&names);
        let mut columns = vec![recording.cycles.iter().map(|c| c.trace.time_s).collect()];
        for (name, series) in names.iter().zip(found) {
            let missing = || Problem::not_found(format!("`{id}` has no column `{name}`"));
            columns.push(series.ok_or_else(missing)?);
        }
        blob(&between(columns, wanted.from, wanted.to))
    })
    .await
}

/// The rows in which the first column, the time, is within a range.
fn between(mut columns: Vec<Vec<f64>>, from: Option<f64>, to: Option<f64>) -> Vec<Vec<f64>> {
    let time = columns.first().map_or(&[][..], Vec::as_slice);
    let first = time.partition_point(|t| *t < from.unwrap_or(f64::NEG_INFINITY));
    let end = time.partition_point(|t| *t <= to.unwrap_or(f64::INFINITY));
    for column in &mut columns {
        column.truncate(end);
        column.drain(..first.min(column.len()));
    }
    columns
}

/// Columns of equal length in a binary format that a page reads without parsing: the number of rows and of columns (u32),
/// then column after column (f64), all little-endian. NaN is a gap.
pub(super) fn blob(columns: &[Vec<f64>]) -> Result<Response, Problem> {
    let rows = columns.first().map_or(0, Vec::len);
    let short = |n: usize| {
        u32::try_from(n)
            .map_err(|_| Problem::new(StatusCode::PAYLOAD_TOO_LARGE, "too many numbers"))
    };
    let mut bytes = Vec::with_capacity(8 + 8 * rows * columns.len());
    bytes.extend(short(rows)?.to_le_bytes());
    bytes.extend(short(columns.len())?.to_le_bytes());
    bytes.extend(
        columns
            .iter()
            .flatten()
            .flat_map(|value| value.to_le_bytes()),
    );
    Ok(([(CONTENT_TYPE, "application/octet-stream")], bytes).into_response())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_of_time_is_cut_out() {
        let columns = || vec![vec![0.0, 1.0, 2.0, 3.0], vec![5.0, 6.0, 7.0, 8.0]];
        assert_eq!(
            between(columns(), Some(0.5), Some(2.0)),
            [[1.0, 2.0], [6.0, 7.0]]
        );
        assert_eq!(between(columns(), None, None), columns());
        let nothing = vec![Vec::<f64>::new(); 2];
        assert_eq!(between(columns(), Some(9.0), None), nothing);
        assert_eq!(between(columns(), Some(2.0), Some(1.0)), nothing);
    }
}
