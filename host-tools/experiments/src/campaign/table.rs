//! Rows as a table: conditions, outcomes, success.

use super::bench::Bench;
use super::outcome::{NUMBERS, Outcome, Status};
use super::plan::{Conditions, Plan};
use super::setting;
use serde_json::Value;
use softdock_io::data_table::{DataColumn, DataTable, Values};

/// Name of the column with the index.
pub const INDEX: &str = "index";
/// Name of the column that says whether a run kept its limits.
pub const SUCCESS: &str = "success";
/// Metadata: hash of the plan, and the program.
pub const PLAN: &str = "softdock.plan";
/// See [`PLAN`].
pub const BINARY: &str = "softdock.binary";

/// Columns beside factors and numeric outcomes.
const OTHERS: [&str; 13] = [
    INDEX,
    "seed",
    "status",
    "reason",
    SUCCESS,
    "captured",
    "impacts",
    "cycles",
    "fault",
    "final_mode",
    "hidden",
    "said",
    "right",
];

/// Names that no factor can have.
pub(super) fn own_columns() -> impl Iterator<Item = &'static str> {
    OTHERS
        .into_iter()
        .chain(NUMBERS.iter().map(|number| number.name))
}

/// Whether a run is a success: it went to its end without a fault, and kept every limit.
pub fn is_success(plan: &Plan, outcome: &Outcome) -> bool {
    let kept = |limit: &super::file::Limit| {
        let value = outcome.number(&limit.outcome);
        value.is_some_and(|value| limit.holds(value))
    };
    outcome.status == Status::Completed
        && outcome.fault.is_none()
        && outcome.right != Some(false)
        && plan.campaign.limits.iter().all(kept)
}

/// The table of some rows, in their order.
pub fn table(plan: &Plan, rows: &[(u64, Outcome)]) -> DataTable {
    let conditions: Vec<Conditions> = rows
        .iter()
        .map(|(index, _)| plan.conditions(*index))
        .collect();
    let indices: Vec<u64> = rows.iter().map(|(index, _)| *index).collect();
    let seeds: Vec<u64> = conditions.iter().map(|c| c.seed).collect();
    let mut columns = vec![
        DataColumn::new(INDEX, "1", "of the row in the campaign", indices),
        DataColumn::new("seed", "1", "of the run's noise", seeds),
    ];
    for (place, factor) in plan.factors.iter().enumerate() {
        let values: Vec<&Value> = conditions.iter().map(|c| &c.values[place]).collect();
        let settings = factor.settings.join(", ");
        let unit = setting::unit(&factor.settings[0]);
        columns.push(DataColumn::new(
            &factor.name,
            unit,
            settings,
            factor_values(factor, &values),
        ));
    }
    columns.extend(outcome_columns(plan, rows));
    DataTable {
        columns,
        metadata: vec![
            (PLAN.to_owned(), plan.hash.clone()),
            (BINARY.to_owned(), plan.binary.clone()),
            ("softdock.campaign_toml".to_owned(), plan.texts[0].clone()),
            ("softdock.scenario_toml".to_owned(), plan.texts[1].clone()),
        ],
    }
}

/// Numbers, unless the factor has words.
fn factor_values(factor: &super::plan::PlannedFactor, values: &[&Value]) -> Values {
    let levels = factor.distribution.levels().unwrap_or_default();
    if levels.iter().all(Value::is_number) {
        return values
            .iter()
            .map(|value| value.as_f64())
            .collect::<Vec<_>>()
            .into();
    }
    let text = |value: &&Value| match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    values.iter().map(text).collect::<Vec<_>>().into()
}

fn outcome_columns(plan: &Plan, rows: &[(u64, Outcome)]) -> Vec<DataColumn> {
    fn all<T>(rows: &[(u64, Outcome)], value: impl Fn(&Outcome) -> T) -> Vec<T> {
        rows.iter().map(|(_, outcome)| value(outcome)).collect()
    }
    let word = |outcome: &Outcome| outcome.status.word().to_owned();
    let mut columns = vec![
        DataColumn::new(
            "status",
            "1",
            "completed, refused, failed or panicked",
            all(rows, word),
        ),
        DataColumn::new(
            "reason",
            "1",
            "why it is not completed",
            all(rows, |o| o.reason.clone()),
        ),
        DataColumn::new(
            SUCCESS,
            "1",
            "completed without a fault and within all limits",
            all(rows, |outcome| is_success(plan, outcome)),
        ),
        DataColumn::new(
            "captured",
            "1",
            "the mechanism has captured",
            all(rows, |o| o.captured),
        ),
        DataColumn::new("impacts", "1", "whole impacts", all(rows, |o| o.impacts)),
        DataColumn::new("cycles", "cycles", "that were run", all(rows, |o| o.cycles)),
        DataColumn::new(
            "fault",
            "1",
            "latched at the end",
            all(rows, |o| o.fault.clone()),
        ),
        DataColumn::new(
            "final_mode",
            "1",
            "mode at the end",
            all(rows, |o| o.final_mode.clone()),
        ),
    ];
    if plan.campaign.bench == Some(Bench::Diagnose) {
        columns.extend([
            DataColumn::new(
                "hidden",
                "1",
                "effects in the logs",
                all(rows, |o| o.hidden.clone()),
            ),
            DataColumn::new(
                "said",
                "1",
                "verdict and named effects",
                all(rows, |o| o.said.clone()),
            ),
            DataColumn::new("right", "1", "both are right", all(rows, |o| o.right)),
        ]);
    }
    columns.extend(NUMBERS.iter().map(|number| {
        let unit = setting::unit(number.name);
        DataColumn::new(number.name, unit, number.meaning, all(rows, number.value))
    }));
    columns
}
