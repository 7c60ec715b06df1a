//! The recordings of a fit, checked before it.

use super::record::Names;
use super::{excitation, same_rig};
use crate::held_back::all_held_back;
use crate::import::checks::{Context, check, signs};
use anyhow::{Result, ensure};
use softdock_app::record::CycleRecord;
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Recordings to fit, and unseen ones, if there are any.
#[derive(Clone, Debug)]
pub struct Logs {
    /// Recordings to fit.
    pub train: Vec<Recording>,
    /// Unseen recordings.
    pub test: Vec<Recording>,
    /// Names as the user gave them. Without an unseen recording the name for `test` is that of the end of `train`, if it can be
    /// held back.
    pub names: Names,
    /// What the user should know about them.
    pub notes: Vec<String>,
}

impl Logs {
    /// Reads and checks them.
    ///
    /// # Errors
    ///
    /// A file that is no recording, one from which nothing can be concluded, or the same file twice.
    pub fn open(model: &Model, train: &[PathBuf], test: &[PathBuf]) -> Result<Self> {
        refuse_twice(train.iter().chain(test))?;
        let mut reader = Reader {
            model,
            notes: Vec::new(),
            lacking: Vec::new(),
        };
        let (train_logs, test_logs) = (reader.all(train)?, reader.all(test)?);
        let mut notes = reader.notes();
        let (train, test) = (names(train), names(test));
        let all_names = train.iter().chain(&test).map(String::as_str);
        let named: Vec<(&str, &Recording)> =
            all_names.zip(train_logs.iter().chain(&test_logs)).collect();
        refuse_copies(&named)?;
        notes.extend(signs(&named, Some(model)));
        notes.extend(same_rig::differences(&named));
        let logs = Self {
            names: Names::default(),
            train: train_logs,
            test: test_logs,
            notes,
        };
        Ok(logs.named(&train, &test))
    }

    /// The same logs under other names.
    pub fn named(self, train: &[String], test: &[String]) -> Self {
        let test = match test {
            [] => all_held_back(&self.fitted()).map(|_| format!("{}, its end", train.join(", "))),
            test => Some(test.join(", ")),
        };
        let train = train.join(", ");
        Self {
            names: Names { train, test },
            ..self
        }
    }

    /// Recordings to fit.
    pub fn fitted(&self) -> Vec<&Recording> {
        self.train.iter().collect()
    }

    /// Those that are unseen, if there are any.
    pub fn unseen_ones(&self) -> Vec<&Recording> {
        self.test.iter().collect()
    }

    /// Logs to fit and logs to judge. Without unseen logs the end of each log is held back; where that is not possible the fitted
    /// logs are also those that are judged.
    pub(crate) fn parted(&self) -> [Vec<Cow<'_, Recording>>; 2] {
        let held_back = match self.test.is_empty() {
            true => all_held_back(&self.fitted()),
            false => None,
        };
        if let Some(halves) = held_back {
            let halves = halves.into_iter();
            let (starts, ends) = halves
                .map(|(start, end)| (Cow::Owned(start), Cow::Owned(end)))
                .unzip();
            return [starts, ends];
        }
        let test = if self.test.is_empty() {
            &self.train
        } else {
            &self.test
        };
        [&self.train, test].map(|logs| logs.iter().map(Cow::Borrowed).collect())
    }

    /// `error` of the judged logs of [`Self::parted`] if these are unseen data, otherwise None.
    pub(crate) fn on_unseen(&self, error: f64) -> Option<f64> {
        let is_unseen = !self.test.is_empty() || self.names.test.is_some();
        is_unseen.then_some(error)
    }

    /// The recording whose settings a report shows.
    pub fn judged(&self) -> &Recording {
        self.test.first().unwrap_or(&self.train[0])
    }

    /// In sentences the name of what is judged: unseen data where there is some.
    pub fn judged_name(&self) -> &str {
        self.names.test.as_ref().unwrap_or(&self.names.train)
    }
}

fn names(paths: &[PathBuf]) -> Vec<String> {
    let names = paths.iter().map(|path| path.display().to_string());
    names.collect()
}

/// Reads and checks one recording after the other.
struct Reader<'a> {
    model: &'a Model,
    notes: Vec<String>,
    /// What logs lack, each with the names of the logs that lack it.
    lacking: Vec<(String, Vec<String>)>,
}

impl Reader<'_> {
    fn all(&mut self, paths: &[PathBuf]) -> Result<Vec<Recording>> {
        paths.iter().map(|path| self.read(path)).collect()
    }

    fn read(&mut self, path: &Path) -> Result<Recording> {
        let name = path.display().to_string();
        let recording = Recording::open(path)?;
        self.notes
            .extend(recording.notes().map(|note| format!("{name}: {note}")));
        let context = Context {
            name: &name,
            sample_time_s: None,
            fewest_rows: None,
            imports: false,
            model: Some(self.model),
        };
        self.notes.extend(check(&recording, &context)?);
        for lack in excitation::missing(self.model, &recording, &name)? {
            match self.lacking.iter_mut().find(|(known, _)| *known == lack) {
                Some((_, names)) => names.push(name.clone()),
                None => self.lacking.push((lack, vec![name.clone()])),
            }
        }
        Ok(recording)
    }

    /// Notes on all recordings that were read.
    fn notes(self) -> Vec<String> {
        let lacking = self.lacking.into_iter();
        let lacking = lacking.map(|(lack, names)| format!("{}: {lack}", names.join(", ")));
        self.notes.into_iter().chain(lacking).collect()
    }
}

/// References to recordings.
pub(crate) fn refs<'a>(logs: &'a [Cow<'_, Recording>]) -> Vec<&'a Recording> {
    logs.iter().map(AsRef::as_ref).collect()
}

/// Refuses copies of a recording, which would be no unseen data either: no two measurements have the same noise.
fn refuse_copies(named: &[(&str, &Recording)]) -> Result<()> {
    let measured = |cycle: &CycleRecord| {
        let wrench = cycle.inputs.sensor.wrench.map(f64::to_bits);
        (
            cycle.trace.time_s.to_bits(),
            cycle.trace.pose.map(f64::to_bits),
            wrench,
        )
    };
    for (k, (name, log)) in named.iter().enumerate() {
        for (other, before) in &named[..k] {
            let (ours, theirs) = (log.cycles.iter(), before.cycles.iter());
            ensure!(
                !ours.map(measured).eq(theirs.map(measured)),
                "{name} holds the same cycles as {other}: give another measurement, or leave it out"
            );
        }
    }
    Ok(())
}

/// Refuses a file that is given twice: a log that was fitted is no unseen data.
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
