//! Recordings as CSV: one row per cycle, and beside it a JSON file that holds what a table
//! cannot: the header, and unit and meaning of each column. Both together give the recording
//! back bit by bit.

use super::schema::{Described, fields};
use super::text::{CellReader, CellWriter, columns};
use super::topics::{Row, Topic};
use super::{Header, Recording};
use crate::data_table::Description;
use anyhow::{Context, ensure};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Name of the format, in the JSON file.
const FORMAT: &str = "softdock-csv";
/// Version of the format.
const VERSION: u32 = 1;

/// The JSON file.
#[derive(Debug, Serialize, Deserialize)]
struct Sidecar {
    format: String,
    version: u32,
    identity: String,
    settings_toml: String,
    scenario_toml: Option<String>,
    /// Why the recording ended early.
    cut: Option<String>,
    /// Number of rows.
    cycles: usize,
    columns: Vec<Description>,
}

/// Writes `path` (CSV) and the JSON file of the same name beside it.
pub fn export_csv(recording: &Recording, path: &Path) -> anyhow::Result<()> {
    let topics = Topic::all(!recording.truth.is_empty());
    write_table(recording, topics, path)
        .with_context(|| format!("cannot write the table `{}`", path.display()))?;
    let Header {
        identity,
        settings_toml,
        scenario_toml,
    } = recording.header.clone();
    let sidecar = Sidecar {
        format: FORMAT.to_owned(),
        version: VERSION,
        identity,
        settings_toml,
        scenario_toml,
        cut: recording.cut.clone(),
        cycles: recording.cycles.len(),
        columns: topics.iter().flat_map(|topic| described(*topic)).collect(),
    };
    let json = path.with_extension("json");
    std::fs::write(&json, serde_json::to_string_pretty(&sidecar)?)
        .with_context(|| format!("cannot write the table's description `{}`", json.display()))
}

fn write_table(recording: &Recording, topics: &[Topic], path: &Path) -> anyhow::Result<()> {
    let truths = recording.truths()?;
    let mut table = csv::Writer::from_path(path)?;
    table.write_record(topics.iter().flat_map(|topic| columns(*topic)))?;
    let mut writer = CellWriter::default();
    for (cycle, truth) in recording.cycles.iter().zip(truths) {
        let (cycle, truth) = (*cycle, truth.copied().unwrap_or_default());
        let mut row = Row { cycle, truth };
        writer.cells.clear();
        for topic in topics {
            let Ok(()) = topic.visit(&mut writer, &mut row);
        }
        table.write_record(&writer.cells)?;
    }
    Ok(table.flush()?)
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
    };
    recording.cut = sidecar.cut;
    Ok(recording)
}

fn read_sidecar(path: &Path) -> anyhow::Result<Sidecar> {
    /// Format and version alone, which an unknown version has too.
    #[derive(Deserialize)]
    struct Kind {
        #[serde(default)]
        format: String,
        #[serde(default)]
        version: u32,
    }
    let text = std::fs::read_to_string(path)
        .context("a table of softdock has a JSON file of the same name beside it")?;
    let Kind { format, version } = serde_json::from_str(&text)?;
    ensure!(
        (format.as_str(), version) == (FORMAT, VERSION),
        "expected format `{FORMAT}` version {VERSION}, received `{format}` version {version}"
    );
    Ok(serde_json::from_str(&text)?)
}

fn read_table(path: &Path) -> anyhow::Result<Recording> {
    let text = std::fs::read(path)?;
    // A number that was cut off is still a number.
    ensure!(
        text.ends_with(b"\n"),
        "the last row has no line end: the file was cut off"
    );
    let mut table = csv::Reader::from_reader(text.as_slice());
    let names = table.headers()?.clone();
    let truth = names.len() > Topic::all(false).iter().flat_map(|t| columns(*t)).count();
    let topics = Topic::all(truth);
    check_names(&names, topics)?;

    let mut recording = Recording::default();
    for cells in table.records() {
        let cells = cells.context("a row does not fit the header")?;
        let mut row = Row::default();
        let mut reader = CellReader::new(&cells);
        topics
            .iter()
            .try_for_each(|topic| topic.visit(&mut reader, &mut row))
            .with_context(|| cell_name(&cells, &names, &reader))?;
        recording.cycles.push(row.cycle);
        if truth {
            recording.truth.push(row.truth);
        }
    }
    Ok(recording)
}

fn check_names(names: &csv::StringRecord, topics: &[Topic]) -> anyhow::Result<()> {
    let expected: Vec<String> = topics.iter().flat_map(|topic| columns(*topic)).collect();
    for (i, expected) in expected.iter().enumerate() {
        let received = names.get(i).unwrap_or_default();
        ensure!(
            received == expected,
            "row 1, column {}: expected `{expected}`, received `{received}`",
            i + 1
        );
    }
    let (expected, received) = (expected.len(), names.len());
    ensure!(
        received == expected,
        "expected {expected} columns, received {received}"
    );
    Ok(())
}

/// Row and column of the cell that was read last.
fn cell_name(
    cells: &csv::StringRecord,
    names: &csv::StringRecord,
    reader: &CellReader<'_>,
) -> String {
    let row = cells.position().map_or(0, csv::Position::line);
    let column = names.get(reader.last_place()).unwrap_or_default();
    format!("row {row}, column `{column}`")
}
