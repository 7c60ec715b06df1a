//! Command lines that submit a campaign to a cluster. They are printed, never run.

use super::place::Place;
use anyhow::{Context, Result};
use softdock_io::shell::quoted;

/// Number of losses of a task with its worker after which HyperQueue gives it up.
const CRASH_LIMIT: u32 = 20;

/// Command line for HyperQueue: one task for each shard.
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

/// Command line for Slurm: an array with one task for each shard, which is restarted if its node is lost.
///
/// # Errors
/// The folder or this program has no path.
pub fn slurm(place: &Place, shards: u64, threads: usize) -> Result<String> {
    // Logs cannot be written to a store: they go to the folder in which `sbatch` is called.
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

/// Command of a task; `variable` holds the task's number.
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
