//! Access to the rows of a campaign.

use super::bench::Bench;
use super::columns::SUCCESS;
use super::file::Limit;
use super::outcome::{NUMBERS, Number};
use super::plan::{Plan, PlannedFactor};
use super::statistics::{Estimate, quantile, share};
use anyhow::{Result, bail};
use softdock_io::data_table::{DataTable, Values};

/// The outcome that ranks rows if the campaign names none and has no limits.
const DEFAULT_WORST: &str = "peak_force_n";

/// The table of a campaign and its plan.
#[derive(Debug)]
pub struct Results<'a> {
    /// The plan.
    pub plan: &'a Plan,
    /// All rows.
    pub table: &'a DataTable,
}

impl Results<'_> {
    /// A numeric column.
    pub fn numbers(&self, name: &str) -> Result<&[Option<f64>]> {
        match self.table.values(name)? {
            Values::Number(values) => Ok(values),
            _ => bail!("column `{name}` holds no numbers"),
        }
    }

    /// For each row, whether the run was a success.
    pub fn successes(&self) -> Result<Vec<bool>> {
        Ok(self
            .flags(SUCCESS)?
            .iter()
            .map(|flag| *flag == Some(true))
            .collect())
    }

    pub(super) fn flags(&self, name: &str) -> Result<&[Option<bool>]> {
        match self.table.values(name)? {
            Values::Flag(values) => Ok(values),
            _ => bail!("column `{name}` holds no flags"),
        }
    }

    pub(super) fn words(&self, name: &str) -> Result<&[Option<String>]> {
        match self.table.values(name)? {
            Values::Text(values) => Ok(values),
            _ => bail!("column `{name}` holds no words"),
        }
    }

    /// The outcomes that the report shows.
    pub fn shown_numbers(&self) -> impl Iterator<Item = &'static Number> {
        let campaign = &self.plan.campaign;
        let named = campaign.outcomes.iter().map(String::as_str);
        let wanted: Vec<&str> = match (campaign.outcomes.is_empty(), campaign.bench) {
            (true, Some(bench)) => bench.outcomes().to_vec(),
            _ => named.collect(),
        };
        let shown = move |number: &&Number| wanted.is_empty() || wanted.contains(&number.name);
        NUMBERS.iter().filter(shown)
    }

    /// The outcome that ranks rows, and its limit if it has one.
    pub fn worst_by(&self) -> (&str, Option<&Limit>) {
        let campaign = &self.plan.campaign;
        let first = campaign.limits.first().map(|limit| limit.outcome.as_str());
        let usual = campaign.bench.map_or(DEFAULT_WORST, Bench::worst);
        let name = campaign.worst.as_deref().or(first).unwrap_or(usual);
        (
            name,
            campaign.limits.iter().find(|limit| limit.outcome == name),
        )
    }

    /// Number of different draws among these rows, which are in ascending order.
    pub(super) fn draws(&self, rows: &[usize]) -> usize {
        let mut draws: Vec<u64> = rows.iter().map(|r| self.plan.draw(*r as u64)).collect();
        draws.dedup();
        draws.len()
    }

    /// Share of these rows for which `is_true` holds; None without rows.
    pub(super) fn share(
        &self,
        rows: &[usize],
        is_true: impl Fn(usize) -> bool,
    ) -> Option<Estimate> {
        let count = rows.iter().filter(|row| is_true(**row)).count();
        share(count, rows.len(), self.draws(rows))
    }

    /// The finite values of these rows.
    pub(super) fn sample(&self, rows: &[usize], values: &[Option<f64>]) -> Sample {
        let finite = |row: &usize| values[*row].is_some_and(f64::is_finite);
        let rows: Vec<usize> = rows.iter().copied().filter(finite).collect();
        let mut ordered: Vec<f64> = rows.iter().filter_map(|row| values[*row]).collect();
        ordered.sort_by(f64::total_cmp);
        let draws = self.draws(&rows);
        Sample { ordered, draws }
    }

    /// Values of a factor and an outcome in the rows that have both; words become numbers of their groups.
    pub(super) fn pairs(&self, factor: &PlannedFactor, outcome: &str) -> Result<Pairs> {
        let y = self.numbers(outcome)?;
        let (numeric, x): (bool, Vec<Option<f64>>) = match self.table.values(&factor.name)? {
            Values::Number(x) => (true, x.clone()),
            Values::Text(words) => {
                let mut known: Vec<&String> = words.iter().flatten().collect();
                known.sort();
                known.dedup();
                let place = |word: &String| known.binary_search(&word).ok().map(|p| p as f64);
                (
                    false,
                    words
                        .iter()
                        .map(|word| word.as_ref().and_then(place))
                        .collect(),
                )
            }
            _ => bail!("factor `{}` holds neither numbers nor words", factor.name),
        };
        let both = x
            .iter()
            .zip(y)
            .filter_map(|(x, y)| Some(((*x)?, (*y).filter(|y| y.is_finite())?)));
        let (x, y) = both.unzip();
        Ok(Pairs { numeric, x, y })
    }
}

/// Sample of an outcome.
pub(super) struct Sample {
    /// The values in ascending order.
    pub(super) ordered: Vec<f64>,
    /// Number of draws that the values are from.
    draws: usize,
}

impl Sample {
    pub(super) fn quantile(&self, q: f64) -> Option<Estimate> {
        quantile(&self.ordered, self.draws, q)
    }
}

/// Values of a factor (x) and an outcome (y) in the same rows.
pub(super) struct Pairs {
    pub(super) numeric: bool,
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
}
