//! The recordings that a fit works with, checked before anything is concluded from them.

use anyhow::Result;
use softdock_analysis::fit::excitation;
use softdock_analysis::fit::record::Names;
use softdock_analysis::import::checks::{Context, check};
use softdock_analysis::model::Model;
use softdock_analysis::recording::Recording;
use std::path::Path;

/// A recording to fit on and, if there is one, a recording that the fit does not see.
pub(super) struct Logs {
    pub(super) train: Recording,
    pub(super) test: Option<Recording>,
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
    /// A file that is no recording, or one from which nothing can be concluded.
    pub(super) fn open(model: &Model, train: &Path, test: Option<&Path>) -> Result<Self> {
        let mut notes = Vec::new();
        let mut read = |path: &Path| -> Result<Recording> {
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
        let logs = (read(train)?, test.map(&mut read).transpose()?);
        for note in &notes {
            eprintln!("warning: {note}");
        }
        let name = train.display().to_string();
        let test = test.map(|path| path.display().to_string());
        Ok(Self {
            train: logs.0,
            test: logs.1,
            names: Names {
                test: Some(test.unwrap_or_else(|| format!("{name}, its end"))),
                train: name,
            },
            notes,
        })
    }

    /// The recording on which errors are judged.
    pub(super) fn judged(&self) -> &Recording {
        self.test.as_ref().unwrap_or(&self.train)
    }

    /// Its name in sentences.
    pub(super) fn unseen(&self) -> &str {
        self.names.test.as_deref().unwrap_or_default()
    }
}
