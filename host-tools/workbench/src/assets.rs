//! The files of the page, built into the program. A debug build reads them from the source tree, so that the page can be
//! edited without compiling.

use super::problem::Problem;
use axum::extract::Path;
use axum::http::StatusCode;
use axum::http::header::{CONTENT_TYPE, ETAG, HeaderMap, IF_NONE_MATCH};
use axum::response::{IntoResponse, Response};
use std::borrow::Cow;
use std::hash::{DefaultHasher, Hash, Hasher};

/// Name and content.
type Asset = (&'static str, &'static str);

macro_rules! assets {
    ($($name:literal),+ $(,)?) => {
        [$(($name, include_str!(concat!("assets/", $name)))),+]
    };
}

const INDEX: &str = include_str!("assets/index.html");
const ASSETS: [Asset; 20] = assets![
    "add.js",
    "align.js",
    "api.js",
    "app.css",
    "app.js",
    "chart.js",
    "diagnosis.js",
    "dom.js",
    "folder.js",
    "history.js",
    "hypothesis.js",
    "icon.svg",
    "live.js",
    "plots.js",
    "simulation.js",
    "state.js",
    "uPlot.LICENSE",
    "uPlot.iife.min.js",
    "uPlot.min.css",
    "verdict.js",
];

pub(super) async fn index(headers: HeaderMap) -> Response {
    asset(
        "text/html; charset=utf-8",
        newest("index.html", INDEX),
        &headers,
    )
}

pub(super) async fn file(
    Path(name): Path<String>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let found = ASSETS.iter().find(|(own, _)| *own == name);
    let (name, text) = found.ok_or_else(|| Problem::not_found("the page has no such file"))?;
    let kind = match name.rsplit('.').next() {
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("LICENSE") => "text/plain; charset=utf-8",
        _ => "image/svg+xml",
    };
    Ok(asset(kind, newest(name, text), &headers))
}

/// The text of a file of the page.
fn newest(name: &str, built_in: &'static str) -> Cow<'static, str> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/assets");
    let newest = || std::fs::read_to_string(std::path::Path::new(path).join(name)).ok();
    match cfg!(debug_assertions).then(newest).flatten() {
        Some(text) => text.into(),
        None => built_in.into(),
    }
}

fn asset(kind: &'static str, text: Cow<'static, str>, headers: &HeaderMap) -> Response {
    let mut hasher = DefaultHasher::new();
    text.hash(&mut hasher);
    let tag = format!("\"{:016x}\"", hasher.finish());
    if headers
        .get(IF_NONE_MATCH)
        .is_some_and(|known| *known == *tag)
    {
        return StatusCode::NOT_MODIFIED.into_response();
    }
    ([(CONTENT_TYPE, kind.to_owned()), (ETAG, tag)], text).into_response()
}
