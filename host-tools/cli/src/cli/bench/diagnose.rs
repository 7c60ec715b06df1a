//! `softdock bench diagnose`: how often the diagnosis is right, and how right what it says is.

use super::super::{answer, print};
use crate::cli::progress::counter;
use anyhow::{Result, ensure};
use clap::Args;
use serde::Serialize;
use softdock_experiments::bench::diagnose::coverage::{
    Coverage, ReliabilityBin, coverage, reliability,
};
use softdock_experiments::bench::diagnose::nulls::Nothing;
use softdock_experiments::bench::diagnose::{self, Bench as Scored, Row, rates, tables};
use softdock_hidden_effects::{CaseSpec, nothing_hidden, size_sweep, suite};
use std::path::PathBuf;

/// Hide effects in simulated logs and count how often the diagnosis is right.
///
/// The logs come from a generator of its own, which knows nothing of the effects in this program:
/// single effects of many sizes, pairs, triples, effects in one log only, logs with nothing hidden,
/// parameters that are off within their tolerances, and effects that no catalogue contains. Also
/// counted: how often a 95 % interval contains the truth, and what is said with which probability.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock bench diagnose --seed 3
         softdock bench diagnose --ladder
         softdock bench diagnose --nothing-hidden 300
         softdock bench diagnose --folder cases
         softdock bench diagnose --seed 3 --case h017 --write cases
Then:    softdock import cases/h017 -o h017")]
pub(super) struct Diagnose {
    /// Seed of the generator
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only the first N cases
    #[arg(long, value_name = "N")]
    count: Option<usize>,
    /// Only this case, as h017; may be repeated
    #[arg(long, value_name = "NAME")]
    case: Vec<String>,
    /// How small an effect is still found: the same effects at falling sizes
    #[arg(long)]
    ladder: bool,
    /// How much evidence N logs with nothing hidden show, and the limit that follows
    #[arg(long, value_name = "N", conflicts_with_all = ["count", "ladder"])]
    nothing_hidden: Option<usize>,
    /// A folder of docking-rig-log/1 cases with their truth.json, instead of the generator
    #[arg(long, value_name = "DIR", conflicts_with_all = ["count", "ladder", "nothing_hidden"])]
    folder: Option<PathBuf>,
    /// Write the cases into a new folder instead of diagnosing them, for `import` and --folder
    #[arg(long, value_name = "DIR", conflicts_with_all = ["folder", "all", "json"])]
    write: Option<PathBuf>,
    /// Print every case, not only those that went wrong
    #[arg(long)]
    all: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Document<'a> {
    scores: Vec<Score>,
    median_drop_percent: Option<f64>,
    min_drop_percent: Option<f64>,
    coverage_of_95_percent: Vec<Coverage>,
    said_probabilities: Vec<ReliabilityBin>,
    median_seconds: Option<f64>,
    seconds_of_90_percent: Option<f64>,
    max_seconds: Option<f64>,
    memory_mb: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    nothing_hidden: Option<&'a Nothing>,
    rows: &'a [Row],
}

#[derive(Serialize)]
struct Score {
    name: &'static str,
    right: usize,
    of: usize,
}

impl Diagnose {
    pub(super) fn execute(self) -> Result<()> {
        if let Some(folder) = &self.write {
            let specs = self.specs()?;
            let bar = counter(specs.len() as u64, "writing");
            diagnose::write(&specs, folder, &|| bar.inc(1))?;
            return print(&format!("{} cases in {}.\n", specs.len(), folder.display()));
        }
        let scored = match &self.folder {
            Some(folder) => {
                let cases = self.chosen(diagnose::truths(folder)?, |(name, _)| name)?;
                let bar = counter(cases.len() as u64, "diagnosing");
                diagnose::folder(folder, cases, &|| bar.inc(1))?
            }
            None => {
                let specs = self.specs()?;
                let bar = counter(specs.len() as u64, "diagnosing");
                diagnose::generated(&specs, &|| bar.inc(1))?
            }
        };
        let nothing = self.nothing_hidden.map(|_| Nothing::of(&scored.rows));
        let nothing = nothing.as_ref();
        answer(self.json, &document(&scored, nothing), || {
            self.text(&scored, nothing)
        })
    }

    fn specs(&self) -> Result<Vec<CaseSpec>> {
        let specs = match self.nothing_hidden {
            Some(count) => nothing_hidden(self.seed, count),
            None if self.ladder => size_sweep(self.seed),
            None => suite(self.seed),
        };
        self.chosen(specs, CaseSpec::name)
    }

    /// The cases that `--count` and `--case` select.
    fn chosen<T>(&self, mut all: Vec<T>, name: impl Fn(&T) -> &str) -> Result<Vec<T>> {
        all.truncate(self.count.unwrap_or(usize::MAX));
        for case in &self.case {
            ensure!(
                all.iter().any(|one| name(one) == case),
                "there is no case `{case}` among the {}, {} to {}",
                all.len(),
                all.first().map_or("", &name),
                all.last().map_or("", &name)
            );
        }
        let wanted = |one: &T| self.case.is_empty() || self.case.iter().any(|c| c == name(one));
        all.retain(wanted);
        Ok(all)
    }

    fn text(&self, scored: &Scored, nothing: Option<&Nothing>) -> String {
        let mut parts = Vec::new();
        if self.ladder {
            parts.push(tables::ladder(&scored.rows).to_string());
        }
        let shown = scored.rows.iter().filter(|r| self.all || !r.right);
        let shown: Vec<&Row> = shown.collect();
        if !shown.is_empty() {
            parts.push(tables::cases(&shown).to_string());
        }
        match nothing {
            Some(nothing) => {
                parts.push(tables::alarms(nothing).to_string());
                parts.push(tables::evidence(nothing).to_string());
                parts.push(tables::limits(nothing));
            }
            None => {
                parts.push(tables::coverage(&coverage(&scored.rows)).to_string());
                parts.push(tables::probabilities(&reliability(&scored.rows)).to_string());
                parts.push(tables::summary(scored).to_string());
            }
        }
        parts.push(tables::cost(scored, peak_memory_mb()).to_string());
        format!("{}\n", parts.join("\n\n"))
    }
}

fn document<'a>(scored: &'a Scored, nothing_hidden: Option<&'a Nothing>) -> Document<'a> {
    let scores = &scored.scores;
    Document {
        scores: rates(scores)
            .into_iter()
            .map(|(name, rate)| Score {
                name,
                right: rate.right,
                of: rate.of,
            })
            .collect(),
        median_drop_percent: scores.median_drop_percent(),
        min_drop_percent: scores.min_drop_percent(),
        coverage_of_95_percent: coverage(&scored.rows),
        said_probabilities: reliability(&scored.rows),
        median_seconds: scores.seconds_of(0.5),
        seconds_of_90_percent: scores.seconds_of(0.9),
        max_seconds: scores.seconds_of(1.0),
        memory_mb: peak_memory_mb(),
        nothing_hidden,
        rows: &scored.rows,
    }
}

/// Peak memory of this process, MB; None where the system does not report it.
fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kilobytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes / 1024.0)
}
