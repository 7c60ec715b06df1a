//! Names of files to write: an ending that promises another format is a mistake.

use std::path::{Path, PathBuf};

/// File endings that promise a certain format.
const KNOWN: [&str; 9] = [
    "csv", "html", "htm", "json", "mcap", "parquet", "pdf", "svg", "toml",
];

/// File name of a report.
pub(super) fn html_file(text: &str) -> Result<PathBuf, String> {
    match ending(text) {
        None | Some("html" | "htm") => Ok(text.into()),
        Some(other) => Err(format!(
            "a report is an HTML page, not .{other}: name it {} (a browser prints it as PDF)",
            Path::new(text).with_extension("html").display()
        )),
    }
}

/// File name of a recording.
pub(super) fn mcap_file(text: &str) -> Result<PathBuf, String> {
    match ending(text) {
        None | Some("mcap") => Ok(text.into()),
        Some(other) => Err(format!(
            "a recording is MCAP, not .{other}: name it {} (`softdock export` makes a table of it)",
            Path::new(text).with_extension("mcap").display()
        )),
    }
}

/// File name for `softdock export`: a table, or a copy for viewers.
pub(super) fn exported_file(text: &str) -> Result<PathBuf, String> {
    match Path::new(text)
        .extension()
        .map(|ending| ending.to_string_lossy())
    {
        None => Ok(text.into()),
        Some(ending) if ["csv", "mcap"].contains(&&*ending) => Ok(text.into()),
        Some(other) => Err(format!(
            "a recording is exported as .csv (a table) or .mcap (for viewers), not .{other}; `softdock compare --series` \
             writes .parquet"
        )),
    }
}

/// The ending of a file name if it is a known format; else None.
fn ending(text: &str) -> Option<&'static str> {
    let ending = Path::new(text).extension()?.to_str()?.to_lowercase();
    KNOWN.into_iter().find(|known| *known == ending)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ending_that_promises_another_format_is_refused() {
        for good in ["r.html", "r", "/dev/null", "report.HTM", "run.1"] {
            assert_eq!(html_file(good), Ok(good.into()));
        }
        let error = html_file("out/r.pdf").unwrap_err();
        assert!(error.contains("out/r.html"), "{error}");
        let error = mcap_file("run.csv").unwrap_err();
        assert!(
            error.contains("run.mcap") && error.contains("softdock export"),
            "{error}"
        );
    }

    #[test]
    fn a_recording_is_exported_as_what_its_ending_says() {
        for good in ["run.csv", "run.mcap", "/dev/full"] {
            assert_eq!(exported_file(good), Ok(good.into()));
        }
        for bad in ["run.pdf", "run.json", "run.xlsx"] {
            let error = exported_file(bad).unwrap_err();
            assert!(error.contains(".csv") && error.contains(".mcap"), "{error}");
        }
    }
}
