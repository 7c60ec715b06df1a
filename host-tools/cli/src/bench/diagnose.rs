//! How often a diagnosis is right, on logs with effects that are known to whoever hid them.
//!
//! The logs come from a generator that knows nothing of this program's own effects, or from a
//! folder of docking-rig-log/1 cases with their `truth.json`.

use anyhow::Context;
use rayon::prelude::*;
use serde::Serialize;
use softdock_analysis::diagnose::{self, Diagnosis};
use softdock_analysis::import::{ImportedLogs, docking_rig_log};
use softdock_hidden_effects::score::{Answer, Rate, Scores, error_drop_percent};
use softdock_hidden_effects::{CaseSpec, Level, Truth, Verdict, parse_truth};
use std::path::Path;

/// One case with what was said about it.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub level: Level,
    /// Size of the effect, 1 being well visible.
    pub size: f64,
    /// What is hidden.
    pub hidden: Vec<String>,
    /// What was said.
    pub verdict: Verdict,
    /// The effects that were named.
    pub effects: Vec<String>,
    /// Verdict and effects are right.
    pub right: bool,
    /// Share of the removable error that is gone on unseen data, %.
    pub drop_percent: Option<f64>,
    /// Time of the diagnosis, s.
    pub seconds: f64,
    /// The diagnosis in a sentence.
    pub sentence: String,
}

/// Rows and scores.
#[derive(Clone, Debug, Default)]
pub struct Bench {
    /// All cases.
    pub rows: Vec<Row>,
    /// Scores as the log format defines them.
    pub scores: Scores,
}

/// Diagnoses generated cases, two at a time; `done` is called after each.
pub fn generated(specs: &[CaseSpec], done: &(dyn Fn() + Sync)) -> anyhow::Result<Bench> {
    let results: Vec<anyhow::Result<(String, Truth, Answer, String)>> = specs
        .par_iter()
        .map(|spec| {
            let case = spec.generate();
            let logs = docking_rig_log::from_text(&case.meta_json, &case.train_csv, &case.test_csv)
                .with_context(|| format!("case {}", case.name))?;
            let diagnosis = judge(&logs)?;
            done();
            let sentence = diagnosis.sentence.clone();
            Ok((case.name, case.truth, answer(&diagnosis), sentence))
        })
        .collect();
    collect(results)
}

/// Diagnoses the cases of a folder with a `truth.json`.
///
/// # Errors
///
/// A folder without truth, or cases that cannot be read.
pub fn folder(path: &Path, done: &(dyn Fn() + Sync)) -> anyhow::Result<Bench> {
    let results = truths(path)?
        .into_par_iter()
        .map(|(name, truth)| {
            let logs = docking_rig_log::read(&path.join(&name))?;
            let diagnosis = judge(&logs)?;
            done();
            let sentence = diagnosis.sentence.clone();
            Ok((name, truth, answer(&diagnosis), sentence))
        })
        .collect();
    collect(results)
}

/// Cases of a folder with their answers.
///
/// # Errors
///
/// No `truth.json`, or one that cannot be read.
pub fn truths(path: &Path) -> anyhow::Result<Vec<(String, Truth)>> {
    let file = path.join("truth.json");
    let text = std::fs::read_to_string(&file).with_context(|| {
        format!(
            "cannot read {}: expected a folder with cases and their truth.json",
            file.display()
        )
    })?;
    let truths = parse_truth(&text).with_context(|| format!("{}", file.display()))?;
    Ok(truths.into_iter().collect())
}

fn judge(logs: &ImportedLogs) -> anyhow::Result<Diagnosis> {
    let report = diagnose::diagnose(&logs.model, &[&logs.train], &[&logs.test], &|_, _| {})?;
    Ok(report.diagnosis)
}

fn answer(diagnosis: &Diagnosis) -> Answer {
    let after = &diagnosis.residual_rms_sigma.after;
    Answer {
        verdict: match diagnosis.verdict {
            diagnose::Verdict::Named => Verdict::Named,
            diagnose::Verdict::NothingMissing => Verdict::NothingMissing,
            diagnose::Verdict::Unexplained => Verdict::Unexplained,
            diagnose::Verdict::LogsDisagree => Verdict::LogsDisagree,
            diagnose::Verdict::NotTestable => Verdict::NotTestable,
        },
        effects: diagnosis.effects.clone(),
        test_rms: [
            after.executed_velocity,
            after.wrench,
            after.model_velocity,
            after.pose,
        ],
        seconds: diagnosis.seconds,
    }
}

fn collect(results: Vec<anyhow::Result<(String, Truth, Answer, String)>>) -> anyhow::Result<Bench> {
    let mut bench = Bench::default();
    for result in results {
        let (name, truth, answer, sentence) = result?;
        bench.scores.add(&truth, Some(&answer));
        let mut named = answer.effects.clone();
        named.sort();
        let mut hidden = truth.effects.clone();
        hidden.sort();
        let right = answer.verdict == truth.expected
            && (answer.verdict != Verdict::Named || named == hidden);
        bench.rows.push(Row {
            drop_percent: error_drop_percent(&truth, &answer),
            name,
            level: truth.level,
            size: truth.size,
            hidden: truth.effects,
            verdict: answer.verdict,
            effects: answer.effects,
            right,
            seconds: answer.seconds,
            sentence,
        });
    }
    Ok(bench)
}

/// The scores with their names.
pub fn rates(scores: &Scores) -> [(&'static str, Rate); 8] {
    [
        ("single effect first", scores.single_top1),
        ("single effect among three", scores.single_top3),
        ("compound, exact pair", scores.compound_exact),
        ("compound, one of the pair", scores.compound_any),
        ("nothing hidden, clean", scores.null_clean),
        ("outside, unexplained", scores.outside_unexplained),
        ("verdict and effects exact", scores.rank_all_correct),
        ("90 % of the error gone", scores.drop_of_90_percent()),
    ]
}
