//! Result of a campaign in numbers.

use super::limit_results::{LimitResults, limit_results};
use super::place::Place;
use super::plan::Conditions;
use super::results::Results;
use super::setting::unit;
use super::statistics::{Estimate, SobolIndices, rank_correlation, rank_ratio, sobol_indices};
use anyhow::Result;
use serde::Serialize;
use softdock_io::data_table::Values;
use softdock_io::shell::quoted;
use std::collections::BTreeMap;

/// The quantiles that are shown.
pub const QUANTILES: [f64; 3] = [0.05, 0.5, 0.95];
/// Number of the worst rows that are listed.
const WORST: usize = 10;
/// A list with more values than this is not evaluated value by value.
const MOST_GROUPS: usize = 50;
/// Result of a campaign.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Summary {
    /// Title of the campaign.
    pub title: String,
    /// Number of rows.
    pub rows: usize,
    /// Number of draws of these rows; intervals are based on draws.
    pub draws: usize,
    /// Whether no factor is drawn: these rows are all combinations.
    pub exhaustive: bool,
    /// Number of rows that went to their end.
    pub completed: usize,
    /// Reasons of the other rows, with their counts.
    pub failures: BTreeMap<String, usize>,
    /// Share of the runs that kept all limits.
    pub success: Option<Estimate>,
    /// Share of the runs in which the mechanism captured; None if it cannot.
    pub captured: Option<Estimate>,
    /// Each limit, and whether it was kept.
    pub limits: Vec<LimitResults>,
    /// Success for each value of a list or grid.
    pub groups: Vec<Group>,
    /// Quantiles of the outcomes.
    pub outcomes: Vec<OutcomeSummary>,
    /// Name of the outcome that ranks the worst rows.
    pub worst_by: String,
    /// The worst rows.
    pub worst: Vec<WorstRow>,
    /// Correlation of each factor with each outcome that is shown.
    pub sensitivity: Vec<Sensitivity>,
}

/// Rows with one value of a factor.
#[derive(Clone, Debug, Serialize)]
pub struct Group {
    /// Name of the factor.
    pub factor: String,
    /// Its value.
    pub value: String,
    /// Share of successes.
    pub success: Option<Estimate>,
    /// Median of the outcome that ranks rows.
    pub median: Option<Estimate>,
}

/// Quantiles of an outcome.
#[derive(Clone, Debug, Serialize)]
pub struct OutcomeSummary {
    /// Name.
    pub name: &'static str,
    /// Unit of the outcome.
    pub unit: &'static str,
    /// Number of rows that have the outcome.
    pub count: usize,
    /// Quantiles at 5, 50 and 95 %.
    pub quantiles: [Option<Estimate>; 3],
}

/// One of the worst rows.
#[derive(Clone, Debug, Serialize)]
pub struct WorstRow {
    /// Index of the row.
    pub index: u64,
    /// Value of the outcome that ranks rows.
    pub value: f64,
    /// Command that runs the row again.
    pub rerun: String,
}

/// Correlation of a factor with an outcome.
#[derive(Clone, Debug, Serialize)]
pub struct Sensitivity {
    /// Name of the outcome.
    pub outcome: &'static str,
    /// Name of the factor.
    pub factor: String,
    /// Spearman's rank correlation; for words the correlation ratio of the ranks, which has no sign.
    pub rank_correlation: Option<f64>,
    /// Sobol' indices, if the design is one for them.
    pub sobol: Option<SobolIndices>,
}

/// Summarises a campaign; `place` appears in the commands that run a row again.
///
/// # Errors
/// The table is not that of the plan.
pub fn summary(results: &Results<'_>, place: &Place) -> Result<Summary> {
    let success = results.successes()?;
    let words = results
        .words("status")?
        .iter()
        .zip(results.words("reason")?);
    let mut failures = BTreeMap::new();
    for (status, reason) in words.filter(|(status, _)| status.as_deref() != Some("completed")) {
        let [status, reason] = [status, reason].map(|text| text.as_deref().unwrap_or("?"));
        *failures.entry(format!("{status}: {reason}")).or_insert(0) += 1;
    }
    let rows: Vec<usize> = (0..success.len()).collect();
    let captured = results.flags("captured")?;
    let can_capture = rows.iter().copied().filter(|row| captured[*row].is_some());
    let can_capture: Vec<usize> = can_capture.collect();
    let outcomes = results.shown_numbers().map(|number| {
        let sample = results.sample(&rows, results.numbers(number.name)?);
        Ok(OutcomeSummary {
            name: number.name,
            unit: unit(number.name),
            count: sample.ordered.len(),
            quantiles: QUANTILES.map(|q| sample.quantile(q)),
        })
    });
    Ok(Summary {
        title: results.plan.campaign.title.clone(),
        rows: rows.len(),
        draws: results.draws(&rows),
        exhaustive: results.plan.is_exhaustive(),
        completed: success.len() - failures.values().sum::<usize>(),
        failures,
        success: results.share(&rows, |row| success[row]),
        captured: results.share(&can_capture, |row| captured[row] == Some(true)),
        limits: limit_results(results)?,
        groups: groups(results, &success)?,
        outcomes: outcomes.collect::<Result<_>>()?,
        worst_by: results.worst_by().0.to_owned(),
        worst: worst(results, place)?,
        sensitivity: sensitivity(results)?,
    })
}

fn groups(results: &Results<'_>, success: &[bool]) -> Result<Vec<Group>> {
    let measured = results.numbers(results.worst_by().0)?;
    let mut groups = Vec::new();
    for factor in &results.plan.factors {
        let levels = factor.distribution.levels();
        let Some(levels) = levels.filter(|levels| levels.len() <= MOST_GROUPS) else {
            continue;
        };
        let texts: Vec<Option<String>> = match results.table.values(&factor.name)? {
            Values::Text(words) => words.clone(),
            Values::Number(values) => values.iter().map(|v| v.map(|v| v.to_string())).collect(),
            _ => continue,
        };
        for level in levels {
            let value = match &level {
                serde_json::Value::String(text) => text.clone(),
                other => other
                    .as_f64()
                    .map_or_else(|| other.to_string(), |v| v.to_string()),
            };
            let own: Vec<usize> = (0..texts.len())
                .filter(|row| texts[*row].as_ref() == Some(&value))
                .collect();
            groups.push(Group {
                factor: factor.name.clone(),
                success: results.share(&own, |row| success[row]),
                median: results.sample(&own, measured).quantile(0.5),
                value,
            });
        }
    }
    Ok(groups)
}

fn worst(results: &Results<'_>, place: &Place) -> Result<Vec<WorstRow>> {
    let (name, limit) = results.worst_by();
    let badness = |value: f64| match limit {
        Some(limit) => limit.beyond(value),
        None => value.abs(),
    };
    let values = results.numbers(name)?.iter().enumerate();
    let mut rows: Vec<(usize, f64)> = values
        .filter_map(|(row, value)| Some((row, (*value)?)))
        .collect();
    rows.sort_by(|a, b| badness(b.1).total_cmp(&badness(a.1)).then(a.0.cmp(&b.0)));
    let row = |(index, value): (usize, f64)| WorstRow {
        index: index as u64,
        value,
        rerun: match results.plan.campaign.bench {
            Some(bench) => {
                let Conditions { seed, values } = results.plan.conditions(index as u64);
                bench.command(seed, &values)
            }
            None => {
                let place = quoted(place);
                format!("softdock campaign rerun {place} --index {index} -o row-{index}.mcap")
            }
        },
    };
    Ok(rows.into_iter().take(WORST).map(row).collect())
}

fn sensitivity(results: &Results<'_>) -> Result<Vec<Sensitivity>> {
    let mut all = Vec::new();
    for number in results.shown_numbers() {
        let indices = sobol(results, number.name)?;
        let mut drawn = indices.iter();
        for factor in &results.plan.factors {
            let pairs = results.pairs(factor, number.name)?;
            let rank_correlation = if pairs.numeric {
                rank_correlation(&pairs.x, &pairs.y)
            } else {
                let groups: Vec<usize> = pairs.x.iter().map(|x| *x as usize).collect();
                rank_ratio(&groups, &pairs.y)
            };
            let is_drawn = factor.distribution.levels().is_none();
            all.push(Sensitivity {
                outcome: number.name,
                factor: factor.name.clone(),
                rank_correlation,
                sobol: if is_drawn {
                    drawn.next().copied()
                } else {
                    None
                },
            });
        }
    }
    Ok(all)
}

/// Sobol' indices of the drawn factors. Empty unless the design is one for them and all runs of enough samples have the
/// outcome.
fn sobol(results: &Results<'_>, outcome: &str) -> Result<Vec<SobolIndices>> {
    let runs = results.plan.runs_per_sample() as usize;
    if runs == 1 || results.plan.combinations() != 1 {
        return Ok(Vec::new());
    }
    let values = results.numbers(outcome)?;
    let samples: Vec<Vec<f64>> = values
        .chunks(runs)
        .filter_map(|runs| runs.iter().copied().collect::<Option<Vec<f64>>>())
        .collect();
    let whole = samples.len() * 10 >= values.len() / runs * 9;
    Ok(if whole {
        sobol_indices(&samples)
    } else {
        Vec::new()
    })
}
