//! `softdock bench delay`: every delay law on the same plants.

use super::super::findings::Telling;
use super::super::law_names;
use crate::cli::progress::counter;
use anyhow::{Result, bail};
use clap::Args;
use serde::Serialize;
use softdock_control::delay::LawName;
use softdock_experiments::bench::delay::row::Row;
use softdock_experiments::bench::delay::run::{rows, run};
use softdock_experiments::bench::delay::{case::Case, cases, page, tables};
use std::time::Instant;

/// Run every delay law on the same plants and hold it against the ideal test.
///
/// The board's own control cycle runs in a closed loop with plants that share no code with it: late
/// robots of five structures, and contacts that are stiff, damped, oblique, off the centre or
/// between free spacecraft. Each number is the worst over several instants of the touch within a cycle.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock bench delay --quick
         softdock bench delay --law seed --case headline
         softdock bench delay --report delay.html --json")]
pub(super) struct Delay {
    /// Only this law; may be repeated
    #[arg(long, value_name = "NAME", value_parser = law_names())]
    law: Vec<LawName>,
    /// Only this case, or the cases of this sweep; may be repeated
    #[arg(long, value_name = "NAME")]
    case: Vec<String>,
    /// Fewer cases, speeds and touches
    #[arg(long)]
    quick: bool,
    /// Seed of all noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    telling: Telling,
}

#[derive(Serialize)]
struct Document<'a> {
    seed: u64,
    seconds: f64,
    rows: &'a [Row],
}

impl Delay {
    pub(super) fn execute(self) -> Result<()> {
        let (laws, cases) = (self.laws(), self.cases()?);
        self.telling.check(&[])?;
        let bar = counter(rows(&cases, &laws) as u64, "rows");
        let start = Instant::now();
        let rows = run(&cases, &laws, self.seed, &|| bar.inc(1))?;
        bar.finish_and_clear();
        let seconds = start.elapsed().as_secs_f64();
        let document = Document {
            seed: self.seed,
            seconds,
            rows: &rows,
        };
        let text = || {
            let table = tables::terminal(&rows, &laws);
            format!("{table}\n{} rows in {seconds:.0} s\n", rows.len())
        };
        self.telling
            .give(&document, || page::page(&rows, &laws), text)
    }

    fn laws(&self) -> Vec<LawName> {
        let asked = |law: &LawName| self.law.is_empty() || self.law.contains(law);
        LawName::ALL.into_iter().filter(asked).collect()
    }

    fn cases(&self) -> Result<Vec<Case>> {
        let all = if self.quick {
            cases::quick()
        } else {
            cases::all()
        };
        for name in &self.case {
            if !all.iter().any(|case| case.is_called(name)) {
                bail!("{}", unknown(name, &all));
            }
        }
        let asked =
            |case: &Case| self.case.is_empty() || self.case.iter().any(|n| case.is_called(n));
        Ok(all.into_iter().filter(asked).collect())
    }
}

/// Error message for a name that is neither a case nor a sweep: which names there are.
fn unknown(name: &str, all: &[Case]) -> String {
    let mut sweeps: Vec<&str> = all.iter().map(|case| case.sweep).collect();
    sweeps.sort_unstable();
    sweeps.dedup();
    let nearest = all
        .iter()
        .map(|case| case.name.as_str())
        .chain(sweeps.iter().copied())
        .max_by(|a, b| strsim::jaro_winkler(name, a).total_cmp(&strsim::jaro_winkler(name, b)));
    format!(
        "there is no case `{name}`; did you mean `{}`? The sweeps are: {}",
        nearest.unwrap_or_default(),
        sweeps.join(", ")
    )
}
