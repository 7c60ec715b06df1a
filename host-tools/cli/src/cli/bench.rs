//! `softdock bench`: how good the program is, measured.

mod delay;

use super::{print, print_json};
use crate::bench::diagnose::{self, Bench as Scored, Row, rates};
use anyhow::Result;
use clap::{Args, Subcommand};
use indicatif::ProgressBar;
use serde::Serialize;
use softdock_report::{Cell, Column, Table};
use std::path::PathBuf;

/// Measure how good the program is at its work.
#[derive(Debug, Args)]
pub(super) struct Bench {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    Delay(delay::Delay),
    Diagnose(Diagnose),
}

/// Hide effects in simulated logs and count how often the diagnosis is right.
///
/// The logs come from a generator of its own, which knows nothing of the effects in this program:
/// single effects of many sizes, pairs, logs with nothing hidden, parameters that are off within
/// their tolerances, and effects that no catalogue contains.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock bench diagnose --seed 3
         softdock bench diagnose --ladder
         softdock bench diagnose --folder cases")]
struct Diagnose {
    /// Seed of the generator
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only the first N cases
    #[arg(long, value_name = "N")]
    count: Option<usize>,
    /// How small an effect is still found: the same effects at falling sizes
    #[arg(long)]
    ladder: bool,
    /// A folder of docking-rig-log/1 cases with their truth.json, instead of the generator
    #[arg(long, value_name = "DIR", conflicts_with_all = ["count", "ladder"])]
    folder: Option<PathBuf>,
    /// Print every case, not only those that went wrong
    #[arg(long)]
    all: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl Bench {
    pub(super) fn execute(self) -> Result<()> {
        match self.what {
            What::Delay(command) => command.execute(),
            What::Diagnose(command) => command.execute(),
        }
    }
}

#[derive(Serialize)]
struct Document<'a> {
    scores: Vec<Score>,
    median_drop_percent: Option<f64>,
    min_drop_percent: Option<f64>,
    median_seconds: Option<f64>,
    max_seconds: Option<f64>,
    rows: &'a [Row],
}

#[derive(Serialize)]
struct Score {
    name: &'static str,
    right: usize,
    of: usize,
}

impl Diagnose {
    fn execute(self) -> Result<()> {
        let scored = match &self.folder {
            Some(folder) => {
                let bar = ProgressBar::new(diagnose::truths(folder)?.len() as u64);
                diagnose::folder(folder, &|| bar.inc(1))?
            }
            None => {
                let mut specs = if self.ladder {
                    softdock_hidden_effects::size_sweep(self.seed)
                } else {
                    softdock_hidden_effects::suite(self.seed)
                };
                specs.truncate(self.count.unwrap_or(usize::MAX));
                let bar = ProgressBar::new(specs.len() as u64);
                diagnose::generated(&specs, &|| bar.inc(1))?
            }
        };
        if self.json {
            return print_json(&document(&scored));
        }
        let mut text = String::new();
        if self.ladder {
            text.push_str(&format!("{}\n\n", ladder(&scored.rows)));
        }
        let shown: Vec<&Row> = scored
            .rows
            .iter()
            .filter(|r| self.all || !r.right)
            .collect();
        if !shown.is_empty() {
            text.push_str(&format!("{}\n\n", cases(&shown)));
        }
        text.push_str(&format!("{}\n", summary(&scored)));
        print(&text)
    }
}

fn document(scored: &Scored) -> Document<'_> {
    let seconds = scored.scores.median_and_max_seconds();
    Document {
        scores: rates(&scored.scores)
            .into_iter()
            .map(|(name, rate)| Score {
                name,
                right: rate.right,
                of: rate.of,
            })
            .collect(),
        median_drop_percent: scored.scores.median_drop_percent(),
        min_drop_percent: scored.scores.min_drop_percent(),
        median_seconds: seconds.map(|s| s.0),
        max_seconds: seconds.map(|s| s.1),
        rows: &scored.rows,
    }
}

fn cases(rows: &[&Row]) -> Table {
    let mut table = table_of(&["case", "size", "hidden", "said", "right", "error gone"]);
    for row in rows {
        let said = match row.verdict {
            softdock_hidden_effects::Verdict::Named => row.effects.join(" + "),
            softdock_hidden_effects::Verdict::NothingMissing => "nothing missing".to_owned(),
            softdock_hidden_effects::Verdict::Unexplained => "unexplained".to_owned(),
            softdock_hidden_effects::Verdict::LogsDisagree => "logs disagree".to_owned(),
            softdock_hidden_effects::Verdict::NotTestable => "not testable".to_owned(),
        };
        let hidden = if row.hidden.is_empty() {
            "nothing".to_owned()
        } else {
            row.hidden.join(" + ")
        };
        add(
            &mut table,
            &[
                row.name.clone(),
                format!("{}", row.size),
                hidden,
                said,
                (if row.right { "yes" } else { "NO" }).to_owned(),
                row.drop_percent
                    .map_or_else(String::new, |d| format!("{d:.0} %")),
            ],
        );
    }
    table
}

fn ladder(rows: &[Row]) -> Table {
    let mut sizes: Vec<f64> = rows.iter().map(|r| r.size).collect();
    sizes.sort_by(|a, b| b.total_cmp(a));
    sizes.dedup();
    let mut table = table_of(&["size of the effect", "found", "of"]);
    for size in sizes {
        let of_size = rows.iter().filter(|r| r.size == size);
        let found = of_size.clone().filter(|r| r.right).count();
        add(
            &mut table,
            &[
                format!("{size}"),
                found.to_string(),
                of_size.count().to_string(),
            ],
        );
    }
    table
}

fn summary(scored: &Scored) -> Table {
    let mut table = table_of(&["score", "right", "of"]);
    for (name, rate) in rates(&scored.scores).into_iter().filter(|r| r.1.of > 0) {
        add(
            &mut table,
            &[name.to_owned(), rate.right.to_string(), rate.of.to_string()],
        );
    }
    if let (Some(median), Some(least)) = (
        scored.scores.median_drop_percent(),
        scored.scores.min_drop_percent(),
    ) {
        add(
            &mut table,
            &[
                "error gone, median and least".to_owned(),
                format!("{median:.1} %"),
                format!("{least:.1} %"),
            ],
        );
    }
    if let Some((median, longest)) = scored.scores.median_and_max_seconds() {
        add(
            &mut table,
            &[
                "time, median and longest".to_owned(),
                format!("{median:.2} s"),
                format!("{longest:.2} s"),
            ],
        );
    }
    table
}

fn table_of(titles: &[&str]) -> Table {
    Table::new(titles.iter().map(|title| Column::text(*title)).collect())
}

fn add(table: &mut Table, texts: &[String]) {
    table.push(texts.iter().map(Cell::text).collect());
}
