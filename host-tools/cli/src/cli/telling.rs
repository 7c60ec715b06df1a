//! Where what a command found goes: a report, the terminal.

use super::answer;
use super::outputs::html_file;
use anyhow::Result;
use clap::Args;
use serde::Serialize;
use softdock_io::input::refuse_overwrite_of;
use softdock_io::output::write_whole;
use softdock_io::say;
use softdock_report::Page;
use std::path::{Path, PathBuf};

/// The options of commands that find something and write nothing but a report.
#[derive(Debug, Args)]
pub(super) struct Telling {
    /// Report to write (one HTML page)
    #[arg(long, value_name = "FILE.html", value_parser = html_file)]
    report: Option<PathBuf>,
    /// Overwrite an existing report
    #[arg(long)]
    force: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl Telling {
    /// Refuses at once what would be overwritten at the end; `inputs` are never.
    pub(super) fn check(&self, inputs: &[&Path]) -> Result<()> {
        let mut report = self.report.iter();
        report.try_for_each(|file| refuse_overwrite_of(inputs, file, self.force))
    }

    /// Writes and prints what was found; `text` is for the terminal.
    pub(super) fn give(
        &self,
        found: &impl Serialize,
        page: impl FnOnce() -> Result<Page>,
        text: impl FnOnce() -> String,
    ) -> Result<()> {
        if let Some(file) = &self.report {
            write_whole(file, page()?.to_html())?;
            say!("report: {}", file.display());
        }
        answer(self.json, found, text)
    }
}
