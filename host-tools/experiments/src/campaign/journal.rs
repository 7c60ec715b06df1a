//! The journal of a shard: every row as soon as it is done, so that a shard that was stopped, by
//! whatever, goes on where it was.
//!
//! A text file of one row per line. Each process writes one of its own; a line that was cut off is no row.

use super::outcome::Outcome;
use super::place;
use super::plan::Plan;
use super::shard::Shard;
use anyhow::{Context, Result};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Beginning of a journal's name.
const PREFIX: &str = ".rows-";
/// Ending of a journal's name.
pub(super) const ENDING: &str = ".journal";

/// Index and outcome of a row.
pub type Row = (u64, Outcome);

/// The journal that this process writes.
#[derive(Debug)]
pub struct Journal {
    file: File,
    path: PathBuf,
}

impl Journal {
    /// Starts a journal, with what the plan and the program are.
    ///
    /// # Errors
    /// The folder cannot be written to.
    pub fn start(plan: &Plan, folder: &Path, shard: Shard) -> Result<Self> {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
        let process = std::process::id();
        // Two machines may have the same process number.
        let again = (0_u32..).map(|n| {
            let Shard { number, of } = shard;
            let name = format!("{PREFIX}{number}-of-{of}-{process}-{n}{ENDING}");
            (File::create_new(folder.join(&name)), folder.join(&name))
        });
        let opened = again.take(1000).find(|(file, _)| {
            !file
                .as_ref()
                .is_err_and(|e| e.kind() == std::io::ErrorKind::AlreadyExists)
        });
        let (file, path) = opened.context("a thousand journals of this process are there")?;
        let mut file = file.with_context(|| format!("cannot write {}", path.display()))?;
        file.write_all(head(plan).as_bytes())?;
        Ok(Self { file, path })
    }

    /// Adds a row.
    ///
    /// # Errors
    /// The disk is full.
    pub fn push(&mut self, index: u64, outcome: &Outcome) -> Result<()> {
        let mut line = csv::WriterBuilder::new()
            .has_headers(false)
            .from_writer(Vec::new());
        line.serialize((index, outcome))?;
        let line = line.into_inner().map_err(|error| error.into_error())?;
        // In one piece, so that an end at any moment cuts off this line at most.
        let written = self.file.write_all(&line);
        written.with_context(|| format!("cannot write {}", self.path.display()))
    }
}

/// All rows of a shard in journals of this plan and program, however the rows were divided when they were done.
///
/// # Errors
/// The folder cannot be read.
pub fn read(plan: &Plan, folder: &Path, shard: Shard) -> Result<BTreeMap<u64, Outcome>> {
    let journals = journals(folder)?.into_iter();
    // Of its own division no other shard has rows of it.
    let some = journals.filter(|(other, _)| *other == shard || other.of != shard.of);
    let rows = some.filter_map(|(_, path)| rows(plan, &path)).flatten();
    Ok(rows.filter(|(index, _)| shard.has(*index)).collect())
}

/// The shard and the rows of each journal of this plan and program.
///
/// # Errors
/// The folder cannot be read.
pub fn all(plan: &Plan, folder: &Path) -> Result<Vec<(Shard, Vec<Row>)>> {
    let journals = journals(folder)?.into_iter();
    let own = journals.filter_map(|(shard, path)| Some((shard, rows(plan, &path)?)));
    Ok(own.collect())
}

/// Rows of a journal; none if it is of another plan or program.
fn rows(plan: &Plan, path: &Path) -> Option<Vec<Row>> {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let lines = text.strip_prefix(&head(plan))?;
    // Up to the last whole line.
    let whole = lines.rfind('\n').map_or("", |end| &lines[..=end]);
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .from_reader(whole.as_bytes());
    let own = |row: &Row| row.0 < plan.rows();
    Some(reader.deserialize().flatten().filter(own).collect())
}

/// Removes the journals of shards that are done, in whatever division: no row that they may still get is missing.
///
/// # Errors
/// They cannot be removed.
pub fn remove(folder: &Path, is_done: impl Fn(Shard) -> bool) -> Result<()> {
    let done = journals(folder)?.into_iter().filter(|(of, _)| is_done(*of));
    for (_, path) in done {
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(error).with_context(|| format!("cannot remove {}", path.display()));
            }
            _ => {}
        }
    }
    Ok(())
}

/// All journals with their shards; no machine has any before its first row.
fn journals(folder: &Path) -> Result<Vec<(Shard, PathBuf)>> {
    if !folder.exists() {
        return Ok(Vec::new());
    }
    let names = place::names(folder)?.into_iter();
    let own = names.filter_map(|name| Some((shard_of(&name)?, folder.join(name))));
    Ok(own.collect())
}

/// The shard of a journal's file name.
fn shard_of(name: &str) -> Option<Shard> {
    let numbers = name.strip_prefix(PREFIX)?.strip_suffix(ENDING)?;
    let (number, rest) = numbers.split_once("-of-")?;
    let (of, _) = rest.split_once('-')?;
    format!("{number}/{of}").parse().ok()
}

fn head(plan: &Plan) -> String {
    format!("#plan {} {}\n", plan.hash, plan.binary)
}
