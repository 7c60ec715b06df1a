//! What the demonstration leaves behind.

use anyhow::{Context, Result};
use softdock_io::input::refuse_overwrite;
use softdock_io::shell::quoted;
use std::path::{Path, PathBuf};

/// The files in the demonstration's folder.
pub(super) struct Files {
    /// Report of the diagnosis.
    pub(super) report: PathBuf,
    /// Comparison with the model as it was.
    pub(super) compare: PathBuf,
    /// The model as it was.
    pub(super) model_before: PathBuf,
    /// The model with the effects.
    pub(super) model: PathBuf,
    /// Settings for the board with the identified robot; written only where a delay law can use it.
    pub(super) board: PathBuf,
    /// Recording that the parameters were fitted to.
    pub(super) train: PathBuf,
    /// Recording that the fit has not seen.
    pub(super) test: PathBuf,
}

impl Files {
    pub(super) fn in_folder(folder: &Path) -> Self {
        Self {
            report: folder.join("diagnose.html"),
            compare: folder.join("compare.html"),
            model_before: folder.join("model-before.toml"),
            model: folder.join("model.toml"),
            board: folder.join("board.toml"),
            train: folder.join("train.mcap"),
            test: folder.join("test.mcap"),
        }
    }

    /// Refuses to overwrite an earlier demonstration, unless `force` is set. Removes the board settings of that
    /// demonstration.
    pub(super) fn make_room(&self, force: bool) -> Result<()> {
        let all = [
            &self.report,
            &self.compare,
            &self.model_before,
            &self.model,
            &self.board,
            &self.train,
            &self.test,
        ];
        all.into_iter()
            .try_for_each(|path| refuse_overwrite(path, force))?;
        // Not every demonstration writes board settings: those of an earlier one would pass for this one's.
        if self.board.exists() {
            std::fs::remove_file(&self.board)
                .with_context(|| format!("cannot remove {}", self.board.display()))?;
        }
        Ok(())
    }

    /// Where all files are, and which commands to try on them.
    pub(super) fn what_next(&self) -> String {
        let [report, compare, before, model, train, test] = [
            &self.report,
            &self.compare,
            &self.model_before,
            &self.model,
            &self.train,
            &self.test,
        ]
        .map(|path| quoted(path.display()));
        let board = if self.board.exists() {
            format!(
                "Board:       {} (its settings)\n",
                quoted(self.board.display())
            )
        } else {
            String::new()
        };
        format!(
            "Report:      {report}
Comparison:  {compare} (with the model as it was)
Model:       {before} -> {model}
{board}Recordings:  {train}, {test} (they open in Foxglove and PlotJuggler too)

Try next:
  the same by hand:             softdock compare {before} {test}
                                softdock diagnose {before} {train} --test {test}
  hide something else:          softdock demo --effect guide_coulomb
  everything that can be hidden: softdock effects
  recompute every correction:   softdock replay {train}
  your own rig:                 softdock import --help
"
        )
    }
}

/// The first folder name that is not taken.
pub(super) fn free_folder() -> PathBuf {
    let names = (2..).map(|n| PathBuf::from(format!("softdock-demo-{n}")));
    let mut names = std::iter::once(PathBuf::from("softdock-demo")).chain(names);
    names
        .find(|name| !name.exists())
        .unwrap_or_else(|| PathBuf::from("softdock-demo"))
}
