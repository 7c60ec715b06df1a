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

/// Ending of a journal's name.
pub(super) const ENDING: &str = ".journal";

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
            let name = format!("{}{process}-{n}{ENDING}", prefix(shard));
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

/// All rows of a shard in journals of this plan and program.
///
/// # Errors
/// The folder cannot be read.
pub fn read(plan: &Plan, folder: &Path, shard: Shard) -> Result<BTreeMap<u64, Outcome>> {
    let mut rows = rows(plan, of(folder, shard)?);
    rows.retain(|index, _| shard.has(*index));
    Ok(rows)
}

/// All rows that are kept in journals of shards that are not done.
///
/// # Errors
/// The folder cannot be read.
pub fn all(plan: &Plan, folder: &Path) -> Result<BTreeMap<u64, Outcome>> {
    let journals = names(folder)?.into_iter();
    Ok(rows(plan, journals.map(|name| folder.join(name))))
}

fn rows(plan: &Plan, journals: impl IntoIterator<Item = PathBuf>) -> BTreeMap<u64, Outcome> {
    let mut rows = BTreeMap::new();
    for path in journals {
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        let Some(lines) = text.strip_prefix(&head(plan)) else {
            continue;
        };
        // Up to the last whole line.
        let whole = lines.rfind('\n').map_or("", |end| &lines[..=end]);
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .from_reader(whole.as_bytes());
        let own = |row: &(u64, Outcome)| row.0 < plan.rows();
        rows.extend(reader.deserialize().flatten().filter(own));
    }
    rows
}

/// Removes the journals of a shard that is done.
///
/// # Errors
/// They cannot be removed.
pub fn remove(folder: &Path, shard: Shard) -> Result<()> {
    for path in of(folder, shard)? {
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(error).with_context(|| format!("cannot remove {}", path.display()));
            }
            _ => {}
        }
    }
    Ok(())
}

fn of(folder: &Path, shard: Shard) -> Result<Vec<PathBuf>> {
    let prefix = prefix(shard);
    let own = names(folder)?.into_iter();
    let own = own.filter(|name| name.starts_with(&prefix));
    Ok(own.map(|name| folder.join(name)).collect())
}

/// Names of all journals; no machine has any before its first row.
fn names(folder: &Path) -> Result<Vec<String>> {
    if !folder.exists() {
        return Ok(Vec::new());
    }
    let mut names = place::names(folder)?;
    names.retain(|name| name.ends_with(ENDING));
    Ok(names)
}

fn prefix(shard: Shard) -> String {
    format!(".rows-{}-of-{}-", shard.number, shard.of)
}

fn head(plan: &Plan) -> String {
    format!("#plan {} {}\n", plan.hash, plan.binary)
}
