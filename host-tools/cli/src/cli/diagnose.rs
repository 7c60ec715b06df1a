//! `softdock diagnose`: which physical effect is missing?

pub(super) mod tables;

use super::findings::Telling;
use super::logs;
use super::progress::Progress;
use crate::pages::diagnosis::{Identity, page};
use anyhow::Result;
use clap::Args;
use softdock_analysis::diagnose::{Diagnosis, Report, TOGETHER, diagnose};
use softdock_analysis::fit::Logs;
use softdock_experiments::rehearsal::separation;
use softdock_physics::model::Model;
use std::path::{Path, PathBuf};

/// Find the physical effect that a model lacks: its name and size, "nothing is missing", or where
/// an error without a name shows.
///
/// Every effect of the catalogue is tried as a hypothesis about all logs together. Its parameters are
/// those of TRAIN, and the errors are those on TEST, which the parameters have not seen. Without TEST
/// the end of TRAIN is held back for that, if it moves enough.
#[derive(Debug, Args)]
#[command(after_help = "\
Example: softdock diagnose model.toml train.mcap --test test.mcap --report diagnosis.html
         softdock diagnose model.toml slow.mcap fast.mcap --test a.mcap b.mcap
Then:    softdock add model.toml --fit train.mcap --test test.mcap")]
pub(super) struct Diagnose {
    /// Model file (TOML)
    model: PathBuf,
    /// Recordings to fit on (MCAP), one or several
    #[arg(required = true)]
    train: Vec<PathBuf>,
    /// Recordings to judge on (MCAP), one or several: parameters are those of the others, but these take part in deciding what is
    /// missing; for an error that nothing was decided by, `compare` the model of `add` with another recording
    #[arg(long, value_name = "RECORDING", num_args = 1..)]
    test: Vec<PathBuf>,
    /// Also try on the simulated rig how clearly the experiment tells the effect from its closest
    /// rival (some seconds)
    #[arg(long)]
    rehearse: bool,
    #[command(flatten)]
    telling: Telling,
}

impl Diagnose {
    pub(super) fn execute(self) -> Result<()> {
        let model = Model::load(&self.model)?;
        let inputs = self.train.iter().chain(&self.test).chain([&self.model]);
        let inputs: Vec<&Path> = inputs.map(PathBuf::as_path).collect();
        self.telling.check(&inputs)?;
        let logs = logs::open(&model, &self.train, &self.test)?;
        let progress = Progress::of_steps();
        let mut report = diagnose(
            &model,
            &logs.fitted(),
            &logs.unseen_ones(),
            &|share, what| progress.show(share, what),
        )?;
        if self.rehearse {
            rehearse(&mut report.diagnosis, &progress)?;
        }
        drop(progress);
        let notes = &mut report.diagnosis.notes;
        notes.splice(0..0, logs.notes.iter().cloned());
        self.telling.give(
            &report.diagnosis,
            || self.page(&report, &logs),
            || tables::text(&report.diagnosis),
        )
    }

    fn page(&self, report: &Report, logs: &Logs) -> Result<softdock_report::Page> {
        let header = &logs.judged().header;
        let identity = Identity {
            model_path: self.model.display().to_string(),
            model_toml: report.after.to_toml(),
            train: logs.names.train.clone(),
            test: logs.names.test.clone().filter(|_| !logs.test.is_empty()),
            firmware: header.identity.clone(),
            settings_toml: header.settings_toml.clone(),
        };
        let (before, after) = (&report.before_prediction, &report.after_prediction);
        page(&report.diagnosis, before, after, &identity)
    }
}

/// Tries the proposed experiment on the simulated rig, if there is a rival.
fn rehearse(diagnosis: &mut Diagnosis, progress: &Progress) -> Result<()> {
    let winner = diagnosis.effects.first().cloned();
    // The simulated rig cannot hide a rival that is two effects together.
    let one = |effect: &String| !effect.contains(TOGETHER);
    let rival = diagnosis.runner_up.as_ref().map(|r| r.effect.clone());
    let rival = rival.filter(one);
    let (Some(winner), Some(rival)) = (winner, rival) else {
        return Ok(());
    };
    if let Some(experiment) = &mut diagnosis.experiment {
        let separation = separation(&winner, &rival, &|share, what| {
            progress.show(share, &format!("on the simulated rig: {what}"));
        })?;
        experiment.separation_then = Some(separation);
    }
    Ok(())
}
