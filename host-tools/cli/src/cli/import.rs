//! `softdock import`: logs of other rigs, and tables of our own, as recordings.

use super::{answer, print};
use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use serde::Serialize;
use softdock_analysis::import::summary::Summary;
use softdock_analysis::import::{docking_rig_log, mapping, model_text, starter};
use softdock_io::input::refuse_overwrite_of;
use softdock_io::output::write_whole;
use softdock_io::recording::{Recording, import_csv};
use softdock_io::say;
use std::path::{Path, PathBuf};

/// Read logs of a rig into recordings, with a model to start from.
#[derive(Debug, Args)]
#[command(after_help = "\
Example: softdock import rig-logs -o imported
(a docking-rig-log/1 folder; writes model.toml, train.mcap and test.mcap)

softdock import log.csv --mapping mapping.toml -o imported
(any table; the mapping says which column is what; writes train.mcap, or train1.mcap, train2.mcap
.. where it names several logs, and model.toml to start from if it names no model)

softdock import --template > mapping.toml
(a mapping with all keys, each with what it means; keep what the table has)

softdock import run.csv -o imported
(a table that `softdock export` wrote, with its JSON beside it; writes run.mcap)")]
pub(super) struct Import {
    /// Folder or table to read
    #[arg(required_unless_present = "template")]
    path: Option<PathBuf>,
    /// What the columns of the table are (TOML)
    #[arg(long, value_name = "FILE.toml")]
    mapping: Option<PathBuf>,
    /// Print a mapping with all keys to start from
    #[arg(long, exclusive = true)]
    template: bool,
    /// Folder to write into
    #[arg(short, long, value_name = "DIR", required_unless_present = "template")]
    output: Option<PathBuf>,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

/// A mapping with all its keys.
const TEMPLATE: &str = include_str!("../../../../examples/mapping.toml");

/// Result of an import: file names with their content, and warnings for the user.
#[derive(Default)]
struct Imported {
    recordings: Vec<(PathBuf, Recording)>,
    model_toml: Option<String>,
    /// Channels that were not measured, each with what it was computed from.
    derived: Vec<(&'static str, &'static str)>,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct Written {
    files: Vec<PathBuf>,
    cycles: usize,
    logs: Vec<Summary>,
    warnings: Vec<String>,
}

impl Import {
    pub(super) fn execute(self) -> Result<()> {
        let (Some(path), Some(output)) = (&self.path, &self.output) else {
            return print(TEMPLATE);
        };
        let imported = self.read(path)?;
        for warning in &imported.warnings {
            say!("warning: {warning}");
        }
        let written = self.write(imported, path, output)?;
        answer(self.json, &written, || {
            let logs: Vec<String> = written.logs.iter().map(Summary::text).collect();
            format!("{}\n", logs.join("\n").trim_end())
        })
    }

    fn read(&self, path: &Path) -> Result<Imported> {
        ensure!(
            path.exists(),
            "{}: no such file or folder; import reads a docking-rig-log/1 folder, a table that `softdock export` wrote \
             (RUN.csv with RUN.json beside it), or any table with --mapping FILE.toml",
            path.display()
        );
        if let Some(mapping) = &self.mapping {
            return mapped(path, mapping);
        }
        if path.is_dir() {
            return rig_log(path);
        }
        if path.file_name().is_some_and(|n| n == docking_rig_log::META) {
            return rig_log(path.parent().unwrap_or(Path::new(".")));
        }
        if path.extension().is_some_and(|e| e == "mcap") {
            bail!(
                "{} is a recording already; give it to `softdock compare` as it is",
                path.display()
            );
        }
        let name = path.file_stem().context("the table has no name")?;
        let recording = import_csv(path)?;
        // Dots in the name stay: trial.07.csv becomes trial.07.mcap.
        let mut name = name.to_owned();
        name.push(".mcap");
        Ok(Imported {
            recordings: vec![(name.into(), recording)],
            ..Imported::default()
        })
    }

    fn write(&self, imported: Imported, source: &Path, output: &Path) -> Result<Written> {
        let path = |name: &Path| output.join(name);
        let model = imported
            .model_toml
            .map(|text| (path(Path::new("model.toml")), text));
        let recordings: Vec<(PathBuf, Recording)> = imported
            .recordings
            .into_iter()
            .map(|(name, recording)| (path(&name), recording))
            .collect();
        let names = model.iter().map(|(name, _)| name);
        let files: Vec<PathBuf> = names
            .chain(recordings.iter().map(|(name, _)| name))
            .cloned()
            .collect();
        let inputs: Vec<&Path> = [Some(source), self.mapping.as_deref()]
            .into_iter()
            .flatten()
            .collect();
        for file in &files {
            refuse_overwrite_of(&inputs, file, self.force)?;
        }
        std::fs::create_dir_all(output)
            .with_context(|| format!("cannot create {}", output.display()))?;
        if let Some((file, text)) = model {
            write_whole(&file, text)?;
        }
        let (mut cycles, mut logs) = (0, Vec::new());
        for (file, recording) in &recordings {
            recording.write(file)?;
            cycles += recording.cycles.len();
            let name = file.display().to_string();
            logs.push(Summary::of(&name, recording, &imported.derived));
        }
        Ok(Written {
            files,
            cycles,
            logs,
            warnings: imported.warnings,
        })
    }
}

fn rig_log(folder: &Path) -> Result<Imported> {
    let logs = docking_rig_log::read(folder)?;
    let origin = logs.train.header.identity.clone();
    Ok(Imported {
        model_toml: Some(model_text::commented(&logs.model, &origin)),
        recordings: vec![
            ("train.mcap".into(), logs.train),
            ("test.mcap".into(), logs.test),
        ],
        derived: Vec::new(),
        warnings: logs.warnings,
    })
}

fn mapped(path: &Path, mapping_file: &Path) -> Result<Imported> {
    let mut logs = mapping::import(path, mapping_file)?;
    let model_toml = match logs.model {
        Some((_, text)) => text,
        None => {
            let starter = starter::starter(&logs.train, logs.filtered.as_ref(), &logs.told)?;
            logs.warnings.extend(starter.guessed);
            starter.text
        }
    };
    let mut recordings = named("train", logs.train);
    recordings.extend(named("test", logs.test));
    Ok(Imported {
        recordings,
        model_toml: Some(model_toml),
        derived: logs.derived,
        warnings: logs.warnings,
    })
}

/// File names of recordings: numbered from 1, if there are several.
fn named(kind: &str, logs: Vec<Recording>) -> Vec<(PathBuf, Recording)> {
    let number = |n: usize| match logs.len() {
        1 => String::new(),
        _ => n.to_string(),
    };
    let names: Vec<PathBuf> = (1..=logs.len())
        .map(|n| format!("{kind}{}.mcap", number(n)).into())
        .collect();
    names.into_iter().zip(logs).collect()
}
