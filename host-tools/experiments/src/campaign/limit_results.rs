//! Each limit of a campaign and the outcomes of the runs, for instance with and without the delay law.

use super::file::Limit;
use super::results::Results;
use super::setting::unit;
use super::statistics::Estimate;
use anyhow::Result;
use serde::Serialize;
use softdock_io::data_table::Values;

/// A group of rows.
#[derive(Clone, Debug)]
pub(super) struct Split {
    /// The word that these rows have in common; empty for the group of all rows.
    pub(super) name: String,
    /// For each row of the table, whether it is in the group.
    pub(super) rows: Vec<bool>,
}

/// Groups the rows by the words of the first factor that has words. Without such a factor all rows are one group.
pub(super) fn splits(results: &Results<'_>) -> Result<Vec<Split>> {
    for factor in &results.plan.factors {
        let Values::Text(words) = results.table.values(&factor.name)? else {
            continue;
        };
        let mut known: Vec<&String> = words.iter().flatten().collect();
        known.sort();
        known.dedup();
        let split = |word: &String| Split {
            name: word.clone(),
            rows: words.iter().map(|own| own.as_ref() == Some(word)).collect(),
        };
        return Ok(known.into_iter().map(split).collect());
    }
    Ok(vec![Split {
        name: String::new(),
        rows: vec![true; results.table.rows()],
    }])
}

/// A limit and the outcomes of the runs.
#[derive(Clone, Debug, Serialize)]
pub struct LimitResults {
    /// The limit, with its source.
    #[serde(flatten)]
    pub limit: Limit,
    /// Unit of its bounds.
    pub unit: &'static str,
    /// The outcome in each group of runs: one group per word of the first factor that has words.
    #[serde(rename = "kept")]
    pub results: Vec<LimitResult>,
}

/// An outcome in a group of runs, compared with its limit.
#[derive(Clone, Debug, Serialize)]
pub struct LimitResult {
    /// The word that these runs have in common; empty for all runs.
    #[serde(rename = "of")]
    pub group: String,
    /// The value farthest beyond the limit, or nearest to it if none is beyond: the largest, or for a lower limit the
    /// smallest.
    pub worst: Option<f64>,
    /// The median.
    pub median: Option<Estimate>,
    /// Share of the runs that kept the limit. A run without the outcome did not keep it.
    #[serde(rename = "share")]
    pub share_within: Option<Estimate>,
}

/// All limits of a campaign.
///
/// # Errors
/// The table is not that of the plan.
pub(super) fn limit_results(results: &Results<'_>) -> Result<Vec<LimitResults>> {
    let splits = splits(results)?;
    let of_limit = |limit: &Limit| {
        let all = results.numbers(&limit.outcome)?;
        let each = splits.iter().map(|split| {
            let own: Vec<usize> = (0..all.len()).filter(|row| split.rows[*row]).collect();
            let values = own.iter().filter_map(|row| all[*row]);
            LimitResult {
                group: split.name.clone(),
                worst: values.max_by(|a, b| limit.beyond(*a).total_cmp(&limit.beyond(*b))),
                median: results.sample(&own, all).quantile(0.5),
                share_within: results.share(&own, |row| all[row].is_some_and(|v| limit.holds(v))),
            }
        });
        Ok(LimitResults {
            limit: limit.clone(),
            unit: unit(&limit.outcome),
            results: each.collect(),
        })
    };
    results.plan.campaign.limits.iter().map(of_limit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::outcome::Outcome;
    use crate::campaign::place::Place;
    use crate::campaign::plan::Plan;
    use crate::campaign::summary::summary;
    use crate::campaign::{page, table};
    use crate::scenario::SPRING_ROD;

    const CAMPAIGN: &str = r#"
scenario = "spring-rod.toml"
samples = 4

[[factors]]
name = "speed_m_s"
setting = "board.control.body_k.velocity_m_s[0]"
uniform = [0.005, 0.02]

[[factors]]
name = "law"
setting = "board.control.delay.law"
list = ["none", "lead"]

[[limits]]
outcome = "captured_s"
high = 10.0
source = "chosen here"
source_read = true

[[limits]]
outcome = "shear_n"
low = -50.0
high = 100.0
source = "from memory"
"#;

    fn plan() -> Plan {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("campaign.toml");
        std::fs::write(folder.path().join("spring-rod.toml"), SPRING_ROD).unwrap();
        std::fs::write(&path, CAMPAIGN).unwrap();
        Plan::new(&path).unwrap()
    }

    /// Every second row has the law `lead`: 10, 30, 60 and 99 N with it, 20, 40, 101 and -70 N without.
    #[test]
    fn each_law_against_each_limit() {
        let loads = [20.0, 10.0, 40.0, 30.0, 101.0, 60.0, -70.0, 99.0];
        let rows = loads.iter().enumerate().map(|(row, load)| {
            let outcome = Outcome {
                shear_n: Some(*load),
                captured_s: (row != 2).then_some(row as f64),
                ..Outcome::default()
            };
            (row as u64, outcome)
        });
        let plan = plan();
        let table = table::table(&plan, &rows.collect::<Vec<_>>());
        let results = Results {
            plan: &plan,
            table: &table,
        };
        let limits = limit_results(&results).unwrap();
        let said: Vec<(&str, Option<f64>, f64)> = limits
            .iter()
            .flat_map(|limit| &limit.results)
            .map(|result| {
                (
                    result.group.as_str(),
                    result.worst,
                    result.share_within.unwrap().value,
                )
            })
            .collect();
        assert_eq!(
            said,
            [
                ("lead", Some(7.0), 1.0),
                ("none", Some(6.0), 0.75),
                ("lead", Some(99.0), 1.0),
                // 20 N beyond the lower bound is worse than 1 N beyond the upper one.
                ("none", Some(-70.0), 0.5),
            ]
        );
        let summary = summary(&results, &Place::folder("c".as_ref())).unwrap();
        assert!(
            page::headline(&summary)
                .ends_with("Limits without a source that somebody has read: 1 of 2."),
            "{}",
            page::headline(&summary)
        );
        let (_, shown) = page::tables(&summary).swap_remove(0);
        let shown = shown.to_html();
        assert!(shown.contains(">chosen here<"), "{shown}");
        assert!(shown.contains(">✗ from memory<"), "{shown}");
    }
}
