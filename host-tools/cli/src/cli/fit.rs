//! `softdock fit`: all parameters of a model together, on a recording.

use super::answer;
use super::logs;
use super::progress::Progress;
use anyhow::{Result, bail};
use clap::Args;
use softdock_analysis::fit::judged::Judged;
use softdock_analysis::fit::{Logs, Refitted, Undetermined};
use softdock_io::shell::quoted;
use softdock_physics::model::edit::ModelFile;
use softdock_report::{Cell, Column, Table};
use std::path::PathBuf;

/// Significant digits of values.
const DIGITS: usize = 5;

/// Fit all parameters of a model anew, together: those of its effects, and the nominal ones within
/// their tolerances.
///
/// What the log does not determine keeps its value, and the reason is said. So does a nominal value
/// that did not change significantly, and one with which the rig's own controller works (tool, zero
/// of the sensor): an error there is an effect to be added. Without --write nothing is changed.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock fit model.toml train.mcap --test test.mcap --write")]
pub(super) struct Fit {
    /// Model file (TOML)
    model: PathBuf,
    /// Recordings to fit on (MCAP), one or several
    #[arg(required = true)]
    train: Vec<PathBuf>,
    /// Recordings to judge on (MCAP); without them the end of TRAIN is held back, if it moves enough
    #[arg(long, value_name = "RECORDING", num_args = 1..)]
    test: Vec<PathBuf>,
    /// Write the values into the model file
    #[arg(long)]
    write: bool,
    /// Write also values that make the error on unseen data larger
    #[arg(long, requires = "write")]
    force: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl Fit {
    pub(super) fn execute(self) -> Result<()> {
        let file = ModelFile::open(&self.model)?;
        let logs = logs::open(file.model(), &self.train, &self.test)?;
        let progress = Progress::of_steps();
        let fit = Judged::fit(file.model(), &logs, &|share, what| {
            progress.show(share, what)
        })?;
        drop(progress);
        let edited = file.edited(&fit.after)?;
        if self.write {
            if let Some(doubt) = fit.doubt.as_ref().filter(|_| !self.force) {
                bail!("{doubt}; nothing was written (--force writes it anyway)");
            }
            edited.save()?;
        }
        answer(
            self.json,
            &fit.document(self.write, &edited.difference()),
            || self.text(&fit, &logs),
        )
    }

    fn text(&self, fit: &Judged, logs: &Logs) -> String {
        let [before, after] = &fit.steps;
        let mut text = format!(
            "In units of the model file's noise the error on {} goes from {:.3} to {:.3}",
            logs.names.train, before.train_error, after.train_error
        );
        if let (Some(before), Some(after)) = (before.test_error, after.test_error) {
            let unseen = logs.judged_name();
            text.push_str(&format!(
                "; on {unseen}, which the fit has not seen, from {before:.3} to {after:.3}"
            ));
        }
        text.push_str(".\n");
        if !fit.parameters.is_empty() {
            text.push_str(&format!("\n{}\n", table(&fit.parameters)));
        }
        text.push_str(&doubts(&fit.undetermined));
        let path = self.model.display();
        for needless in &fit.needless {
            text.push_str(&format!(
                "\n{0} foretells nothing here: without it, all else as it is, the error on {1} is {2:.3}. \
                 `softdock remove {3} {0}` takes it out.\n",
                needless.effect,
                logs.judged_name(),
                needless.test_error,
                quoted(&path)
            ));
        }
        text.push_str(&match &fit.doubt {
            _ if self.write => format!("\nWritten to {path}.\n"),
            None => format!("\n{path} is unchanged; --write writes the values into it.\n"),
            Some(_) => format!(
                "\n{path} is unchanged. The fit does not help: {} is foretold worse. What the model lacks may have moved \
                 the values; `softdock diagnose` says what that may be, and --write --force writes them anyway.\n",
                match fit.steps[1].test_error {
                    Some(_) => "unseen data",
                    None => "the data of the fit",
                }
            ),
        });
        text
    }
}

/// Parameters before and after a fit.
pub(super) fn table(parameters: &[Refitted]) -> Table {
    let mut table = Table::new(vec![
        Column::text("Parameter"),
        Column::text("Unit"),
        Column::number("Before", ""),
        Column::number("After", ""),
        Column::number("95 % interval", ""),
        Column::number("From tolerance", ""),
        Column::text(""),
    ]);
    for p in parameters {
        table.push(vec![
            Cell::text(&p.name),
            Cell::text(&p.unit),
            Cell::number(p.before, DIGITS),
            Cell::number(p.value, DIGITS),
            Cell::interval(p.low, p.high, 2),
            Cell::percent(p.prior_share),
            Cell::text(p.note.as_deref().unwrap_or_default()),
        ]);
    }
    table
}

/// Parameters that the log does not determine, grouped by reason.
fn doubts(undetermined: &[Undetermined]) -> String {
    let mut reasons: Vec<(&str, Vec<&str>)> = Vec::new();
    for one in undetermined {
        match reasons.iter_mut().find(|(reason, _)| *reason == one.reason) {
            Some((_, names)) => names.push(&one.name),
            None => reasons.push((&one.reason, vec![&one.name])),
        }
    }
    let lines = reasons
        .iter()
        .map(|(reason, names)| format!("- {}: {reason}", names.join(", ")));
    let lines: Vec<String> = lines.collect();
    if lines.is_empty() {
        return String::new();
    }
    format!("\nKept as they are:\n{}\n", lines.join("\n"))
}
