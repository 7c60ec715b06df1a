//! Caches of recordings and predictions: a page asks for many channels of one recording.

use super::folder::{Folder, FolderFile};
use super::problem::Problem;
use anyhow::{Context, Result};
use serde::Serialize;
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use softdock_physics::model::prediction::{Prediction, predict};
use std::fs::File;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// Number of cycles that are cached in addition to the file that was read last; each takes about 2 kB.
const KEPT_CYCLES: usize = 250_000;

/// Description of a recording, or why it cannot be read.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub(super) enum About {
    Read {
        cycles: usize,
        duration_s: f64,
        cycle_s: f64,
        /// Equal for recordings with equal settings of the board.
        settings_hash: String,
        firmware: String,
        /// Why the file ended early; None if it is complete.
        truncated: Option<String>,
    },
    Broken {
        error: String,
    },
}

/// Recordings, descriptions and predictions that were used last.
#[derive(Default)]
pub(super) struct Files {
    abouts: Recent<(String, u64, u64), About>,
    recordings: Recent<(String, u64, u64), Recording>,
    predictions: Recent<(String, u64, u64, String), Prediction>,
}

impl Files {
    /// A recording in the present version of its file.
    ///
    /// # Errors
    ///
    /// The id names no file, or the file is no recording.
    pub(super) fn recording(&self, folder: &Folder, id: &str) -> Result<Arc<Recording>, Problem> {
        let path = folder.file(id, "mcap")?;
        let (bytes, changed) = stamp(&path)?;
        let key = (id.to_owned(), bytes, changed);
        let read = || Recording::open(&path);
        self.recordings.get(key, read, |r| r.cycles.len())
    }

    /// Description of a listed recording. It is computed once, and again when the file changes.
    ///
    /// # Errors
    ///
    /// The file cannot be opened. This is not cached, as it may change without a change of the file.
    pub(super) fn about(
        &self,
        found: &FolderFile,
        look: impl FnOnce() -> About,
    ) -> Result<About, Problem> {
        let key = (found.id.clone(), found.bytes, found.changed_s);
        let opened = || {
            let open = File::open(&found.path);
            open.with_context(|| format!("cannot read {}", found.path.display()))?;
            Ok(look())
        };
        Ok((*self.abouts.get(key, opened, |_| 1)?).clone())
    }

    /// Prediction of a recording by a model.
    ///
    /// # Errors
    ///
    /// Those of [`Self::recording`], and a recording that cannot be predicted.
    pub(super) fn prediction(
        &self,
        folder: &Folder,
        model: &Model,
        id: &str,
    ) -> Result<Arc<Prediction>, Problem> {
        let recording = self.recording(folder, id)?;
        let (bytes, changed) = stamp(&folder.file(id, "mcap")?)?;
        let key = (id.to_owned(), bytes, changed, model.to_toml());
        let of = || predict(model, &recording);
        self.predictions.get(key, of, |p| p.time_s.len())
    }
}

/// Size and time of a file, from which a change is recognised.
fn stamp(path: &Path) -> Result<(u64, u64), Problem> {
    let about = std::fs::metadata(path).map_err(anyhow::Error::from)?;
    let mut hasher = DefaultHasher::new();
    about
        .modified()
        .map_err(anyhow::Error::from)?
        .hash(&mut hasher);
    Ok((about.len(), hasher.finish()))
}

/// A short fingerprint of a text, from which a change is recognised.
pub(super) fn fingerprint(text: &str) -> String {
    let mut hasher = DefaultHasher::new();
    text.hash(&mut hasher);
    format!("{:016x}", hasher.finish())
}

/// A cache of the values that were used last, the newest at the end.
struct Recent<K, V>(Mutex<Vec<(K, Arc<V>, usize)>>);

impl<K, V> Default for Recent<K, V> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<K: PartialEq, V> Recent<K, V> {
    /// The value of a key, computed if it is not cached; `cycles` is its size for the limit of memory.
    fn get(
        &self,
        key: K,
        make: impl FnOnce() -> Result<V>,
        cycles: impl FnOnce(&V) -> usize,
    ) -> Result<Arc<V>, Problem> {
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        {
            let mut kept = lock();
            if let Some(place) = kept.iter().position(|one| one.0 == key) {
                let found = kept.remove(place);
                let value = found.1.clone();
                kept.push(found);
                return Ok(value);
            }
        }
        let value = Arc::new(make()?);
        let size = cycles(&value);
        let mut kept = lock();
        while kept.iter().map(|one| one.2).sum::<usize>() > KEPT_CYCLES {
            kept.remove(0);
        }
        kept.push((key, value.clone(), size));
        Ok(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A network folder that is away for a moment changes neither size nor time of a file, so that error is not cached; an
    /// error in the file is.
    #[test]
    fn a_file_that_could_not_be_opened_is_looked_at_again() {
        let folder = tempfile::tempdir().unwrap();
        let found = FolderFile {
            id: "run.mcap".to_owned(),
            path: folder.path().join("run.mcap"),
            bytes: 3,
            changed_s: 0,
        };
        let files = Files::default();
        let broken = |error: &str| About::Broken {
            error: error.to_owned(),
        };
        let said = |about: About| serde_json::to_value(about).unwrap()["error"].clone();
        let problem = files.about(&found, || broken("not opened")).unwrap_err();
        assert!(problem.sentence().contains("cannot read"), "{problem:?}");
        std::fs::write(&found.path, "???").unwrap();
        for now in ["no recording", "not looked at"] {
            assert_eq!(
                said(files.about(&found, || broken(now)).unwrap()),
                "no recording"
            );
        }
    }
}
