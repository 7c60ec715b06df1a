//! `softdock add`: missing effects into the model file, with the error before and after.

use super::diagnose::tables;
use super::progress::Progress;
use super::{answer, fit, logs, print, print_json};
use anyhow::{Result, bail};
use clap::Args;
use softdock_analysis::add::{Addition, add_effects, model_after, refit_beside, useless};
use softdock_analysis::diagnose::{Diagnosis, Report, Verdict, diagnose};
use softdock_analysis::fit::{Logs, Refitted};
use softdock_io::say;
use softdock_physics::model::Model;
use softdock_physics::model::edit::ModelFile;
use std::path::PathBuf;

/// Fit effects and write them into the model file, with their intervals and the error before and
/// after.
///
/// Effects that the model has already are fitted anew beside them, where that foretells unseen data better, and it is said
/// what moved; everything else in the file stays as it is. Without EFFECT, what a diagnosis names is added; several are
/// fitted together. What does not help on unseen data is not written, unless --force says so.
#[derive(Debug, Args)]
#[command(after_help = "\
Example: softdock add model.toml guide_coulomb --fit train.mcap --test test.mcap
         softdock add model.toml guide_coulomb bearing_gravity --fit train.mcap --test test.mcap
         softdock add model.toml --fit train.mcap --test test.mcap --dry-run")]
pub(super) struct Add {
    /// Model file (TOML)
    model: PathBuf,
    /// Effects to add; `softdock effects` lists them
    #[arg(value_name = "EFFECT")]
    effects: Vec<String>,
    /// Recordings to fit on (MCAP), one or several
    #[arg(long, value_name = "RECORDING", num_args = 1.., required = true)]
    fit: Vec<PathBuf>,
    /// Recordings to judge on (MCAP); without them the end of the others is held back, if it moves enough
    #[arg(long, value_name = "RECORDING", num_args = 1..)]
    test: Vec<PathBuf>,
    /// Print the difference to the model file and write nothing
    #[arg(long)]
    dry_run: bool,
    /// Write the effects also if they do not help on unseen data
    #[arg(long)]
    force: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl Add {
    pub(super) fn execute(self) -> Result<()> {
        let file = ModelFile::open(&self.model)?;
        for id in &self.effects {
            file.model().effect(id)?;
        }
        let logs = logs::open(file.model(), &self.fit, &self.test)?;
        let (report, moved) = self.fitted(file.model(), &logs)?;
        if report.diagnosis.effects.is_empty() {
            return self.nothing_to_add(&report.diagnosis);
        }
        let diagnosis = &report.diagnosis;
        let after = model_after(file.model(), &report, &logs.names);
        let edited = file.edited(&after)?;
        let difference = edited.difference();
        let useless = useless(&diagnosis.steps, logs.judged_name());
        if self.dry_run {
            useless.iter().for_each(|reason| say!("warning: {reason}"));
            return self.show(diagnosis, &moved, &logs, &difference, false);
        }
        match useless {
            Some(reason) if !self.force => {
                bail!("{reason}; nothing was written (--force writes it anyway)");
            }
            Some(reason) => say!("warning: {reason}"),
            None => {}
        }
        edited.save()?;
        self.show(diagnosis, &moved, &logs, &difference, true)
    }

    /// Fits the effects to add. Returns the report, and the effects of the model whose parameters changed by the joint fit.
    fn fitted(&self, model: &Model, logs: &Logs) -> Result<(Report, Vec<Refitted>)> {
        let progress = Progress::of_steps();
        let told = |share: f64, what: &str| progress.show(share, what);
        if !self.effects.is_empty() {
            told(0.1, &format!("fitting {}", self.effects.join(", ")));
        }
        match self.effects.as_slice() {
            [] => {
                let mut report = diagnose(model, &logs.fitted(), &logs.unseen_ones(), &told)?;
                let moved = refit_beside(model, &mut report, logs)?;
                Ok((report, moved))
            }
            ids => add_effects(model, ids, logs, self.force),
        }
    }

    fn nothing_to_add(&self, diagnosis: &Diagnosis) -> Result<()> {
        if diagnosis.verdict != Verdict::NothingMissing {
            bail!(
                "nothing was added. {} (--report of `softdock diagnose` shows it, and `softdock add` with ids of effects adds \
                 those)",
                diagnosis.sentence
            );
        }
        let document = Addition {
            diagnosis,
            moved: &[],
            written: false,
            difference: "",
        };
        answer(self.json, &document, || {
            let sentence = &diagnosis.sentence;
            format!("{sentence}\nThe model file stays as it is.\n")
        })
    }

    fn show(
        &self,
        diagnosis: &Diagnosis,
        moved: &[Refitted],
        logs: &Logs,
        difference: &str,
        written: bool,
    ) -> Result<()> {
        if self.json {
            return print_json(&Addition {
                diagnosis,
                moved,
                written,
                difference,
            });
        }
        if self.dry_run {
            return print(difference);
        }
        let path = self.model.display();
        let beside = match moved {
            [] => String::new(),
            moved => format!(
                "\nFitted anew, together with what was added\n{}\n",
                fit::table(moved)
            ),
        };
        print(&format!(
            "Added to {path}: {}.\n{}\n\n{}\n{beside}\nError on {}, in units of the model file's noise\n{}\n",
            diagnosis.effects.join(", "),
            error_reduction(diagnosis, logs),
            tables::parameters(&diagnosis.parameters),
            logs.judged_name(),
            tables::levels(&diagnosis.residual_rms_sigma),
        ))
    }
}

/// How the error falls, in a sentence.
fn error_reduction(diagnosis: &Diagnosis, logs: &Logs) -> String {
    let steps = &diagnosis.steps;
    let (Some(first), Some(last)) = (steps.first(), steps.last()) else {
        return String::new();
    };
    let goes = |before: f64, after: f64| {
        let verb = match after < before {
            true => "falls",
            false => "DOES NOT FALL: it goes",
        };
        format!("{verb} from {before:.3} to {after:.3}")
    };
    let mut text = format!(
        "In units of the model file's noise the error on {} {}",
        logs.names.train,
        goes(first.train_error, last.train_error)
    );
    if let (Some(before), Some(after)) = (first.test_error, last.test_error) {
        text.push_str(&format!(
            "; on {}, {}, it {}",
            logs.judged_name(),
            match diagnosis.of_all_logs {
                Some(_) => "which took part in the fit",
                None => "which the fit has not seen",
            },
            goes(before, after)
        ));
    }
    text.push('.');
    text
}
