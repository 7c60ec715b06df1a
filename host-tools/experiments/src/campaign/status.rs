//! Progress of a campaign.

use super::carry_out::{failed, read_part};
use super::columns::INDEX;
use super::journal;
use super::place::Place;
use super::plan::Plan;
use super::shard::Shard;
use anyhow::{Result, bail};
use serde::Serialize;
use softdock_io::data_table::{DataTable, Values};
use std::collections::BTreeSet;

/// Progress of a campaign.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Progress {
    /// Hash of the plan.
    pub hash: String,
    /// Number of rows of the plan.
    pub rows: u64,
    /// Number of rows in parts.
    pub done: u64,
    /// Number of rows in parts that are not completed.
    pub failed: u64,
    /// Number of rows in journals on this machine that are in no part yet, of shards that are interrupted or still running.
    /// Such a row is reused by the shard to which it belongs, whatever the division.
    pub kept: u64,
    /// Number of shards of the division: the largest that a part names. Without parts it is the largest that a journal names,
    /// which may be of a division that was given up.
    pub shards: u64,
    /// Numbers of the shards of which a row is missing.
    pub missing_shards: Vec<u64>,
}

/// Determines the progress from the parts and journals of a campaign.
///
/// # Errors
/// A part is no table of this plan and program.
pub fn progress(plan: &Plan, place: &Place) -> Result<Progress> {
    let parts = parts(plan, place)?;
    let mut done = vec![false; plan.rows() as usize];
    let mut failures = 0;
    for (_, part) in &parts {
        for index in indices(part)? {
            if let Some(done) = done.get_mut(index as usize) {
                *done = true;
            }
        }
        failures += failed(part)?;
    }
    let journals = journal::all(plan, place.journals())?;
    // `merge` takes parts of one division only, so that of the parts counts.
    let of_parts = parts.iter().map(|(shard, _)| shard.of).max();
    let of_journals = journals.iter().map(|(shard, _)| shard.of).max();
    let shards = of_parts.or(of_journals).unwrap_or(1);
    let kept = journals.iter().flat_map(|(_, rows)| rows);
    let kept: BTreeSet<u64> = kept.map(|(index, _)| *index).collect();
    let kept = kept.iter().filter(|index| !done[**index as usize]).count();
    let missing = |number: &u64| {
        let mut own = done.iter().skip(*number as usize).step_by(shards as usize);
        own.any(|done| !done)
    };
    // Shards beyond the number of rows are empty, whatever number a file's name claims.
    let with_rows = 0..shards.min(plan.rows());
    Ok(Progress {
        hash: plan.hash.clone(),
        rows: plan.rows(),
        done: done.iter().filter(|done| **done).count() as u64,
        failed: failures,
        kept: kept as u64,
        shards,
        missing_shards: with_rows.filter(missing).collect(),
    })
}

/// All parts of a campaign.
pub(super) fn parts(plan: &Plan, place: &Place) -> Result<Vec<(Shard, DataTable)>> {
    let names = place.names()?;
    let shards = names.iter().filter_map(|name| Shard::of_part(name));
    let parts = shards.map(|shard| Ok((shard, read_part(plan, place, shard)?)));
    let parts = parts.collect::<Result<Vec<_>>>()?;
    Ok(parts
        .into_iter()
        .filter_map(|(shard, part)| Some((shard, part?)))
        .collect())
}

/// Indices of a part's rows.
pub(super) fn indices(part: &DataTable) -> Result<Vec<u64>> {
    match part.values(INDEX)? {
        Values::Count(indices) => Ok(indices.iter().flatten().copied().collect()),
        _ => bail!("column `{INDEX}` holds no whole numbers"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::carry_out;
    use crate::campaign::journal::Journal;
    use crate::campaign::outcome::Outcome;
    use crate::campaign::table::table;

    /// Before there are parts, journals show the division; a new division reuses the rows that were computed.
    #[test]
    fn an_interrupted_shard_is_gone_on_with() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("campaign.toml");
        std::fs::write(&file, "bench = \"delay\"").unwrap();
        let plan = Plan::new(&file).unwrap();
        let mut journal = Journal::start(&plan, folder.path(), "1/4".parse().unwrap()).unwrap();
        for index in [1, 5] {
            journal.push(index, &Outcome::default()).unwrap();
        }
        let progress = progress(&plan, &Place::folder(folder.path())).unwrap();
        assert_eq!((progress.shards, progress.kept), (4, 2));
        assert_eq!(progress.missing_shards, [0, 1, 2, 3]);
        for (shard, kept) in [("1/2", vec![1, 5]), ("0/1", vec![1, 5]), ("0/4", vec![])] {
            let rows = journal::read(&plan, folder.path(), shard.parse().unwrap()).unwrap();
            assert!(rows.into_keys().eq(kept), "{shard}");
        }
    }

    /// Journals of an abandoned division are removed once all their rows are in parts; a journal with a row in no part stays.
    #[test]
    fn journals_of_another_division_go_with_the_last_of_their_rows() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("campaign.toml");
        std::fs::write(&file, "bench = \"delay\"\nsamples = 1").unwrap();
        let (plan, place) = (Plan::new(&file).unwrap(), Place::folder(folder.path()));
        for shard in ["1/4", "0/2"] {
            Journal::start(&plan, folder.path(), shard.parse().unwrap()).unwrap();
        }
        let rows: Vec<_> = (0..plan.rows())
            .filter(|index| index % 2 == 1)
            .map(|index| (index, Outcome::default()))
            .collect();
        let shard: Shard = "1/2".parse().unwrap();
        place
            .add(&shard.part(), table(&plan, &rows).to_parquet().unwrap())
            .unwrap();
        carry_out::run(&plan, &place, shard, 1, &false.into(), &|| ()).unwrap();
        let left = journal::all(&plan, folder.path()).unwrap();
        assert!(
            left.into_iter()
                .map(|(shard, _)| shard.to_string())
                .eq(["0/2"])
        );
    }
}
