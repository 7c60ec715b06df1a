//! The recordings that a fit works with, checked before anything is concluded from them.

use anyhow::{Result, ensure};
use softdock_analysis::fit::excitation;
use softdock_analysis::fit::record::Names;
use softdock_analysis::import::checks::{Context, check};
use softdock_analysis::model::Model;
use softdock_analysis::recording::Recording;
use std::path::PathBuf;

/// Recordings to fit on, and recordings that the fit does not see, if there are any.
pub(super) struct Logs {
    pub(super) train: Vec<Recording>,
    pub(super) test: Vec<Recording>,
    /// As the user gave them; without an unseen recording, `test` is the end of `train`.
    pub(super) names: Names,
    /// What the user should know about them.
    pub(super) notes: Vec<String>,
}

impl Logs {
    /// Reads and checks them; warnings go to standard error too.
    ///
    /// # Errors
    ///
    /// A file that is no recording, one from which nothing can be concluded, or the same file twice.
    pub(super) fn open(model: &Model, train: &[PathBuf], test: &[PathBuf]) -> Result<Self> {
        refuse_twice(train.iter().chain(test))?;
        let mut notes = Vec::new();
        let mut read = |path: &PathBuf| -> Result<Recording> {
            let name = path.display().to_string();
            let recording = Recording::open(path)?;
            if let Some(cut) = &recording.cut {
                notes.push(format!("{name}: {cut}"));
            }
            let context = Context {
                name: &name,
                sample_time_s: None,
                fewest_rows: None,
                model: Some(model),
            };
            notes.extend(check(&recording, &context)?);
            notes.extend(excitation::missing(model, &recording, &name)?);
            Ok(recording)
        };
        let mut all =
            |paths: &[PathBuf]| -> Result<Vec<Recording>> { paths.iter().map(&mut read).collect() };
        let logs = (all(train)?, all(test)?);
        for note in &notes {
            eprintln!("warning: {note}");
        }
        let names = |paths: &[PathBuf]| -> String {
            let names = paths.iter().map(|path| path.display().to_string());
            names.collect::<Vec<_>>().join(", ")
        };
        Ok(Self {
            names: Names {
                test: Some(match test {
                    [] => format!("{}, its end", names(train)),
                    test => names(test),
                }),
                train: names(train),
            },
            train: logs.0,
            test: logs.1,
            notes,
        })
    }

    /// Those to fit on.
    pub(super) fn fitted(&self) -> Vec<&Recording> {
        self.train.iter().collect()
    }

    /// Those that are unseen, if there are any.
    pub(super) fn unseen_ones(&self) -> Vec<&Recording> {
        self.test.iter().collect()
    }

    /// The recording whose settings a report shows.
    pub(super) fn judged(&self) -> &Recording {
        self.test.first().unwrap_or(&self.train[0])
    }

    /// Its name in sentences.
    pub(super) fn unseen(&self) -> &str {
        self.names.test.as_deref().unwrap_or_default()
    }
}

/// A log that a fit has seen says nothing about what it has not.
fn refuse_twice<'a>(paths: impl Iterator<Item = &'a PathBuf>) -> Result<()> {
    let mut seen: Vec<PathBuf> = Vec::new();
    for path in paths {
        let place = path.canonicalize().unwrap_or_else(|_| path.clone());
        ensure!(
            !seen.contains(&place),
            "{} is given twice: a log that was fitted on is no unseen data; give another one, or \
             leave --test out, and the end of the log is held back",
            path.display()
        );
        seen.push(place);
    }
    Ok(())
}
