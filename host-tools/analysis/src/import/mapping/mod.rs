//! Any table as a recording, by a mapping file.
//!
//! ```toml
//! model = "model.toml"              # beside this file; goes along with the recordings
//! [files]
//! train = "log.csv"                 # in the folder that is imported
//! [time]
//! column = { column = "t", unit = "ms" }
//! [position]
//! x = { column = "qm", unit = "mm" }
//! [executed_velocity]
//! derive = true                     # from the position
//! [wrench]
//! fx = { column = "u", unit = "V", scale = -35.0 }   # N per volt
//! [filter]
//! cutoff_hz = 40.0
//! decimate = 4
//! [split]
//! train_share = 0.7                 # the rest is test data
//! ```
//!
//! A column is a name or a number from 1; its value is `scale × number + offset` in its unit, less that of another
//! column (`minus`) if there is one, which has the same scale and unit unless it has its own.

mod channels;
mod column;
mod cycles;
mod file;
mod read;
mod shape;
mod source;
mod stamps;
mod times;

use super::checks::{self, Context as CheckContext};
use super::starter::{Filtered, NoiseFloors, Told};
use super::turns::{self, Turning};
use anyhow::{Context, bail, ensure};
use channels::{Channels, Rotation};
use file::{Mapping, Part, Split};
use nalgebra::UnitQuaternion;
use softdock_app::record::CycleRecord;
use softdock_control::frames;
use softdock_io::input;
use softdock_io::recording::{Beginning, Header, Recording};
use softdock_physics::model::{Model, WrenchMeaning};
use source::Source;
use std::path::Path;

/// What a mapping makes of tables.
#[derive(Clone, Debug)]
pub struct MappedLogs {
    /// The model that the mapping names, and its text as the user wrote it.
    pub model: Option<(Model, String)>,
    /// Logs to fit on, at least one.
    pub train: Vec<Recording>,
    /// Logs that the fit must not see, if the mapping names any.
    pub test: Vec<Recording>,
    /// The low-pass that all measured channels went through, if any.
    pub filtered: Option<Filtered>,
    /// Values for a starting model that no column holds.
    pub told: Told,
    /// Channels that were not measured, and from what they were made.
    pub derived: Vec<(&'static str, &'static str)>,
    /// What the user should know; sentences that name the file.
    pub warnings: Vec<String>,
}

/// Imports `path`: a folder in which the files of the mapping are, or one table that is taken in
/// place of the mapping's.
///
/// # Errors
///
/// A file that cannot be read; a mapping with a misspelt key, an unknown unit or a column that does
/// not exist; a cell that is no number; a log that no comparison could use. The error names file,
/// line and column.
pub fn import(path: &Path, mapping_file: &Path) -> anyhow::Result<MappedLogs> {
    import_at_least(path, mapping_file, None)
}

/// [`import`], where fewer rows may be enough than a diagnosis needs.
///
/// # Errors
///
/// Those of [`import`].
pub fn import_at_least(
    path: &Path,
    mapping_file: &Path,
    fewest_rows: Option<usize>,
) -> anyhow::Result<MappedLogs> {
    let mapping: Mapping = input::load(mapping_file)?;
    ensure!(
        mapping.model.is_none() || mapping.starter.is_none(),
        "{}: `model` and [starter] exclude each other: what [starter] says stands in the model file, where there is one",
        mapping_file.display()
    );
    let file = mapping.model.as_ref();
    let file = file.map(|name| mapping_file.with_file_name(name));
    let model = file.map(|file| read_model(&file)).transpose()?;
    let (folder, train, test) = files(path, &mapping)?;
    let mut importer = Importer {
        folder,
        mapping: &mapping,
        model: model.as_ref().map(|(model, _)| model),
        fewest_rows,
        derived: Vec::new(),
        warnings: Vec::new(),
        behind_filter: Vec::new(),
        turning: Turning::default(),
    };
    let (train, test) = importer.logs(&train, &test)?;
    let (mut derived, mut warnings) = (importer.derived, importer.warnings);
    let all = train.iter().chain(&test);
    let said: Vec<(&str, &Recording)> = all.map(|(said, log)| (said.as_str(), log)).collect();
    let checked = model.as_ref().map(|(model, _)| model);
    warnings.extend(checks::signs(&said, checked));
    warnings.extend(checks::filter_needed(&said, checked));
    if path.is_file() && !mapping.files.test.0.is_empty() {
        warnings.push(format!(
            "{} alone is read, not the `test` of the mapping's [files]: for both give the folder in which they are",
            path.display()
        ));
    }
    let [train, test] = [train, test].map(|logs| logs.into_iter().map(|(_, log)| log).collect());
    derived.sort_unstable();
    derived.dedup();
    let filtered = mapping.filter.map(|filter| Filtered {
        filter: filter.as_modelled(),
        noise: importer.behind_filter,
    });
    let both = model.as_ref().zip(filtered.as_ref());
    warnings.extend(both.and_then(|((model, _), filtered)| lacks_filter(model, filtered)));
    warnings.extend(mapping.wrench.unscaled());
    Ok(MappedLogs {
        filtered,
        told: mapping.starter.clone().unwrap_or_default(),
        derived,
        model,
        train,
        test,
        warnings,
    })
}

/// Gives a free swing its wrench, which is zero.
fn swings_freely(channels: &mut Channels) -> anyhow::Result<()> {
    ensure!(
        channels.wrench.is_none(),
        "`wrench = \"free\"` says that nothing drives what moves: expected no [wrench], or another `wrench`"
    );
    channels.wrench = Some([(); 6].map(|()| vec![0.0; channels.len()]));
    Ok(())
}

/// A model file, and its text as the user wrote it.
fn read_model(file: &Path) -> anyhow::Result<(Model, String)> {
    let text = std::fs::read_to_string(file)
        .with_context(|| format!("cannot read the mapping's model {}", file.display()))?;
    Ok((Model::from_toml(&text, &file.display().to_string())?, text))
}

/// A warning if the model does not state the filter of the log.
fn lacks_filter(model: &Model, filtered: &Filtered) -> Option<String> {
    let own = filtered.filter;
    (model.sensor.filter != Some(own)).then(|| {
        format!(
            "the model does not say through which filter the log went, so that friction, and what an actuator \
             makes of a command, would be compared unfiltered: write `filter = {{ order = {}, cutoff_hz = {:?} }}` into its [sensor]",
            own.order, own.cutoff_hz
        )
    })
}

/// Checks that two parts of one table have no time in common.
fn ensure_apart(train: &[CycleRecord], test: &[CycleRecord]) -> anyhow::Result<()> {
    let span = |cycles: &[CycleRecord]| {
        let time = |cycle: Option<&CycleRecord>| cycle.map_or(f64::NAN, |c| c.trace.time_s);
        (time(cycles.first()), time(cycles.last()))
    };
    let ((a, b), (c, d)) = (span(train), span(test));
    let (from, to) = (a.max(c), b.min(d));
    ensure!(
        from > to,
        "[rows]: training and test data of one table have {from:.3} s to {to:.3} s in common; expected rows of their \
         own for each, in [rows.train] and [rows.test]"
    );
    Ok(())
}

/// Folder, tables of the training logs, tables of the test logs.
type LogFiles<'a> = (&'a Path, Vec<Vec<String>>, Vec<Vec<String>>);

fn files<'a>(path: &'a Path, mapping: &Mapping) -> anyhow::Result<LogFiles<'a>> {
    let (mut train, test) = (mapping.files.train.0.clone(), &mapping.files.test.0);
    if path.is_dir() {
        ensure!(
            !train.is_empty(),
            "{} is a folder: say in the mapping which file is meant, [files] train = \"..\"",
            path.display()
        );
        return Ok((path, train, test.clone()));
    }
    let name = path
        .file_name()
        .and_then(|name| name.to_str())
        .with_context(|| format!("{}: expected a file or a folder", path.display()))?;
    ensure!(
        train.len() < 2,
        "the mapping names {} training logs; give the folder in which they are, not {}",
        train.len(),
        path.display()
    );
    // The given file replaces the first table; tables beside it stay.
    let mut tables = train.pop().unwrap_or_else(|| vec![String::new()]);
    tables[0] = name.to_owned();
    Ok((
        path.parent().unwrap_or(Path::new("")),
        vec![tables],
        Vec::new(),
    ))
}

struct Importer<'a> {
    folder: &'a Path,
    mapping: &'a Mapping,
    model: Option<&'a Model>,
    fewest_rows: Option<usize>,
    derived: Vec<(&'static str, &'static str)>,
    warnings: Vec<String>,
    /// Noise of each table that the filter leaves.
    behind_filter: Vec<NoiseFloors>,
    turning: Turning,
}

/// Name, in messages, of the part of a table that is fitted.
const TRAINING: &str = "training";
/// ... and of the part that is unseen.
const TEST: &str = "test";

/// A recording with its name in messages.
type Said = (String, Recording);

/// Successive cycles, not yet checked.
struct Stretch {
    /// Names of the tables.
    name: String,
    /// The same with the part of the tables, for messages.
    said: String,
    cycles: Vec<CycleRecord>,
    /// See [`Header::whole_turns`].
    whole_turns: i32,
    /// See [`Header::began`].
    began: Option<Beginning>,
}

impl Stretch {
    /// Beginning of the whole log, also if this is a later part of it.
    fn beginning(&self) -> Option<Beginning> {
        let of = |first: &CycleRecord| Beginning {
            time_s: first.trace.time_s,
            pose: first.trace.pose,
            whole_turns: self.whole_turns,
        };
        self.began.or(self.cycles.first().map(of))
    }

    /// Tells the later of two parts of one log where the log begins.
    fn joined(mut self, mut other: Self) -> (Self, Self) {
        let times = |part: &Self| part.cycles.first().map(|first| first.trace.time_s);
        match times(&self) <= times(&other) {
            true => other.began = self.beginning(),
            false => self.began = other.beginning(),
        }
        (self, other)
    }
}

impl Importer<'_> {
    /// Training logs and test logs, each with its name in messages. If the mapping asks for it, rows of the training logs' tables become test logs, in place of
    /// tables of their own.
    fn logs(
        &mut self,
        train: &[Vec<String>],
        test: &[Vec<String>],
    ) -> anyhow::Result<(Vec<Said>, Vec<Said>)> {
        let split = self.mapping.split;
        let own_rows = self.mapping.rows.test.is_some();
        match (split, test) {
            (Some(_), []) if own_rows => {
                bail!("the mapping has both [split] and [rows.test]; one is enough")
            }
            (Some(_), [_, ..]) => {
                bail!("the mapping has both [split] and a test file; one is enough")
            }
            _ => {}
        }
        let (mut trained, mut unseen) = (Vec::new(), Vec::new());
        for tables in train {
            let stretch = self.stretch(tables, Part::Train)?;
            let (stretch, apart) = match split {
                Some(split) => {
                    let (train, apart) = self.split(stretch, split)?;
                    (train, Some(apart))
                }
                None if own_rows && test.is_empty() => {
                    let apart = self.stretch(tables, Part::Test)?;
                    ensure_apart(&stretch.cycles, &apart.cycles)?;
                    let (stretch, apart) = stretch.joined(apart);
                    (stretch, Some(apart))
                }
                None => (stretch, None),
            };
            trained.push(self.recording(stretch)?);
            if let Some(apart) = apart {
                unseen.push(self.recording(apart)?);
            }
        }
        for tables in test {
            let stretch = self.stretch(tables, Part::Test)?;
            unseen.push(self.recording(stretch)?);
        }
        Ok((trained, unseen))
    }

    /// Reads tables that stand side by side.
    fn stretch(&mut self, files: &[String], part: Part) -> anyhow::Result<Stretch> {
        let mapping = self.mapping;
        let source = Source::read(self.folder, files, mapping)?;
        let name = source.name();
        let of_one_table = mapping.rows.test.is_some() && mapping.files.test.0.is_empty();
        let said = match (of_one_table, part) {
            (false, _) => name.clone(),
            (true, Part::Train) => format!("{name}, [rows.train]"),
            (true, Part::Test) => format!("{name}, [rows.test]"),
        };
        let at_rest = self.at_rest();
        let shaped = || -> anyhow::Result<_> {
            let rows = mapping.rows.of(part);
            let mut channels = read::read(mapping, rows, source, &mut self.warnings)?;
            if self.is_free() {
                swings_freely(&mut channels)?;
            }
            if let Some(kept) = mapping.time.duplicates {
                stamps::without_duplicates(&mut channels, kept, &said, &mut self.warnings);
            }
            if !at_rest {
                let cutoff_hz = mapping.filter.map(|filter| filter.cutoff_hz);
                let told = &mut self.warnings;
                stamps::regular(&mut channels, &mapping.time, cutoff_hz, &said, told)?;
            }
            self.derived.extend(cycles::derived(&channels, at_rest));
            if let Some(filter) = &mapping.filter {
                let noise = shape::filter(&mut channels, filter, &said, &mut self.warnings)?;
                self.behind_filter.push(noise);
            }
            let cycles = cycles::cycles(&channels, mapping, &self.m_from_s(), at_rest)?;
            Ok((cycles, channels))
        };
        let (cycles, channels) = shaped()?;
        let whole_turns = match &channels.orientation {
            Some(Rotation::Angles(angles)) => self.turning.of_first(&cycles, Some(angles)),
            Some(Rotation::Quaternions(_)) => self.turning.of_first(&cycles, None),
            None => 0,
        };
        Ok(Stretch {
            name,
            said,
            cycles,
            whole_turns,
            began: None,
        })
    }

    /// Whether the rows are measurements at rest, independent of each other.
    fn at_rest(&self) -> bool {
        self.model.is_some_and(|model| model.sensor.at_rest)
    }

    /// Whether nothing drives what moves.
    fn is_free(&self) -> bool {
        let told = self.mapping.starter.as_ref().and_then(|told| told.wrench);
        let wrench = self.model.map(|model| model.sensor.wrench).or(told);
        wrench == Some(WrenchMeaning::Free)
    }

    /// Orientation of the sensor in M by the model.
    fn m_from_s(&self) -> UnitQuaternion<f64> {
        let orientation = |model: &Model| model.sensor.orientation_wxyz;
        let wxyz = self.model.map_or([1.0, 0.0, 0.0, 0.0], orientation);
        frames::pose(&[0.0; 3], &wxyz).rotation
    }

    /// Splits a log into its training part and its test part.
    fn split(&self, whole: Stretch, split: Split) -> anyhow::Result<(Stretch, Stretch)> {
        let Stretch {
            name,
            said,
            cycles,
            whole_turns,
            began,
        } = whole;
        let part = |which: &str, cycles, whole_turns| Stretch {
            name: name.clone(),
            said: format!("{said}, {which} part"),
            cycles,
            whole_turns,
            began,
        };
        match split {
            Split::TestEvery(every) => {
                ensure!(
                    every >= 2,
                    "[split] test_every is {every}; expected at least 2"
                );
                ensure!(
                    self.at_rest(),
                    "[split] test_every tears a motion apart; say train_share, or, if each row is \
                     a measurement of its own, [sensor] at_rest = true in the model"
                );
                let is_test = |(n, _): &(usize, CycleRecord)| (n + 1) % every == 0;
                let (test, train): (Vec<_>, Vec<_>) =
                    cycles.into_iter().enumerate().partition(is_test);
                let plain = |which: &str, rows: Vec<(usize, CycleRecord)>| {
                    part(which, rows.into_iter().map(|(_, cycle)| cycle).collect(), 0)
                };
                Ok((plain(TRAINING, train), plain(TEST, test)))
            }
            Split::TrainShare(share) => {
                ensure!(
                    share > 0.0 && share < 1.0,
                    "[split] train_share is {share}; expected a share between 0 and 1"
                );
                let mut train = cycles;
                let at = (share * train.len() as f64).round() as usize;
                let turns = turns::later(&train, whole_turns, at);
                let test = train.split_off(at);
                Ok(part(TRAINING, train, whole_turns).joined(part(TEST, test, turns)))
            }
        }
    }

    /// Makes a recording of cycles and checks it.
    fn recording(&mut self, stretch: Stretch) -> anyhow::Result<Said> {
        let Stretch {
            name,
            said,
            mut cycles,
            whole_turns,
            began,
        } = stretch;
        let numbers = if self.at_rest() {
            (0..cycles.len() as u64).collect()
        } else {
            let times: Vec<f64> = cycles.iter().map(|c| c.trace.time_s).collect();
            times::cycle_numbers(&times)
        };
        for (cycle, number) in cycles.iter_mut().zip(numbers) {
            cycle.trace.cycle = number;
        }
        let recording = Recording {
            header: Header {
                identity: format!("imported from {name}"),
                whole_turns,
                began,
                ..Header::default()
            },
            cycles,
            ..Recording::default()
        };
        let kept = self.mapping.filter.map_or(1, |filter| filter.decimate);
        let promised = self.mapping.time.sample_time_s;
        let context = CheckContext {
            name: &said,
            // The stated sample time is not checked where rows at rest were split, which are then at unequal steps, or where rows
            // were resampled.
            sample_time_s: promised.map(|step| step * kept as f64).filter(|_| {
                self.mapping.split.is_none() && self.mapping.time.resample_hz.is_none()
            }),
            model: self.model,
            fewest_rows: self.fewest_rows,
            imports: true,
        };
        self.warnings.extend(checks::check(&recording, &context)?);
        Ok((said, recording))
    }
}
