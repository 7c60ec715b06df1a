//! docking-rig-log/1: a folder with `meta.json` (the nominal model) and two logs as CSV, one to
//! fit on and one to test on.
//!
//! Each row is a controller tick: raw sensor wrench, velocities sent and executed, pose, and the
//! velocity of the rig's own model; SI units, linear velocities in C, angular ones in M. There
//! are no robot telegrams, no sample counters and no board settings in it; the recordings
//! leave them empty.

mod meta;
mod model;
mod rows;
#[cfg(test)]
mod tests;
mod tolerance;

use super::ImportedLogs;
use super::checks::{self, Context as CheckContext};
use anyhow::{Context, anyhow};
use meta::Meta;
use std::path::Path;

/// Name of the format in `meta.json`.
pub const FORMAT: &str = "docking-rig-log/1";

/// File with the nominal model.
pub const META: &str = "meta.json";

/// Reads a folder.
///
/// # Errors
///
/// A file that cannot be read, or what [`from_text`] reports.
pub fn read(folder: &Path) -> anyhow::Result<ImportedLogs> {
    let text = |name: &str| {
        let path = folder.join(name);
        std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))
    };
    let meta_json = text(META)?;
    let meta = Meta::parse(&meta_json).with_context(|| folder.display().to_string())?;
    let (train, test) = (text(&meta.logs.train)?, text(&meta.logs.test)?);
    logs(&meta, &train, &test).with_context(|| folder.display().to_string())
}

/// Reads the texts of `meta.json` and of the two logs.
///
/// # Errors
///
/// Text that is not of the format; the error names file, line, column, what was expected and what
/// was received. A value out of its range. A log that no comparison could use.
pub fn from_text(meta_json: &str, train_csv: &str, test_csv: &str) -> anyhow::Result<ImportedLogs> {
    logs(&Meta::parse(meta_json)?, train_csv, test_csv)
}

fn logs(meta: &Meta, train_csv: &str, test_csv: &str) -> anyhow::Result<ImportedLogs> {
    let mut warnings: Vec<String> = meta
        .unknown_fields()
        .into_iter()
        .map(|field| format!("meta.json: the field `{field}` is not known and not used"))
        .collect();
    let model = model::model(meta, &mut warnings)?;
    let mut log = |file: &str, text: &str| {
        let mut recording = rows::rows(file, text, meta.sample_time_s)?;
        recording.header.identity = match &meta.case {
            Some(case) => format!("{FORMAT}, {case}, {file}"),
            None => format!("{FORMAT}, {file}"),
        };
        let context = CheckContext {
            name: file,
            sample_time_s: Some(meta.sample_time_s),
            fewest_rows: None,
            imports: true,
            model: Some(&model),
        };
        let told =
            checks::check(&recording, &context).map_err(|error| anyhow!(without_mapping(error)))?;
        warnings.extend(told.into_iter().map(without_mapping));
        anyhow::Ok(recording)
    };
    let train = log(&meta.logs.train, train_csv)?;
    let test = log(&meta.logs.test, test_csv)?;
    let named = [
        (meta.logs.train.as_str(), &train),
        (meta.logs.test.as_str(), &test),
    ];
    let told = checks::signs(&named, Some(&model));
    warnings.extend(told.into_iter().map(without_mapping));
    Ok(ImportedLogs {
        model,
        train,
        test,
        warnings,
    })
}

/// Completes the message of a check that refers to a mapping: this format has none.
fn without_mapping(said: impl ToString) -> String {
    let said = said.to_string();
    match said.contains(" mapping") {
        true => format!("{said} ({FORMAT} has no mapping and is in SI: change the log)"),
        false => said,
    }
}
