//! `softdock campaign run`.

use crate::cli::answer;
use crate::cli::live::raised_by_ctrl_c;
use anyhow::{Result, ensure};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use softdock_experiments::campaign::carry_out;
use softdock_experiments::campaign::place::Place;
use softdock_experiments::campaign::plan::Plan;
use softdock_experiments::campaign::shard::Shard;
use softdock_io::shell::quoted;
use std::path::PathBuf;
use std::thread::available_parallelism;
use std::time::Instant;

/// More threads than any machine has processors.
const MOST_THREADS: u64 = 1024;

/// Carry out a campaign, or one shard of it. What was done before is kept and not done again.
///
/// Ctrl-C ends it after the rows that are under way; the same command goes on.
#[derive(Debug, Args)]
#[command(after_help = "\
Example: softdock campaign run campaign

softdock campaign run campaign --shard 3/40 --threads 4")]
pub(super) struct Run {
    /// Folder of the campaign, or its address in an object store (`file:///..`, `s3://..`)
    campaign: PathBuf,
    /// The rows whose index leaves the remainder I when it is divided by N
    #[arg(long, value_name = "I/N", default_value_t = Shard::WHOLE)]
    shard: Shard,
    /// Runs at the same time; by default one for each processor
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u64).range(1..=MOST_THREADS))]
    threads: Option<u64>,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Summary {
    part: String,
    rows: u64,
    /// Rows that this call computed; the others had been computed before.
    carried_out: u64,
    failed: u64,
    seconds: f64,
    processor_seconds: f64,
    rows_per_processor_second: f64,
    cycles_per_processor_second: f64,
}

impl Run {
    pub(super) fn execute(self) -> Result<()> {
        let place = Place::open(&self.campaign)?;
        let plan = Plan::read_to_run(&place)?;
        let stop = raised_by_ctrl_c()?;
        let processors = || available_parallelism().map_or(1, |n| n.get() as u64);
        let threads = self.threads.unwrap_or_else(processors);
        let rows = plan.rows().div_ceil(self.shard.of);
        let bar = ProgressBar::new(rows);
        // The template is a constant that parses; if it did not, the default bar would do.
        if let Ok(style) =
            ProgressStyle::with_template("{bar:30} {pos}/{len} rows, {per_sec}, {eta} left")
        {
            bar.set_style(style);
        }
        let begin = Instant::now();
        let done = carry_out::run(&plan, &place, self.shard, threads as usize, &stop, &|| {
            bar.inc(1);
        });
        bar.finish_and_clear();
        let done = done?;
        let per_second = |count: u64| count as f64 / done.processor_s.max(1e-9);
        let summary = Summary {
            part: place.file(&self.shard.part()),
            rows: done.rows,
            carried_out: done.carried_out,
            failed: done.failed,
            seconds: begin.elapsed().as_secs_f64(),
            processor_seconds: done.processor_s,
            rows_per_processor_second: per_second(done.carried_out),
            cycles_per_processor_second: per_second(done.cycles),
        };
        answer(self.json, &summary, || text(&summary))?;
        // Single rows may fail: a campaign is there to find them. If all rows fail, the plan or the program is wrong. A shard
        // is exempt: all its rows may have one refused value, and a cluster that repeats failed jobs would repeat it for
        // ever.
        ensure!(
            self.shard != Shard::WHOLE || summary.rows == 0 || summary.failed < summary.rows,
            "none of the {} rows was carried out to its end; `softdock campaign rerun {} --index 0 -o row.mcap` says why the first \
             was not",
            summary.rows,
            quoted(&place)
        );
        Ok(())
    }
}

fn text(summary: &Summary) -> String {
    let Summary {
        part,
        rows,
        carried_out,
        failed,
        ..
    } = summary;
    let speed = if *carried_out == 0 {
        "all done before".to_owned()
    } else {
        format!(
            "{carried_out} now in {:.1} s: {:.0} rows and {:.0} cycles per processor second",
            summary.seconds, summary.rows_per_processor_second, summary.cycles_per_processor_second
        )
    };
    format!("{part}: {rows} rows, {failed} failed; {speed}\n")
}
