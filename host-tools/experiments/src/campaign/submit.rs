//! Lines that hand a campaign to a cluster. They are printed, never run.

use super::place::Place;
use anyhow::{Context, Result};
use softdock_io::shell::quoted;

/// Kills of a task, by lost workers, after which HyperQueue gives up on it.
const CRASH_LIMIT: u32 = 20;

/// Line for HyperQueue: one task for each shard.
///
/// # Errors
/// The folder or this program has no path.
pub fn hyperqueue(place: &Place, shards: u64, threads: usize) -> Result<String> {
    Ok(format!(
        "hq submit --name softdock --array 0-{} --cpus {threads} --crash-limit {CRASH_LIMIT} -- sh -c {}",
        shards - 1,
        quoted(shard_command(place, "HQ_TASK_ID", shards, threads)?)
    ))
}

/// Line for Slurm: one task of an array for each shard, started again if its node is lost.
///
/// # Errors
/// The folder or this program has no path.
pub fn slurm(place: &Place, shards: u64, threads: usize) -> Result<String> {
    // A store takes no lines: the logs are where `sbatch` is called then.
    let log = match place.on_disk() {
        Some(folder) => std::path::absolute(folder)?.join("slurm-%a.log"),
        None => "slurm-%a.log".into(),
    };
    Ok(format!(
        "sbatch --job-name softdock --array 0-{} --ntasks 1 --cpus-per-task {threads} --requeue --open-mode append --output {} --wrap {}",
        shards - 1,
        quoted(log.display()),
        quoted(shard_command(
            place,
            "SLURM_ARRAY_TASK_ID",
            shards,
            threads
        )?)
    ))
}

/// What a task runs; `variable` holds its number.
fn shard_command(place: &Place, variable: &str, shards: u64, threads: usize) -> Result<String> {
    let program = std::env::current_exe().context("cannot find the running program")?;
    Ok(format!(
        "exec {} campaign run {} --shard ${variable}/{shards} --threads {threads}",
        quoted(program.display()),
        quoted(place.absolute()?.display())
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_shard_is_a_task() {
        let place = Place::folder("/my campaign".as_ref());
        let line = hyperqueue(&place, 40, 2).unwrap();
        assert!(
            line.starts_with("hq submit --name softdock --array 0-39 --cpus 2"),
            "{line}"
        );
        assert!(
            line.contains("--shard $HQ_TASK_ID/40 --threads 2"),
            "{line}"
        );
    }
}
