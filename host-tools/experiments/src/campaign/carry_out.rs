//! Computes the rows of a shard, in parallel, into one part file.

use super::columns::{BINARY, PLAN};
use super::journal::{self, Journal};
use super::outcome::{Outcome, Status};
use super::place::{self, Place};
use super::plan::{self, Plan};
use super::row::execute;
use super::shard::Shard;
use super::table::table;
use anyhow::{Result, bail, ensure};
use cpu_time::ProcessTime;
use rayon::prelude::*;
use softdock_io::data_table::{DataTable, Values};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// Result of a call.
#[derive(Clone, Copy, Debug)]
pub struct Done {
    /// Number of rows of the shard.
    pub rows: u64,
    /// Number of rows that this call computed.
    pub carried_out: u64,
    /// Number of rows that are not completed.
    pub failed: u64,
    /// Simulated cycles of this call.
    pub cycles: u64,
    /// Processor time of this call, s.
    pub processor_s: f64,
}

/// Computes the missing rows of a shard and writes its part. `done` is called after each row. When `stop` is raised, only the
/// rows under way are finished.
///
/// # Errors
/// It was stopped, or a file cannot be written; the computed rows are kept.
pub fn run(
    plan: &Plan,
    place: &Place,
    shard: Shard,
    threads: usize,
    stop: &AtomicBool,
    done: &(dyn Fn() + Sync),
) -> Result<Done> {
    let rows = (0..plan.rows()).filter(|index| shard.has(*index)).count() as u64;
    let begin = ProcessTime::now();
    let journals = place.journals();
    if let Some(part) = read_part(plan, place, shard)? {
        remove_journals(plan, place)?;
        return finished(&part, rows);
    }
    let mut known = journal::read(plan, journals, shard)?;
    let missing = (0..plan.rows()).filter(|index| shard.has(*index) && !known.contains_key(index));
    let missing: Vec<u64> = missing.collect();
    let new = carry_out(plan, journals, shard, &missing, threads, stop, done)?;
    let (carried_out, cycles) = (new.len() as u64, new.values().map(|o| o.cycles).sum());
    known.extend(new);
    ensure!(
        known.len() as u64 == rows,
        "stopped: {} of {rows} rows of shard {shard} are done and kept; the same command goes on",
        known.len()
    );
    let failed = known
        .values()
        .filter(|outcome| outcome.status != Status::Completed);
    let failed = failed.count() as u64;
    let all: Vec<(u64, Outcome)> = known.into_iter().collect();
    place.add(&shard.part(), table(plan, &all).to_parquet()?)?;
    remove_journals(plan, place)?;
    Ok(Done {
        rows,
        carried_out,
        failed,
        cycles,
        processor_s: begin.elapsed().as_secs_f64(),
    })
}

/// The result for a shard that was complete before.
fn finished(part: &DataTable, rows: u64) -> Result<Done> {
    Ok(Done {
        rows,
        carried_out: 0,
        failed: failed(part)?,
        cycles: 0,
        processor_s: 0.0,
    })
}

/// Removes each journal whose rows are all in parts. After a new division these may be journals of other divisions.
fn remove_journals(plan: &Plan, place: &Place) -> Result<()> {
    let names = place.names()?;
    let parts: BTreeSet<Shard> = names.iter().filter_map(|n| Shard::of_part(n)).collect();
    let divisions: BTreeSet<u64> = parts.iter().map(|part| part.of).collect();
    let in_part = |index: u64| {
        let one = |of: &u64| Shard {
            number: index % of,
            of: *of,
        };
        divisions.iter().map(one).any(|part| parts.contains(&part))
    };
    journal::remove(place.journals(), |shard| {
        let mut own = (0..plan.rows()).filter(|index| shard.has(*index));
        own.all(in_part)
    })
}

fn carry_out(
    plan: &Plan,
    journals: &Path,
    shard: Shard,
    missing: &[u64],
    threads: usize,
    stop: &AtomicBool,
    done: &(dyn Fn() + Sync),
) -> Result<BTreeMap<u64, Outcome>> {
    let journal = Mutex::new(Journal::start(plan, journals, shard)?);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    let one = |index: &u64| -> Result<Option<(u64, Outcome)>> {
        if stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let outcome = execute(plan, *index);
        let mut journal = journal.lock().unwrap_or_else(PoisonError::into_inner);
        journal.push(*index, &outcome)?;
        drop(journal);
        done();
        Ok(Some((*index, outcome)))
    };
    let rows = pool.install(|| missing.par_iter().map(one).collect::<Result<Vec<_>>>())?;
    Ok(rows.into_iter().flatten().collect())
}

/// The part of a shard, if there is one.
///
/// # Errors
/// The file is damaged, or of another plan or program.
pub(super) fn read_part(plan: &Plan, place: &Place, shard: Shard) -> Result<Option<DataTable>> {
    let file = shard.part();
    let Some(bytes) = place.read(&file)? else {
        return Ok(None);
    };
    let name = place.file(&file);
    let part = DataTable::of_parquet(bytes, &name)?;
    for (key, own, what) in [
        (PLAN, &plan.hash, "plan"),
        (BINARY, &plan.binary, "program"),
    ] {
        let received = part.metadata(key).unwrap_or("nothing");
        ensure!(
            received == own,
            "{name} is of another {what}: expected {own}, received {received}; move it away, or plan into a place of its own"
        );
    }
    Ok(Some(part))
}

/// Files of a campaign on this machine's disk: plan, parts and journals, which no other output may replace.
///
/// # Errors
/// Its folder cannot be read.
pub fn own_files(place: &Place) -> Result<Vec<PathBuf>> {
    let Some(folder) = place.on_disk() else {
        return Ok(Vec::new());
    };
    let own = |name: &String| {
        name == plan::FILE || Shard::of_part(name).is_some() || name.ends_with(journal::ENDING)
    };
    let names = place::names(folder)?.into_iter().filter(own);
    Ok(names.map(|name| folder.join(name)).collect())
}

/// Number of rows of a part that are not completed.
pub fn failed(part: &DataTable) -> Result<u64> {
    match part.values("status")? {
        Values::Text(words) => {
            let failed = words.iter().flatten().filter(|word| *word != "completed");
            Ok(failed.count() as u64)
        }
        _ => bail!("column `status` holds no words"),
    }
}
