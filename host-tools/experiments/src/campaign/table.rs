//! Table of rows: conditions, outcomes, success.

use super::bench::Bench;
use super::columns::{BINARY, INDEX, PLAN, SUCCESS};
use super::outcome::{NUMBERS, Outcome, Status};
use super::plan::{Conditions, Plan};
use super::setting;
use serde_json::Value;
use softdock_io::data_table::{DataColumn, DataTable, Values};

/// Whether a run is a success: it went to its end without a fault, kept every limit, and a diagnosis is right.
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

/// Values of a factor: numbers, or words if the factor has words.
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

/// The same value of every row.
fn all<T>(rows: &[(u64, Outcome)], value: impl Fn(&Outcome) -> T) -> Vec<T> {
    rows.iter().map(|(_, outcome)| value(outcome)).collect()
}

/// A column without a unit.
fn plain(name: &str, meaning: &str, values: impl Into<Values>) -> DataColumn {
    DataColumn::new(name, "1", meaning, values)
}

/// Columns on course and end of each run.
fn run_columns(plan: &Plan, rows: &[(u64, Outcome)]) -> Vec<DataColumn> {
    let status = all(rows, |o| o.status.word().to_owned());
    let reason = all(rows, |o| o.reason.clone());
    let success = all(rows, |o| is_success(plan, o));
    let captured = all(rows, |o| o.captured);
    let impacts = all(rows, |o| o.impacts);
    let cycles = all(rows, |o| o.cycles);
    let fault = all(rows, |o| o.fault.clone());
    let final_mode = all(rows, |o| o.final_mode.clone());
    let kept = "completed without a fault and within all limits";
    vec![
        plain("status", "completed, refused, failed or panicked", status),
        plain("reason", "why it is not completed", reason),
        plain(SUCCESS, kept, success),
        plain("captured", "the mechanism has captured", captured),
        plain("impacts", "whole impacts", impacts),
        DataColumn::new("cycles", "cycles", "that were run", cycles),
        plain("fault", "latched at the end", fault),
        plain("final_mode", "mode at the end", final_mode),
    ]
}

/// Columns of a benchmark of the diagnosis: what was hidden, and what the diagnosis answered.
fn diagnosis_columns(rows: &[(u64, Outcome)]) -> [DataColumn; 3] {
    let hidden = all(rows, |o| o.hidden.clone());
    let said = all(rows, |o| o.said.clone());
    let right = all(rows, |o| o.right);
    [
        plain("hidden", "effects in the logs", hidden),
        plain("said", "verdict and named effects", said),
        plain("right", "both are right", right),
    ]
}

fn outcome_columns(plan: &Plan, rows: &[(u64, Outcome)]) -> Vec<DataColumn> {
    let mut columns = run_columns(plan, rows);
    if plan.campaign.bench == Some(Bench::Diagnose) {
        columns.extend(diagnosis_columns(rows));
    }
    columns.extend(NUMBERS.iter().map(|number| {
        let unit = setting::unit(number.name);
        DataColumn::new(number.name, unit, number.meaning, all(rows, number.value))
    }));
    columns
}
