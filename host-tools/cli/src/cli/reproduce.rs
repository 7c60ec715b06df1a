//! `softdock reproduce`: the paper's experiment.

use super::answer;
use crate::cli::progress::counter;
use anyhow::{Context, Result};
use clap::Args;
use serde::Serialize;
use softdock_experiments::reproduce::{Bounces, DONE, Row, reproduce};
use softdock_experiments::reproduce_page::{bounce_table, headline, page, table};
use softdock_io::input::refuse_overwrite;
use softdock_io::output::write_whole;
use softdock_io::say;
use std::path::PathBuf;

/// Reproduce the paper's spring-rod experiment with and without its delay compensation.
///
/// Writes reproduce.html (all figures and tables) and reproduce.json.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock reproduce -o reproduced")]
pub(super) struct Reproduce {
    /// Folder to write into
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Document<'a> {
    rows: Vec<&'a Row>,
    bounces: &'a [Bounces],
}

impl Reproduce {
    pub(super) fn execute(self) -> Result<()> {
        let html = self.output.join("reproduce.html");
        let json = self.output.join("reproduce.json");
        refuse_overwrite(&html, self.force)?;
        refuse_overwrite(&json, self.force)?;
        std::fs::create_dir_all(&self.output)
            .with_context(|| format!("cannot create {}", self.output.display()))?;
        let bar = counter(DONE, "the paper's experiment");
        let reproduction = reproduce(&|| bar.inc(1))?;
        bar.finish_and_clear();
        let document = Document {
            rows: reproduction
                .flights
                .iter()
                .map(|flight| &flight.row)
                .collect(),
            bounces: &reproduction.bounces,
        };
        write_whole(&html, page(&reproduction)?.to_html())?;
        write_whole(&json, serde_json::to_string_pretty(&document)?)?;
        say!("report: {}\ndata:   {}", html.display(), json.display());
        answer(self.json, &document, || {
            let (rows, bounces) = (table(&reproduction), bounce_table(&reproduction));
            format!("{rows}\n\n{bounces}\n\n{}\n", headline(&reproduction))
        })
    }
}
