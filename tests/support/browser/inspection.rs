//! What a browser finds in a page: messages, requests, and the drawings as laid out.

use serde::Deserialize;
use serde_json::Value;

/// Inspects every `<svg>` and the width of the page.
pub(super) const SCRIPT: &str = include_str!("inspection.js");

/// One `<svg>` as it is laid out.
#[derive(Clone, Debug, Deserialize)]
pub struct Drawing {
    /// Text for screen readers.
    pub label: String,
    /// Width on the screen, pixels.
    pub width: f64,
    /// Height on the screen, pixels.
    pub height: f64,
    /// Curves with at least two different points.
    pub curves: usize,
    /// Number of drawn elements: curves, bars, markers.
    pub marks: usize,
    /// Texts that are partly outside of the drawing.
    pub cut_off: Vec<String>,
    /// Pairs of texts that overlap.
    pub overlapping: Vec<String>,
    /// Attributes with a value that should be a number but is not.
    pub malformed: Vec<String>,
}

/// Content of a page.
#[derive(Clone, Debug)]
pub struct Inspection {
    /// Drawings, from top to bottom.
    pub drawings: Vec<Drawing>,
    /// Errors and warnings on the console.
    pub console: Vec<String>,
    /// Addresses that the page requested besides its own.
    pub requests: Vec<String>,
    /// Texts that extend beyond the page.
    pub sticking_out: Vec<String>,
}

/// Result of [`SCRIPT`].
#[derive(Deserialize)]
struct Found {
    drawings: Vec<Drawing>,
    sticking_out: Vec<String>,
}

impl Inspection {
    pub(super) fn new(address: &str, found: &Value, events: &[Value]) -> Self {
        let found: Found = serde_json::from_value(found.clone())
            .unwrap_or_else(|error| panic!("{error} in what the page says: {found}"));
        Self {
            drawings: found.drawings,
            sticking_out: found.sticking_out,
            console: events.iter().filter_map(complaint).collect(),
            requests: events
                .iter()
                .filter(|event| event["method"] == "Network.requestWillBeSent")
                .filter_map(|event| event["params"]["request"]["url"].as_str())
                .filter(|url| *url != address)
                .map(ToOwned::to_owned)
                .collect(),
        }
    }

    /// All faults, as text; empty if there are none.
    pub fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        faults.extend(self.console.iter().map(|c| format!("console: {c}")));
        faults.extend(self.requests.iter().map(|r| format!("asked for {r}")));
        faults.extend(
            self.sticking_out
                .iter()
                .map(|t| format!("sticks out of the page: {t}")),
        );
        if self.drawings.is_empty() {
            faults.push("no <svg>".to_owned());
        }
        for drawing in &self.drawings {
            let Drawing {
                label,
                width,
                height,
                ..
            } = drawing;
            if *width < 100.0 || *height < 20.0 {
                faults.push(format!(
                    "`{label}` is drawn {width} by {height} pixels large"
                ));
            }
            if drawing.marks == 0 {
                faults.push(format!("`{label}` is empty"));
            }
            let mut list = |what: &str, items: &[String]| {
                faults.extend(
                    items
                        .iter()
                        .map(|item| format!("`{label}`: {what}: {item}")),
                );
            };
            list("cut off", &drawing.cut_off);
            list("texts over each other", &drawing.overlapping);
            list("not a number", &drawing.malformed);
        }
        faults
    }
}

/// An error or a warning, if the event is one.
fn complaint(event: &Value) -> Option<String> {
    let parameters = &event["params"];
    let serious = |level: &Value| matches!(level.as_str(), Some("error" | "warning" | "assert"));
    match event["method"].as_str()? {
        "Runtime.exceptionThrown" => Some(parameters["exceptionDetails"].to_string()),
        "Runtime.consoleAPICalled" if serious(&parameters["type"]) => {
            Some(parameters["args"].to_string())
        }
        "Log.entryAdded" if serious(&parameters["entry"]["level"]) => {
            Some(parameters["entry"]["text"].to_string())
        }
        _ => None,
    }
}
