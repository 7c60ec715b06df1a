//! Recordings as CSV: one row per cycle, the time first, and beside it a JSON file that holds what a
//! table cannot: the header, and unit and meaning of each column. Both together restore the recording bit by bit.

use super::schema::{Described, fields};
use super::text::{CellReader, CellWriter, columns};
use super::topics::{Row, Topic};
use super::{Beginning, Header, Recording, WallClock};
use crate::data_table::Description;
use crate::output::NewFile;
use anyhow::{Context, ensure};
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::Path;

/// Name of the format in the JSON file.
const FORMAT: &str = "softdock-csv";
/// Name of the first column.
const TIME: &str = "status_time_s";
/// Version of the format.
const VERSION: u32 = 1;

/// Content of the JSON file.
#[derive(Debug, Serialize, Deserialize)]
struct Sidecar {
    format: String,
    version: u32,
    identity: String,
    settings_toml: String,
    scenario_toml: Option<String>,
    /// See [`Header::whole_turns`].
    #[serde(default, skip_serializing_if = "is_zero")]
    whole_turns: i32,
    /// See [`Header::began`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    began: Option<Beginning>,
    /// Why the recording ended early.
    cut: Option<String>,
    /// Wall clock of the recording.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    wall_clock: Option<WallClock>,
    /// Number of rows.
    cycles: usize,
    columns: Vec<Description>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks by reference")]
fn is_zero(turns: &i32) -> bool {
    *turns == 0
}

/// Writes `path` (CSV) and the JSON file of the same name beside it. Each is written atomically; the table comes last.
///
/// # Errors
/// The files cannot be written.
pub fn export_csv(recording: &Recording, path: &Path) -> anyhow::Result<()> {
    let topics = Topic::all(!recording.truth.is_empty());
    let Header {
        identity,
        settings_toml,
        scenario_toml,
        whole_turns,
        began,
    } = recording.header.clone();
    let sidecar = Sidecar {
        format: FORMAT.to_owned(),
        version: VERSION,
        identity,
        settings_toml,
        scenario_toml,
        whole_turns,
        began,
        cut: recording.cut.clone(),
        wall_clock: recording.wall_clock,
        cycles: recording.cycles.len(),
        columns: time_first(
            topics.iter().flat_map(|topic| described(*topic)),
            |column| &column.name,
        ),
    };
    let table = NewFile::write(path, |file| write_table(recording, topics, file))?;
    let text = serde_json::to_string_pretty(&sidecar)?;
    let described = NewFile::of(&path.with_extension("json"), text)?;
    described.keep()?;
    table.keep()
}

fn write_table(
    recording: &Recording,
    topics: &[Topic],
    file: &mut dyn Write,
) -> anyhow::Result<()> {
    let truths = recording.truths()?;
    let mut table = csv::Writer::from_writer(file);
    let names: Vec<String> = topics.iter().flat_map(|topic| columns(*topic)).collect();
    let time = names.iter().position(|name| name == TIME).unwrap_or(0);
    table
        .write_record(time_first(names, |name| name))
        .map_err(cause)?;
    let mut writer = CellWriter::default();
    for (cycle, truth) in recording.cycles.iter().zip(truths) {
        let (cycle, truth) = (*cycle, truth.copied().unwrap_or_default());
        let mut row = Row {
            cycle,
            truth,
            ..Row::default()
        };
        writer.cells.clear();
        for topic in topics {
            let Ok(()) = topic.visit(&mut writer, &mut row);
        }
        writer.cells[..=time].rotate_right(1);
        table.write_record(&writer.cells).map_err(cause)?;
    }
    Ok(table.flush()?)
}

/// The system's error behind an error of the CSV library.
fn cause(error: csv::Error) -> anyhow::Error {
    match error.kind() {
        csv::ErrorKind::Io(cause) => std::io::Error::from(cause.kind()).into(),
        _ => error.into(),
    }
}

/// The columns with the time first.
fn time_first<T>(columns: impl IntoIterator<Item = T>, name: impl Fn(&T) -> &str) -> Vec<T> {
    let mut columns: Vec<T> = columns.into_iter().collect();
    columns.sort_by_key(|column| name(column) != TIME);
    columns
}

/// The columns of a topic.
fn described(topic: Topic) -> impl Iterator<Item = Description> {
    fields(topic).into_iter().flat_map(move |described| {
        let Described {
            field,
            ros_type,
            words,
        } = described;
        let column = move |name| Description {
            name,
            unit: field.unit.symbol.to_owned(),
            kind: if words.is_empty() { ros_type } else { "word" }.to_owned(),
            words: words.iter().copied().map(str::to_owned).collect(),
            meaning: field.about.to_owned(),
        };
        field.columns(&topic.prefix()).into_iter().map(column)
    })
}

/// Reads what [`export_csv`] wrote: `path` (CSV) and the JSON file of the same name beside it.
/// Errors name row and column.
pub fn import_csv(path: &Path) -> anyhow::Result<Recording> {
    let json = path.with_extension("json");
    ensure!(
        json.exists() || !path.exists(),
        "{}: say with --mapping FILE.toml what its columns are; only a table that `softdock export` wrote needs none, and \
         has {} beside it",
        path.display(),
        json.display()
    );
    let sidecar = read_sidecar(&json)
        .with_context(|| format!("cannot read the table's description `{}`", json.display()))?;
    let mut recording =
        read_table(path).with_context(|| format!("cannot read the table `{}`", path.display()))?;
    let (expected, received) = (sidecar.cycles, recording.cycles.len());
    ensure!(
        expected == received,
        "`{}` holds {received} cycles, expected are {expected}: it was cut off, or rows were \
         removed on purpose; then correct `cycles` in `{}`",
        path.display(),
        json.display()
    );
    recording.header = Header {
        identity: sidecar.identity,
        settings_toml: sidecar.settings_toml,
        scenario_toml: sidecar.scenario_toml,
        whole_turns: sidecar.whole_turns,
        began: sidecar.began,
    };
    recording.cut = sidecar.cut;
    recording.wall_clock = sidecar.wall_clock;
    Ok(recording)
}

fn read_sidecar(path: &Path) -> anyhow::Result<Sidecar> {
    /// Format and version alone, which can be read from a file of any version.
    #[derive(Deserialize)]
    struct Kind {
        #[serde(default)]
        format: String,
        #[serde(default)]
        version: u32,
    }
    let text = std::fs::read_to_string(path)?;
    let Kind { format, version } = serde_json::from_str(&text)?;
    ensure!(
        (format.as_str(), version) == (FORMAT, VERSION),
        "expected format `{FORMAT}` version {VERSION}, received `{format}` version {version}"
    );
    Ok(serde_json::from_str(&text)?)
}

fn read_table(path: &Path) -> anyhow::Result<Recording> {
    let text = std::fs::read(path)?;
    // A number whose last digits are cut off is still a number, so the line end has to be checked.
    ensure!(
        text.ends_with(b"\n"),
        "the last row has no line end: the file was cut off"
    );
    let mut table = csv::Reader::from_reader(text.as_slice());
    let names = table.headers()?.clone();
    let truth = names.len() > Topic::all(false).iter().flat_map(|t| columns(*t)).count();
    let topics = Topic::all(truth);
    let places = places(&names, topics)?;

    let mut recording = Recording::default();
    for record in table.records() {
        let record = record.context("a row does not fit the header")?;
        let cells = places.iter().filter_map(|place| record.get(*place));
        let cells: csv::StringRecord = cells.collect();
        let mut row = Row::default();
        let mut reader = CellReader::new(&cells);
        topics
            .iter()
            .try_for_each(|topic| topic.visit(&mut reader, &mut row))
            .with_context(|| {
                let row = record.position().map_or(0, csv::Position::line);
                let column = places.get(reader.last_place()).and_then(|n| names.get(*n));
                format!("row {row}, column `{}`", column.unwrap_or_default())
            })?;
        recording.cycles.push(row.cycle);
        if truth {
            recording.truth.push(row.truth);
        }
    }
    Ok(recording)
}

/// Index in the table of each number of a recording, whatever the order of the table's columns.
fn places(names: &csv::StringRecord, topics: &[Topic]) -> anyhow::Result<Vec<usize>> {
    let expected = topics.iter().flat_map(|topic| columns(*topic));
    let places: Vec<usize> = expected
        .map(|expected| {
            let place = names.iter().position(|name| name == expected);
            place.with_context(|| format!("row 1: there is no column `{expected}`"))
        })
        .collect::<anyhow::Result<_>>()?;
    let (expected, received) = (places.len(), names.len());
    ensure!(
        received == expected,
        "expected {expected} columns, received {received}"
    );
    Ok(places)
}
