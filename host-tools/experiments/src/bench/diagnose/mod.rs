//! How often a diagnosis is right, on logs whose hidden effects are known.
//!
//! The logs come from a generator that knows nothing of this program's own effects, or from a
//! folder of docking-rig-log/1 cases with their `truth.json`.

pub mod coverage;
pub mod nulls;
pub mod tables;
pub mod truth;

use anyhow::Context;
use rayon::prelude::*;
use serde::Serialize;
use softdock_analysis::diagnose::{self, Diagnosis, StrongestEvidence};
use softdock_analysis::import::{ImportedLogs, docking_rig_log};
use softdock_hidden_effects::score::{Answer, Rate, Scores, error_drop_percent};
use softdock_hidden_effects::{
    CaseSpec, Level, NoiseRange, Truth, Verdict, parse_truth, truth_json,
};
use softdock_io::output::write_whole;
use std::collections::BTreeMap;
use std::path::Path;
use truth::Interval;

/// One case and its diagnosis.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub level: Level,
    /// Size of the effect, 1 being well visible; see [`Truth::size`].
    pub size: f64,
    /// Its noise.
    pub noise: NoiseRange,
    /// Ids of the hidden effects.
    pub hidden: Vec<String>,
    /// Verdict of the diagnosis.
    pub verdict: Verdict,
    /// The effects that were named.
    pub effects: Vec<String>,
    /// Whether verdict and effects are right.
    pub right: bool,
    /// Share of the removable error that the answer removes on unseen data, %.
    pub drop_percent: Option<f64>,
    /// Time of the diagnosis, s.
    pub seconds: f64,
    /// The diagnosis in a sentence.
    pub sentence: String,
    /// Probability of each effect that was found.
    pub probability: BTreeMap<String, f64>,
    /// Intervals of hidden effects that were named.
    pub intervals: Vec<Interval>,
    /// Evidence of the strongest effect, named or not.
    pub strongest_evidence: StrongestEvidence,
}

/// Rows and scores.
#[derive(Clone, Debug, Default)]
pub struct Bench {
    /// All cases.
    pub rows: Vec<Row>,
    /// Scores as the log format defines them.
    pub scores: Scores,
}

/// Diagnoses generated cases, as many at a time as there are processors; `done` is called after each.
///
/// # Errors
///
/// Cases that the import refuses.
pub fn generated(specs: &[CaseSpec], done: &(dyn Fn() + Sync)) -> anyhow::Result<Bench> {
    let results: Vec<anyhow::Result<Judged>> = specs
        .par_iter()
        .map(|spec| {
            let judged = judge_generated(spec)?;
            done();
            Ok(judged)
        })
        .collect();
    collect(results)
}

/// Diagnoses one generated case.
///
/// # Errors
///
/// A case that the import refuses.
pub fn one(spec: &CaseSpec) -> anyhow::Result<Row> {
    Ok(judge_generated(spec)?.row)
}

fn judge_generated(spec: &CaseSpec) -> anyhow::Result<Judged> {
    let case = spec.generate();
    let logs = docking_rig_log::from_text(&case.meta_json, &case.train_csv, &case.test_csv)
        .with_context(|| format!("case {}", case.name))?;
    judge(case.name, case.truth, &logs)
}

/// Writes generated cases into a new folder as [`folder`] reads them; `done` is called after each.
///
/// # Errors
///
/// A folder that exists, or that cannot be written.
pub fn write(specs: &[CaseSpec], folder: &Path, done: &(dyn Fn() + Sync)) -> anyhow::Result<()> {
    let named = |what: &Path| format!("cannot write {}", what.display());
    std::fs::create_dir(folder).with_context(|| named(folder))?;
    let one = |spec: &CaseSpec| -> anyhow::Result<(String, Truth)> {
        let case = spec.generate();
        let own = folder.join(&case.name);
        std::fs::create_dir(&own).with_context(|| named(&own))?;
        let texts = [
            ("meta.json", &case.meta_json),
            ("train.csv", &case.train_csv),
            ("test.csv", &case.test_csv),
        ];
        for (name, text) in texts {
            let file = own.join(name);
            write_whole(&file, text)?;
        }
        done();
        Ok((case.name, case.truth))
    };
    let truths: Vec<(String, Truth)> = specs.par_iter().map(one).collect::<Result<_, _>>()?;
    let text = truth_json(truths.iter().map(|(name, truth)| (name.as_str(), truth)));
    write_whole(&folder.join("truth.json"), text)
}

/// Diagnoses cases of a folder, with their answers from [`truths`].
///
/// # Errors
///
/// A case that cannot be read.
pub fn folder(
    path: &Path,
    cases: Vec<(String, Truth)>,
    done: &(dyn Fn() + Sync),
) -> anyhow::Result<Bench> {
    let results = cases
        .into_par_iter()
        .map(|(name, truth)| {
            let logs = docking_rig_log::read(&path.join(&name))?;
            let judged = judge(name, truth, &logs)?;
            done();
            Ok(judged)
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

/// A case with truth and answer.
struct Judged {
    truth: Truth,
    answer: Answer,
    row: Row,
}

fn judge(name: String, truth: Truth, logs: &ImportedLogs) -> anyhow::Result<Judged> {
    let report = diagnose::diagnose(&logs.model, &[&logs.train], &[&logs.test], &|_, _| {})?;
    let diagnosis = report.diagnosis;
    let answer = answer(&diagnosis);
    let sorted = |ids: &[String]| {
        let mut ids = ids.to_vec();
        ids.sort();
        ids
    };
    let right = answer.verdict == truth.expected
        && (answer.verdict != Verdict::Named || sorted(&answer.effects) == sorted(&truth.effects));
    let row = Row {
        name,
        level: truth.level,
        size: truth.size,
        noise: truth.noise,
        hidden: truth.effects.clone(),
        verdict: answer.verdict,
        effects: answer.effects.clone(),
        right,
        drop_percent: error_drop_percent(&truth, &answer),
        seconds: answer.seconds,
        intervals: truth::intervals(&diagnosis, &truth, &logs.model),
        strongest_evidence: diagnosis.strongest_evidence,
        sentence: diagnosis.sentence,
        probability: diagnosis.probability,
    };
    Ok(Judged { truth, answer, row })
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

fn collect(results: Vec<anyhow::Result<Judged>>) -> anyhow::Result<Bench> {
    let mut bench = Bench::default();
    for result in results {
        let judged = result?;
        bench.scores.add(&judged.truth, Some(&judged.answer));
        bench.rows.push(judged.row);
    }
    Ok(bench)
}

/// The scores with their names.
pub fn rates(scores: &Scores) -> [(&'static str, Rate); 11] {
    [
        ("single effect first", scores.single_top1),
        ("single effect among three", scores.single_top3),
        ("compound, exact pair", scores.compound_exact),
        ("compound, one of the pair", scores.compound_any),
        ("three effects, exact", scores.triple_exact),
        ("small effect first", scores.small_top1),
        ("effect in one log, logs disagree", scores.logs_disagree),
        ("nothing hidden, clean", scores.null_clean),
        ("outside, unexplained", scores.outside_unexplained),
        ("verdict and effects exact", scores.rank_all_correct),
        ("90 % of the error gone", scores.drop_of_90_percent()),
    ]
}
