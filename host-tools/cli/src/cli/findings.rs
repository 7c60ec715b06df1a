//! Output of results: into a settings file, a report, or the terminal.

use super::answer;
use super::outputs::html_file;
use anyhow::Result;
use clap::Args;
use serde::Serialize;
use softdock_app::settings::BoardSettings;
use softdock_commissioning::fragment::Fragment;
use softdock_io::input::{self, refuse_overwrite_of};
use softdock_io::output::write_whole;
use softdock_io::{say, to_standard_error};
use softdock_report::Page;
use std::path::{Path, PathBuf};

/// The options of every command that measures something for the settings.
#[derive(Debug, Args)]
pub(super) struct Destination {
    /// Settings file to write with what was found
    #[arg(short, long, value_name = "FOUND.toml")]
    output: Option<PathBuf>,
    /// Settings file to change; its comments stay
    #[arg(long, value_name = "BOARD.toml")]
    pub(super) into: Option<PathBuf>,
    /// Report to write (one HTML page)
    #[arg(long, value_name = "FILE.html", value_parser = html_file)]
    report: Option<PathBuf>,
    /// Overwrite existing files
    #[arg(long)]
    pub(super) force: bool,
    /// Print one JSON document
    #[arg(long)]
    pub(super) json: bool,
}

impl Destination {
    /// Refuses early, before a robot has moved: files that would be overwritten at the end (`inputs` always, others without
    /// --force), and settings that cannot be changed.
    pub(super) fn check(&self, inputs: &[&Path]) -> Result<()> {
        if let Some(file) = &self.into {
            input::load::<BoardSettings>(file)?;
        }
        let files = [&self.output, &self.report];
        files
            .into_iter()
            .flatten()
            .try_for_each(|file| refuse_overwrite_of(inputs, file, self.force))
    }

    /// Writes and prints the result; `text` is for the terminal.
    pub(super) fn give(
        &self,
        found: &impl Serialize,
        fragment: &Fragment,
        page: impl FnOnce() -> Result<Page>,
        text: &str,
    ) -> Result<()> {
        if let Some(file) = &self.report {
            write_whole(file, page()?.to_html())?;
            say!("report: {}", file.display());
        }
        if let Some(file) = &self.output {
            fragment.write(file, self.force)?;
        }
        if let Some(file) = &self.into {
            to_standard_error(format_args!("{}", fragment.write_into(file)?));
        }
        answer(self.json, found, || text)
    }
}

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
    /// Refuses early what would be overwritten at the end; `inputs` are never overwritten.
    pub(super) fn check(&self, inputs: &[&Path]) -> Result<()> {
        let mut report = self.report.iter();
        report.try_for_each(|file| refuse_overwrite_of(inputs, file, self.force))
    }

    /// Writes and prints the result; `text` is for the terminal.
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
