//! Recordings of other programs: one topic with the numbers that are not constant.
//!
//! An imported log fills few of the hundreds of numbers of a cycle. Its file has the topic `/log` in place of all others. A
//! message holds the numbers that change; numbers that are the same in all cycles are stored once, in the channel's metadata.
//! The `sequence` of a message is the number of its cycle. Its time is that of the cycle if nanoseconds represent it exactly.
//! Chunks are compressed and not indexed: an index entry is as long as two numbers, and a reader without an index reads the
//! whole file.

use super::cdr::{CdrError, Decoder, Encoder};
use super::field::{EachNumber, Field, Number, Visitor, Words};
use super::file_format::{
    LIBRARY, MESSAGE_ENCODING, NS_PER_S, QOS, SCHEMA_ENCODING, channel_metadata, metadata,
};
use super::schema::{Described, declarations, describe_column, fields};
use super::text::{CellReader, CellWriter, columns};
use super::topics::{Row, Topic};
use super::{PROFILE, Recording, TruthRecord};
use anyhow::{Context, bail, ensure};
use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{Compression, WriteOptions};
use softdock_app::record::CycleRecord;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{Seek, Write};

/// Name of the topic.
pub(super) const TOPIC: &str = "/log";
/// Name of the message type in the schema.
const SCHEMA: &str = "softdock/msg/Log";
/// Column of the cycle's number, stored as the `sequence` of the message.
const CYCLE: &str = "status_cycle";
/// Column of the cycle's time.
const TIME: &str = "status_time_s";
/// Cycles in a chunk: with four numbers each it has 1.1 MB, and longer ones compress no better.
const CHUNK_CYCLES: usize = 16_384;
/// Compression level of zstd: higher ones take much longer and gain less than 3 %.
const LEVEL: u32 = 9;

/// For each topic with numbers in the message: which of its columns the message holds.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Layout(Vec<(Topic, Vec<bool>)>);

impl Layout {
    /// The layout with the columns for which `wanted` is true.
    fn of(wanted: impl Fn(&str) -> bool) -> Self {
        let topics = Topic::all(false).iter().map(|topic| {
            let wanted = columns(*topic).map(|column| wanted(&column));
            (*topic, wanted.collect::<Vec<bool>>())
        });
        Self(
            topics
                .filter(|(_, wanted)| wanted.contains(&true))
                .collect(),
        )
    }

    /// The schema of this layout (`ros2msg`).
    fn ros2msg(&self) -> String {
        let mut text = String::new();
        for (topic, wanted) in &self.0 {
            let described = fields(*topic).into_iter().flat_map(|described: Described| {
                let columns = described.field.columns(&topic.prefix());
                columns.into_iter().map(move |c| (c, described.clone()))
            });
            for ((column, described), _) in described.zip(wanted).filter(|(_, wanted)| **wanted) {
                describe_column(&mut text, &column, &described);
            }
        }
        text
    }

    /// Visits the numbers that a message holds.
    fn visit<V: Visitor>(&self, v: &mut V, row: &mut Row) -> Result<(), V::Error> {
        self.0.iter().try_for_each(|(topic, wanted)| {
            let wanted = wanted.iter();
            topic.visit(&mut Picked { inner: v, wanted }, row)
        })
    }
}

/// Passes on to `inner` only the wanted numbers.
struct Picked<'a, V> {
    inner: &'a mut V,
    wanted: std::slice::Iter<'a, bool>,
}

impl<V: Visitor> Visitor for Picked<'_, V> {
    type Error = V::Error;

    fn numbers<T: Number>(&mut self, field: &Field, values: &mut [T]) -> Result<(), V::Error> {
        for value in values {
            if self.wanted.next() == Some(&true) {
                self.inner.numbers(field, std::slice::from_mut(value))?;
            }
        }
        Ok(())
    }

    fn choice(&mut self, field: &Field, words: Words, code: &mut u8) -> Result<(), V::Error> {
        match self.wanted.next() {
            Some(true) => self.inner.choice(field, words, code),
            _ => Ok(()),
        }
    }
}

/// Finds the columns whose bits differ from those of the first cycle.
#[derive(Default)]
struct Changes {
    first: Vec<u64>,
    changes: Vec<bool>,
    place: usize,
}

impl EachNumber for Changes {
    fn number<T: Number>(&mut self, value: T) {
        let mut word = [0; 8];
        let bytes = value.to_bytes();
        let bytes = bytes.as_ref();
        word.iter_mut()
            .zip(bytes)
            .for_each(|(to, from)| *to = *from);
        let word = u64::from_le_bytes(word);
        match self.first.get(self.place) {
            Some(first) => self.changes[self.place] |= *first != word,
            None => {
                self.first.push(word);
                self.changes.push(false);
            }
        }
        self.place += 1;
    }
}

/// Names of the columns that are not constant.
pub(super) fn changing(cycles: &[CycleRecord], truth: &[TruthRecord]) -> BTreeSet<String> {
    let topics = Topic::all(!truth.is_empty());
    let mut changes = Changes::default();
    for (n, cycle) in cycles.iter().enumerate() {
        changes.place = 0;
        let mut row = Row {
            truth: truth.get(n).copied().unwrap_or_default(),
            ..row(*cycle)
        };
        for topic in topics {
            let Ok(()) = topic.visit(&mut changes, &mut row);
        }
    }
    let all = topics.iter().flat_map(|topic| columns(*topic));
    let changing = all.zip(changes.changes).filter(|(_, changes)| *changes);
    changing.map(|(column, _)| column).collect()
}

/// The cells of a cycle, one for each column of all topics.
fn cells(cycle: CycleRecord) -> Vec<String> {
    let mut writer = CellWriter::default();
    for topic in Topic::all(false) {
        let Ok(()) = topic.visit(&mut writer, &mut row(cycle));
    }
    writer.cells
}

/// Values as text by the name of the column.
type Constants = BTreeMap<String, String>;

/// The constant columns, without those that have the value of an empty cycle.
fn constants(first: &CycleRecord, changing: &BTreeSet<String>) -> Constants {
    let values = cells(*first).into_iter().zip(cells(CycleRecord::default()));
    all_columns()
        .zip(values)
        .filter(|(name, (value, empty))| {
            value != empty && !changing.contains(name) && name != CYCLE
        })
        .map(|(name, (value, _))| (name, value))
        .collect()
}

/// A cycle with these constants; all other numbers are those of an empty cycle.
fn cycle_of(mut constants: Constants) -> anyhow::Result<CycleRecord> {
    let empty = cells(CycleRecord::default()).into_iter();
    let cells: csv::StringRecord = all_columns()
        .zip(empty)
        .map(|(name, empty)| constants.remove(&name).unwrap_or(empty))
        .collect();
    if let Some(unknown) = constants.keys().next() {
        bail!("topic `{TOPIC}` has a constant `{unknown}`, which no recording has");
    }
    let mut row = Row::default();
    let mut reader = CellReader::new(&cells);
    Topic::all(false)
        .iter()
        .try_for_each(|topic| topic.visit(&mut reader, &mut row))
        .with_context(|| format!("a constant of topic `{TOPIC}`"))?;
    Ok(row.cycle)
}

/// Constants that are lost unless a number that changes is stored too. An example is the limit of a fault: where there is no
/// fault, a cycle has no place for it.
fn lost_alone(
    first: &CycleRecord,
    changing: &BTreeSet<String>,
) -> anyhow::Result<BTreeSet<String>> {
    let constants = constants(first, changing);
    let kept = all_columns().zip(cells(cycle_of(constants.clone())?));
    Ok(kept
        .filter(|(name, cell)| constants.get(name).is_some_and(|constant| constant != cell))
        .map(|(name, _)| name)
        .collect())
}

/// Columns of all topics.
fn all_columns() -> impl Iterator<Item = String> {
    Topic::all(false).iter().flat_map(|topic| columns(*topic))
}

fn row(cycle: CycleRecord) -> Row {
    Row {
        cycle,
        ..Row::default()
    }
}

fn time_ns(cycle: &CycleRecord) -> u64 {
    (cycle.trace.time_s * NS_PER_S).round() as u64
}

fn time_s(time_ns: u64) -> f64 {
    time_ns as f64 / NS_PER_S
}

/// Whether a recording is stored as a table: another program made it, and the numbers of its cycles fit into a message's
/// `sequence`.
pub(super) fn fits(recording: &Recording) -> bool {
    let numbered = |cycle: &CycleRecord| u32::try_from(cycle.trace.cycle).is_ok();
    recording.header.settings_toml.is_empty()
        && recording.truth.is_empty()
        && !recording.cycles.is_empty()
        && recording.cycles.iter().all(numbered)
}

/// The topic of a recording that [`fits`].
pub(super) struct TableTopic {
    layout: Layout,
    constants: Constants,
}

impl TableTopic {
    pub(super) fn new(recording: &Recording) -> anyhow::Result<Self> {
        let cycles = recording.cycles.as_slice();
        let first = cycles
            .first()
            .context("a recording without cycles has no columns")?;
        let mut changing = changing(cycles, &[]);
        changing.extend(lost_alone(first, &changing)?);
        let exact = |c: &CycleRecord| time_s(time_ns(c)).to_bits() == c.trace.time_s.to_bits();
        let time_is_exact = cycles.iter().all(exact);
        let layout = Layout::of(|column| match column {
            CYCLE => false,
            TIME => !time_is_exact,
            other => changing.contains(other),
        });
        let constants = constants(first, &changing);
        Ok(Self { layout, constants })
    }

    /// Adds the channel to a file and returns its number.
    pub(super) fn add_to<W: Write + Seek>(
        &self,
        mcap: &mut mcap::Writer<W>,
    ) -> anyhow::Result<u16> {
        let schema = mcap.add_schema(SCHEMA, SCHEMA_ENCODING, self.layout.ros2msg().as_bytes())?;
        let mut metadata = channel_metadata();
        metadata.extend(self.constants.clone());
        Ok(mcap.add_channel(schema, TOPIC, MESSAGE_ENCODING, &metadata)?)
    }

    /// The message of a cycle.
    pub(super) fn encode(&self, message: &mut Encoder, cycle: &CycleRecord) {
        let Ok(()) = self.layout.visit(message, &mut row(*cycle));
    }
}

/// Writes a recording for which [`fits`] holds.
pub(super) fn write<W: Write>(recording: &Recording, sink: W) -> anyhow::Result<W> {
    let topic = TableTopic::new(recording)?;
    let mut mcap = WriteOptions::new()
        .compression(Some(Compression::Zstd))
        .compression_level(LEVEL)
        .compression_threads(0)
        .profile(PROFILE)
        .library(LIBRARY)
        .chunk_size(None)
        .disable_seeking(true)
        .emit_message_indexes(false)
        .emit_chunk_indexes(false)
        .create(NoSeek::new(sink))?;
    mcap.write_metadata(&metadata(&recording.header, recording.cut.as_deref()))?;
    if let Some(clock) = &recording.wall_clock {
        mcap.write_metadata(&clock.metadata())?;
    }
    let channel_id = topic.add_to(&mut mcap)?;
    let mut encoder = Encoder::default();
    for chunk in recording.cycles.chunks(CHUNK_CYCLES) {
        for cycle in chunk {
            encoder.begin();
            topic.encode(&mut encoder, cycle);
            let header = MessageHeader {
                channel_id,
                sequence: cycle.trace.cycle as u32,
                log_time: time_ns(cycle),
                publish_time: time_ns(cycle),
            };
            mcap.write_to_known_channel(&header, encoder.bytes())?;
        }
        mcap.flush()?;
    }
    mcap.finish()?;
    let mut sink = mcap.into_inner().into_inner();
    sink.flush()?;
    Ok(sink)
}

/// Reads the messages of a table.
#[derive(Debug)]
pub(super) struct TableReader {
    constants: CycleRecord,
    layout: Layout,
    /// Whether the time is a column.
    timed: bool,
}

impl TableReader {
    /// Reads schema and metadata of the channel. Metadata other than that of ROS 2 are constants.
    pub(super) fn new(schema: &str, metadata: &BTreeMap<String, String>) -> anyhow::Result<Self> {
        let mut constants = metadata.clone();
        constants.remove(QOS);
        let declared = schema.lines().filter(|line| !line.starts_with('#'));
        let columns: BTreeSet<&str> = declared
            .filter_map(|line| line.split_once(' ').map(|(_, name)| name))
            .collect();
        let layout = Layout::of(|column| columns.contains(column));
        ensure!(
            declarations(&layout.ros2msg()).eq(declarations(schema)),
            "topic `{TOPIC}` has other columns than a recording can have: {schema:?}"
        );
        Ok(Self {
            constants: cycle_of(constants)?,
            timed: columns.contains(TIME),
            layout,
        })
    }

    /// The cycle of a message.
    pub(super) fn cycle(&self, header: &MessageHeader, data: &[u8]) -> anyhow::Result<CycleRecord> {
        let mut row = row(self.constants);
        let mut decode = || -> Result<(), CdrError> {
            let mut decoder = Decoder::new(data)?;
            self.layout.visit(&mut decoder, &mut row)?;
            decoder.finish()
        };
        decode().with_context(|| format!("a message on `{TOPIC}`"))?;
        let mut cycle = row.cycle;
        cycle.trace.cycle = header.sequence.into();
        if !self.timed {
            cycle.trace.time_s = time_s(header.log_time);
        }
        Ok(cycle)
    }
}
