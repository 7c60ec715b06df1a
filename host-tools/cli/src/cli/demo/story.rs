//! The story of the demonstration, told while it happens.

use super::files::Files;
use crate::cli::progress::Progress;
use crate::cli::{print, print_json};
use crate::pages::{self, diagnosis::Identity};
use anyhow::Result;
use serde::Serialize;
use softdock_analysis::compare::{Comparison, compare};
use softdock_analysis::diagnose::{Diagnosis, Report, Verdict, diagnose};
use softdock_control::delay::actuator::ActuatorSettings;
use softdock_control::delay::{DelaySettings, LawName, ModelVelocity};
use softdock_experiments::demo::{self, Answer, Bounce, Run};
use softdock_experiments::diagnosis::{self, Part};
use softdock_experiments::impacts::Impact;
use softdock_io::output::write_whole;
use softdock_io::to_standard_error;
use softdock_physics::model::Model;
use softdock_report::Page;
use softdock_report::number::significant;
use softdock_rig::rig::Hidden;
use std::path::Path;

/// Input of the story.
pub(super) struct Story<'a> {
    /// Effects that the rig hides.
    pub(super) hidden: Vec<Hidden>,
    /// Seed of the noise.
    pub(super) seed: u64,
    /// Standard output is for the JSON document: the story goes to standard error.
    pub(super) quiet: bool,
    /// Where everything is written.
    pub(super) files: &'a Files,
}

/// The two recordings.
struct Recordings {
    train: Run,
    test: Run,
}

impl Story<'_> {
    pub(super) fn tell(&self) -> Result<()> {
        let model = diagnosis::model()?;
        let runs = self.run()?;
        let before = self.compare(&model, &runs)?;
        let report = self.diagnose(&model, &runs)?;
        let (after, mut page) = self.add(&report, &runs)?;
        let answers = self.resolve(&report.diagnosis)?;
        let bounces = self.compensate(&report, &mut page)?;
        write_whole(&self.files.report, page.to_html())?;
        if self.quiet {
            return print_json(&Document {
                report: &self.files.report,
                model: &self.files.model,
                hidden: &self.hidden,
                found: answers.iter().all(|answer| answer.named),
                answers: &answers,
                recordings: [
                    (&self.files.train, &runs.train),
                    (&self.files.test, &runs.test),
                ]
                .map(|(recording, run)| RecordingDocument {
                    recording,
                    real_time_factor: run.statistics.real_time_factor(),
                }),
                compare: BeforeAfter {
                    before: &before.sentence,
                    after: &after.sentence,
                },
                diagnosis: &report.diagnosis,
                steps: bounces.iter().map(StepDocument::new).collect(),
            });
        }
        print(&format!("\n{}", self.files.what_next()))
    }

    /// Step 3 of the workflow: runs the two tests on the simulated rig.
    fn run(&self) -> Result<Recordings> {
        self.say(
            "Steps 1 and 2, flashing the board and commissioning the rig, need hardware. The simulated rig \
             is ready.\n\n\
             3. Run a docking test: for 10 s a probe of 200 kg goes to and fro between two springs. The rig \
             hides\n   something that its model does not know. Then once more, in the other direction, to \
             judge by.\n",
        )?;
        let run = |part| demo::run(part, &self.hidden, self.seed);
        let runs = Recordings {
            train: run(Part::Train)?,
            test: run(Part::Test)?,
        };
        for (run, path) in [
            (&runs.train, &self.files.train),
            (&runs.test, &self.files.test),
        ] {
            run.recording.write(path)?;
            self.say(&format!(
                "   {} cycles in {}, {:.0} times real time\n",
                run.statistics.cycles,
                path.display(),
                run.statistics.real_time_factor(),
            ))?;
        }
        Ok(runs)
    }

    /// Step 4: compares the nominal model with the test recording.
    fn compare(&self, model: &Model, runs: &Recordings) -> Result<Comparison> {
        write_whole(&self.files.model_before, diagnosis::MODEL)?;
        let comparison = compare(model, &runs.test.recording)?;
        let page = pages::comparison::page(&comparison)?;
        write_whole(&self.files.compare, page.to_html())?;
        self.say(&format!(
            "\n4. Compare with the model. Where does it fail?\n   {}\n",
            comparison.sentence
        ))?;
        Ok(comparison)
    }

    /// Step 5: finds the missing effects.
    fn diagnose(&self, model: &Model, runs: &Recordings) -> Result<Report> {
        self.say("\n5. Diagnose: which physical effect is missing?\n")?;
        let bar = Progress::of_steps();
        let progress = |share: f64, what: &str| bar.show(share, what);
        let (train, test) = (&runs.train.recording, &runs.test.recording);
        let report = diagnose(model, &[train], &[test], &progress)?;
        drop(bar);
        self.tell_findings(&report.diagnosis)?;
        Ok(report)
    }

    fn tell_findings(&self, diagnosis: &Diagnosis) -> Result<()> {
        self.say(&format!("   {}\n", diagnosis.sentence))?;
        for effect in &diagnosis.effects {
            for (name, p) in diagnosis.parameters.get(effect).into_iter().flatten() {
                let [value, low, high] = [p.value, p.low, p.high].map(|v| significant(v, 4));
                self.say(&format!(
                    "     {effect} {name} = {value} ({low} to {high})\n"
                ))?;
            }
        }
        if let Some(same) = &diagnosis.equivalent {
            self.say(&format!("   {}\n", same.sentence))?;
        }
        if let Some(rival) = &diagnosis.runner_up {
            let verb = if rival.told_apart {
                "is told apart"
            } else {
                "cannot be told apart"
            };
            self.say(&format!(
                "   The closest rival, {}, {verb}.\n",
                rival.in_words()
            ))?;
        }
        if let Some(experiment) = &diagnosis.experiment {
            self.say(&format!("   To be sure: {}\n", experiment.sentence))?;
        }
        Ok(())
    }

    /// Step 6: adds the effects to the model and compares again.
    fn add(&self, report: &Report, runs: &Recordings) -> Result<(Comparison, Page)> {
        let (train, test) = (name(&self.files.train), name(&self.files.test));
        let text = demo::model_with(report, &train, &test)?;
        write_whole(&self.files.model, &text)?;
        let model = Model::from_toml(&text, &self.files.model.display().to_string())?;
        let comparison = compare(&model, &runs.test.recording)?;
        let identity = Identity {
            model_path: self.files.model_before.display().to_string(),
            model_toml: text,
            train: self.files.train.display().to_string(),
            test: Some(self.files.test.display().to_string()),
            firmware: runs.test.recording.header.identity.clone(),
            settings_toml: runs.test.recording.header.settings_toml.clone(),
        };
        let (before, after) = (&report.before_prediction, &report.after_prediction);
        let page = pages::diagnosis::page(&report.diagnosis, before, after, &identity)?;
        let what = match report.diagnosis.verdict {
            Verdict::Named => format!(
                "Add it to {}, compare again, and watch the error fall:",
                self.files.model.display()
            ),
            _ => "Nothing was named, so nothing is added:".to_owned(),
        };
        self.say(&format!(
            "\n6. {what}\n\n{}\n\n   {}\n",
            demo::history_table(&report.diagnosis),
            comparison.sentence
        ))?;
        Ok((comparison, page))
    }

    /// Compares the hidden effects with those that were found.
    fn resolve(&self, diagnosis: &Diagnosis) -> Result<Vec<Answer>> {
        let answers = demo::answers(&self.hidden, diagnosis);
        let in_other_words = |id: &String| {
            let same = diagnosis.equivalent.as_ref();
            same.is_some_and(|s| {
                s.of.contains(id) && self.hidden.iter().any(|h| s.parameters.contains_key(&h.id))
            })
        };
        let extra: Vec<&str> = diagnosis
            .effects
            .iter()
            .filter(|id| !answers.iter().any(|answer| answer.effect == **id))
            .filter(|id| !in_other_words(id))
            .map(String::as_str)
            .collect();
        let wrong = if extra.is_empty() {
            String::new()
        } else {
            format!("   Named, but not hidden: {}.\n", extra.join(", "))
        };
        let verdict = match answers.iter().filter(|answer| answer.named).count() {
            0 => "It was not found.",
            named if named == answers.len() => "It was found.",
            _ => "It was found in part.",
        };
        self.say(&format!(
            "\n   What the rig had hidden: {verdict}\n\n{}\n{wrong}",
            demo::answer_table(&answers)
        ))?;
        Ok(answers)
    }

    /// Step 7, only where the rig is late: the identified robot goes into the board's settings. Returns the bounces without a
    /// delay law, with the paper's, and with the predictor if the robot was identified.
    fn compensate(&self, report: &Report, page: &mut Page) -> Result<Vec<Bounce>> {
        if !demo::is_late(&self.hidden) {
            return Ok(Vec::new());
        }
        let learned = demo::identified_robot(report);
        self.say(&format!(
            "\n7. Tell the board. A late robot gives an elastic stop back more speed than came in. {}\n   The \
             same robot at the paper's stop, 10 mm/s, without a delay law, with the paper's{}:\n\n",
            learned.as_ref().map_or_else(
                || "Nothing was found that a delay law could use.".to_owned(),
                told
            ),
            learned.as_ref().map_or("", |_| ", and with the predictor"),
        ))?;
        // Settings as in the paper, and as `reproduce` runs them.
        let plain = |law| DelaySettings {
            law,
            model_velocity: ModelVelocity::Mean,
            ..DelaySettings::default()
        };
        let mut settings = vec![plain(LawName::None), plain(LawName::Seed)];
        if let Some(robot) = &learned {
            let delay = demo::delay_settings(LawName::Predictor, robot);
            write_whole(&self.files.board, &demo::board_text(&delay)?)?;
            settings.push(delay);
        }
        let bounces = settings
            .into_iter()
            .map(|delay| demo::bounce(delay, &self.hidden, self.seed))
            .collect::<Result<Vec<_>>>()?;
        let table = demo::bounce_table(&bounces);
        page.section("What the board makes of it");
        page.paragraph(
            "The robot's delay and pause, as they were found, in the settings of the board: an elastic bounce \
             of 500 kg at 10 mm/s, as a perfect rig, this rig, and this rig with a delay law give it back.",
        );
        page.table(&table);
        self.say(&format!("{table}\n"))?;
        for bounce in &bounces {
            if let Err(why) = &bounce.impact {
                let why = format!("With {} the board {why}.", bounce.delay.law.name());
                page.paragraph(&why);
                self.say(&format!("   {why}\n"))?;
            }
        }
        Ok(bounces)
    }

    /// Tells the story: to standard output, unless that is for the JSON document.
    fn say(&self, text: &str) -> Result<()> {
        if self.quiet {
            to_standard_error(format_args!("{text}"));
            return Ok(());
        }
        print(text)
    }
}

/// The identified robot as the board's settings have it, in words.
fn told(robot: &ActuatorSettings) -> String {
    let ms = |seconds: f64| significant(seconds * 1e3, 3);
    let mut parts = vec![format!("delay {} ms", ms(robot.delay_s))];
    if robot.lag_s > 0.0 {
        parts.push(format!("lag {} ms", ms(robot.lag_s)));
    }
    if robot.has_servo() {
        parts.push(format!(
            "servo {} Hz with damping {}",
            significant(robot.servo_hz, 3),
            significant(robot.servo_damping, 3)
        ));
    }
    parts.push(format!("pause {} ms", ms(robot.pause_s)));
    format!(
        "The board is told what was found:\n   {}.",
        parts.join(", ")
    )
}

/// The name of a file without its folder.
fn name(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

#[derive(Serialize)]
struct Document<'a> {
    report: &'a Path,
    model: &'a Path,
    /// Effects that the rig hid.
    hidden: &'a [Hidden],
    /// Whether all of them were named.
    found: bool,
    answers: &'a [Answer],
    /// Training recording, then unseen recording.
    recordings: [RecordingDocument<'a>; 2],
    compare: BeforeAfter<'a>,
    diagnosis: &'a Diagnosis,
    /// Bounces without and with compensation; empty where compensation cures nothing.
    steps: Vec<StepDocument<'a>>,
}

#[derive(Serialize)]
struct RecordingDocument<'a> {
    recording: &'a Path,
    real_time_factor: f64,
}

#[derive(Serialize)]
struct BeforeAfter<'a> {
    before: &'a str,
    after: &'a str,
}

#[derive(Serialize)]
struct StepDocument<'a> {
    law: LawName,
    real_time_factor: f64,
    /// None where the board stopped before the impact.
    impact: Option<&'a Impact>,
    /// Why the board stopped before the impact.
    #[serde(skip_serializing_if = "Option::is_none")]
    stopped: Option<&'a str>,
}

impl<'a> StepDocument<'a> {
    fn new(bounce: &'a Bounce) -> Self {
        Self {
            law: bounce.delay.law,
            real_time_factor: bounce.statistics.real_time_factor(),
            impact: bounce.impact.as_ref().ok(),
            stopped: bounce.impact.as_ref().err().map(String::as_str),
        }
    }
}
