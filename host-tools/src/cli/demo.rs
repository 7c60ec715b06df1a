//! `softdock demo`: the main job on the simulated rig, in a few seconds.

use super::{print, print_json};
use crate::experiment::demo::{self, MODEL_TOML, Step};
use crate::experiment::impacts::Impact;
use crate::input::refuse_overwrite;
use anyhow::{Context, Result};
use clap::Args;
use serde::Serialize;
use softdock_control::delay::LawName;
use std::path::{Path, PathBuf};

/// Run a docking test, see where the model fails, compensate the delay, and see what changes.
///
/// Everything happens on the simulated rig: no hardware, no set-up, no network.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock demo --seed 7 -o my-demo")]
pub(super) struct Demo {
    /// Folder to write into; without it, the first free one of softdock-demo, softdock-demo-2 ...
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Seed of the simulated noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Overwrite files of an earlier demonstration in the folder
    #[arg(long)]
    force: bool,
    /// Print one JSON document; the story goes to standard error
    #[arg(long)]
    json: bool,
}

impl Demo {
    pub(super) fn execute(self) -> Result<()> {
        let folder = self.output.clone().unwrap_or_else(free_folder);
        let files = Files::in_folder(&folder);
        files.refuse_overwrite(self.force)?;
        std::fs::create_dir_all(&folder)
            .with_context(|| format!("cannot create {}", folder.display()))?;
        std::fs::write(&files.model, MODEL_TOML)
            .with_context(|| format!("cannot write {}", files.model.display()))?;

        self.say(
            "1. A craft of 500 kg flies with 10 mm/s against an elastic stop. It should come back with 10 mm/s.\n",
        )?;
        let none = demo::step(LawName::None, "without compensation", self.seed)?;
        self.say(&outcome(&none))?;
        none.recording.write(&files.none)?;

        self.say(
            "\n2. Compare with a model that believes in a robot without delay. Where does it fail?\n",
        )?;
        self.say(&format!("   {}\n", none.comparison.sentence))?;
        for table in none.comparison.tables() {
            self.say(&format!("\n{table}\n"))?;
        }
        none.comparison.page()?.write(&files.compare)?;

        self.say("\n3. Switch on the delay compensation of the paper, and run again.\n")?;
        let seed = demo::step(LawName::Seed, "paper's compensation", self.seed)?;
        self.say(&outcome(&seed))?;
        seed.recording.write(&files.seed)?;

        let steps = [none, seed];
        demo::page(&steps)?.write(&files.report)?;
        if self.json {
            return print_json(&document(&files, &steps));
        }
        let (table, next) = (demo::table(&steps), files.what_next());
        print(&format!("\n4. Before and after:\n\n{table}\n\n{next}"))
    }

    /// Tells the story: to standard output, unless that is for the JSON document.
    fn say(&self, text: &str) -> Result<()> {
        if self.json {
            eprint!("{text}");
            return Ok(());
        }
        print(text)
    }
}

#[derive(Serialize)]
struct Document<'a> {
    report: &'a Path,
    steps: Vec<StepDocument<'a>>,
}

#[derive(Serialize)]
struct StepDocument<'a> {
    law: LawName,
    recording: &'a Path,
    real_time_factor: f64,
    impact: &'a Impact,
    #[serde(rename = "where")]
    sentence: &'a str,
}

fn document<'a>(files: &'a Files, steps: &'a [Step; 2]) -> Document<'a> {
    let recordings = [&files.none, &files.seed];
    let step = |(step, recording): (&'a Step, &'a PathBuf)| StepDocument {
        law: step.law,
        recording,
        real_time_factor: step.statistics.real_time_factor(),
        impact: &step.impact,
        sentence: &step.comparison.sentence,
    };
    let steps = steps.iter().zip(recordings).map(step).collect();
    Document {
        report: &files.report,
        steps,
    }
}

fn outcome(step: &Step) -> String {
    format!(
        "   It came back with {:.2} mm/s: restitution {:.2}. ({} cycles, {:.0} times real time)\n",
        step.impact.speed_out_mm_s,
        step.impact.restitution,
        step.statistics.cycles,
        step.statistics.real_time_factor(),
    )
}

/// The first folder name that is not taken.
fn free_folder() -> PathBuf {
    let names = (2..).map(|n| PathBuf::from(format!("softdock-demo-{n}")));
    let mut names = std::iter::once(PathBuf::from("softdock-demo")).chain(names);
    names
        .find(|name| !name.exists())
        .unwrap_or_else(|| PathBuf::from("softdock-demo"))
}

/// What the demonstration leaves behind.
struct Files {
    report: PathBuf,
    compare: PathBuf,
    model: PathBuf,
    none: PathBuf,
    seed: PathBuf,
}

impl Files {
    fn in_folder(folder: &Path) -> Self {
        Self {
            report: folder.join("demo.html"),
            compare: folder.join("compare.html"),
            model: folder.join("model.toml"),
            none: folder.join("none.mcap"),
            seed: folder.join("seed.mcap"),
        }
    }

    fn refuse_overwrite(&self, force: bool) -> Result<()> {
        [
            &self.report,
            &self.compare,
            &self.model,
            &self.none,
            &self.seed,
        ]
        .into_iter()
        .try_for_each(|path| refuse_overwrite(path, force))
    }

    fn what_next(&self) -> String {
        let [report, compare, model, none, seed] = [
            &self.report,
            &self.compare,
            &self.model,
            &self.none,
            &self.seed,
        ]
        .map(|path| path.display());
        format!(
            "Report:      {report}
Comparison:  {compare}
Recordings:  {none}, {seed} (they open in Foxglove and PlotJuggler too)
Model:       {model}

Try next:
  tell the model about the delay:  set transport_delay_s = 0.032 in {model}, then
                                   cargo softdock compare {model} {none}
  recompute every correction:      cargo softdock replay {none}
  the paper's whole experiment:    cargo softdock reproduce -o reproduced
  your own test:                   cargo softdock run host-tools/scenarios/spring-rod.toml -o run.mcap
"
        )
    }
}
