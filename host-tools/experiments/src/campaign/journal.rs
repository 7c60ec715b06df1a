//! The journal of a shard: it holds every row as soon as it is computed, so that an interrupted shard continues where it was.
//!
//! A journal is a text file with one row per line. Each process writes its own. A line that was cut off is ignored.

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

/// The journal of this process.
#[derive(Debug)]
pub struct Journal {
    file: File,
    path: PathBuf,
}

impl Journal {
    /// Starts a journal with a head that identifies plan and program.
    ///
    /// # Errors
    /// The folder cannot be written to.
    pub fn start(plan: &Plan, folder: &Path, shard: Shard) -> Result<Self> {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
        let process = std::process::id();
        // The journal of another machine may have the same process number.
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
        // One write for the whole line, so that an interruption cuts off this line at most.
        let written = self.file.write_all(&line);
        written.with_context(|| format!("cannot write {}", self.path.display()))
    }
}

/// All rows of a shard in journals of this plan and program, also in those of shards of another division.
///
/// # Errors
/// The folder cannot be read.
pub fn read(plan: &Plan, folder: &Path, shard: Shard) -> Result<BTreeMap<u64, Outcome>> {
    let journals = journals(folder)?.into_iter();
    // Other shards of the same division have no row of this one.
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

/// Rows of a journal; None if it is of another plan or program.
fn rows(plan: &Plan, path: &Path) -> Option<Vec<Row>> {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let lines = text.strip_prefix(&head(plan))?;
    // Ignore a last line without an end.
    let whole = lines.rfind('\n').map_or("", |end| &lines[..=end]);
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .from_reader(whole.as_bytes());
    let own = |row: &Row| row.0 < plan.rows();
    Some(reader.deserialize().flatten().filter(own).collect())
}

/// Removes the journals of all shards for which `is_done` holds.
///
/// # Errors
/// A journal cannot be removed.
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

/// All journals with their shards; empty on a machine that has not computed a row yet.
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
