//! Copies a recording for programs that know ROS 2: all of its topics, and beside them standard messages that Foxglove, RViz
//! and others draw without configuration. A model's prediction can be added to the measured quantities.
//!
//! - `definitions` has the text of the standard messages, `messages` writes their bytes,
//! - `stamped` lists wrenches, poses and velocities, each with its frame,
//! - `laboratory` computes the poses of the frames, `markers` draws objects at them.
//!
//! A recording itself contains no such messages: it would be half as long again, and they can all be computed from it.

mod definitions;
mod laboratory;
mod markers;
mod messages;
mod stamped;

use super::cdr::Encoder;
use super::file_format::{LIBRARY, MESSAGE_ENCODING, SCHEMA_ENCODING, channel_metadata, metadata};
use super::numbers::NumbersTopic;
use super::schema::ros2msg;
use super::table::{self, TableTopic};
use super::topics::{Form, Row, Topic};
use super::{PROFILE, Recording, TruthRecord, WallClock};
use crate::data_table::DataTable;
use crate::output::write_whole_with;
use anyhow::{Context, Result, ensure};
use definitions::Definition;
use laboratory::Laboratory;
use markers::Contact;
use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{Compression, WriteOptions};
use softdock_app::record::CycleRecord;
use stamped::Stamped;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Cycles in a chunk: four seconds of 4 ms cycles.
const CHUNK_CYCLES: usize = 1024;

impl Recording {
    /// Writes the copy for viewers. `series` is what a model predicts: its first column is the time, and it has one row per
    /// cycle. Time stamps are of the wall clock where the recording knows it.
    ///
    /// # Errors
    /// The number of rows and cycles differs, or the file cannot be written.
    pub fn write_ros2(&self, series: Option<&DataTable>, path: &Path) -> Result<()> {
        write_whole_with(path, |file| {
            let mut copy = CopyWriter::new(BufWriter::new(file), self, series)?;
            let truths = self.truths()?;
            for (n, (cycle, truth)) in self.cycles.iter().zip(truths).enumerate() {
                copy.push(n, cycle, truth)?;
            }
            copy.finish()
        })
    }
}

/// The topics of the recording itself, with their channels.
enum Recorded {
    Topics(Vec<(Topic, u16)>),
    /// The log of another program.
    Table(TableTopic, u16),
}

/// A copy that is being written.
struct CopyWriter<'a, W: Write> {
    out: Output<W>,
    clock: Option<WallClock>,
    recorded: Recorded,
    series: Option<(NumbersTopic<'a>, u16)>,
    stamped: Vec<(&'static Stamped, u16)>,
    laboratory: Laboratory,
    contact: Contact,
    /// Channels of the moving frames, the fixed frames, the static markers and the contact force.
    tf: u16,
    tf_static: u16,
    scene: u16,
    arrow: u16,
}

impl<'a, W: Write> CopyWriter<'a, W> {
    fn new(sink: W, recording: &Recording, series: Option<&'a DataTable>) -> Result<Self> {
        let mut out = Output::new(sink)?;
        let (header, cut) = (&recording.header, recording.cut.as_deref());
        out.mcap.write_metadata(&metadata(header, cut))?;
        if let Some(clock) = &recording.wall_clock {
            out.mcap.write_metadata(&clock.metadata())?;
        }
        let series = series.map(|table| -> Result<_> {
            let (rows, cycles) = (table.rows(), recording.cycles.len());
            ensure!(
                rows == cycles,
                "expected a row of series for each of {cycles} cycles, received {rows}"
            );
            let topic = NumbersTopic::new(table, "softdock/msg/Compare")?;
            let channel = out.channel("/compare", topic.schema_name, &topic.ros2msg())?;
            Ok((topic, channel))
        });
        let settings = header.control_settings().ok();
        Ok(Self {
            // A table's messages have the times of its cycles, without a wall clock.
            clock: recording.wall_clock.filter(|_| !table::fits(recording)),
            recorded: out.recorded(recording)?,
            series: series.transpose()?,
            stamped: out.stamped(&recording.cycles)?,
            contact: Contact::new(settings.as_ref(), &recording.cycles),
            laboratory: Laboratory::new(settings),
            tf: out.standard("/tf", &definitions::TF_MESSAGE)?,
            tf_static: out.standard("/tf_static", &definitions::TF_MESSAGE)?,
            scene: out.standard("/scene", &definitions::MARKER_ARRAY)?,
            arrow: out.standard("/contact", &definitions::MARKER_ARRAY)?,
            out,
        })
    }

    fn push(&mut self, n: usize, cycle: &CycleRecord, truth: Option<&TruthRecord>) -> Result<()> {
        let out = &mut self.out;
        out.at(cycle, self.clock)?;
        match &self.recorded {
            Recorded::Table(topic, channel) => out.message(*channel, |m| topic.encode(m, cycle))?,
            Recorded::Topics(topics) => {
                let mut row = Row {
                    cycle: *cycle,
                    truth: truth.copied().unwrap_or_default(),
                    ..Row::default()
                };
                for (topic, channel) in topics {
                    out.message(*channel, |message| {
                        let Ok(()) = topic.visit(message, &mut row);
                    })?;
                }
            }
        }
        if let Some((topic, channel)) = &self.series {
            out.message(*channel, |message| topic.row(n, message))?;
        }
        let time_ns = out.time_ns;
        for (stamped, channel) in &self.stamped {
            out.message(*channel, |message| stamped.write(message, time_ns, cycle))?;
        }
        if self.laboratory.see(&cycle.trace) {
            let frames = self.laboratory.fixed();
            out.message(self.tf_static, |m| {
                messages::transforms(m, time_ns, &frames)
            })?;
            let scene = markers::scene(self.laboratory.settings(), &frames);
            out.message(self.scene, |m| markers::write(m, time_ns, &scene))?;
        }
        let frames = self.laboratory.moving(&cycle.trace);
        out.message(self.tf, |m| messages::transforms(m, time_ns, &frames))?;
        let markers = self.contact.markers(&cycle.trace);
        out.message(self.arrow, |m| markers::write(m, time_ns, &markers))?;
        if (n + 1).is_multiple_of(CHUNK_CYCLES) {
            out.mcap.flush()?;
        }
        Ok(())
    }

    fn finish(mut self) -> Result<()> {
        self.out.mcap.finish()?;
        let mut sink = self.out.mcap.into_inner().into_inner();
        Ok(sink.flush()?)
    }
}

/// The file, and the time and number of the messages that are written next.
struct Output<W: Write> {
    mcap: mcap::Writer<NoSeek<W>>,
    encoder: Encoder,
    time_ns: u64,
    sequence: u32,
}

impl<W: Write> Output<W> {
    fn new(sink: W) -> Result<Self> {
        let mcap = WriteOptions::new()
            .compression(Some(Compression::Zstd))
            .compression_threads(0)
            .profile(PROFILE)
            .library(LIBRARY)
            // Chunks are ended explicitly, between two cycles.
            .chunk_size(None)
            .disable_seeking(true)
            .create(NoSeek::new(sink))?;
        Ok(Self {
            mcap,
            encoder: Encoder::default(),
            time_ns: 0,
            sequence: 0,
        })
    }

    fn channel(&mut self, topic: &str, schema: &str, definition: &str) -> Result<u16> {
        let definition = definition.as_bytes();
        let schema = self.mcap.add_schema(schema, SCHEMA_ENCODING, definition)?;
        let metadata = channel_metadata();
        let added = self
            .mcap
            .add_channel(schema, topic, MESSAGE_ENCODING, &metadata);
        Ok(added?)
    }

    fn standard(&mut self, topic: &str, definition: &Definition) -> Result<u16> {
        self.channel(topic, definition.name, &definition.text())
    }

    fn recorded(&mut self, recording: &Recording) -> Result<Recorded> {
        if table::fits(recording) {
            let topic = TableTopic::new(recording)?;
            let channel = topic.add_to(&mut self.mcap)?;
            return Ok(Recorded::Table(topic, channel));
        }
        let topics = Topic::all(!recording.truth.is_empty()).iter();
        let channel = |topic: &Topic| {
            let schema = Form::from(*topic).schema_name();
            let channel = self.channel(topic.name(), &schema, &ros2msg(*topic))?;
            Ok((*topic, channel))
        };
        let topics: Result<_> = topics.map(channel).collect();
        Ok(Recorded::Topics(topics?))
    }

    /// The stamped topics that are known in any of the cycles: a log of another program has few.
    fn stamped(&mut self, cycles: &[CycleRecord]) -> Result<Vec<(&'static Stamped, u16)>> {
        let known = stamped::ALL.iter();
        let known = known.filter(|stamped| cycles.iter().any(|cycle| stamped.is_known(cycle)));
        known
            .map(|stamped| Ok((stamped, self.standard(stamped.topic, stamped.definition())?)))
            .collect()
    }

    /// Sets time and number of the following messages to those of this cycle.
    fn at(&mut self, cycle: &CycleRecord, clock: Option<WallClock>) -> Result<()> {
        let time_s = cycle.trace.time_s;
        let past = clock.unwrap_or_default().unix_ns(time_s);
        self.time_ns = past.with_context(|| format!("a cycle at {time_s} s is before 1970"))?;
        self.sequence = cycle.trace.cycle as u32;
        Ok(())
    }

    fn message(&mut self, channel_id: u16, write: impl FnOnce(&mut Encoder)) -> Result<()> {
        self.encoder.begin();
        write(&mut self.encoder);
        let header = MessageHeader {
            channel_id,
            sequence: self.sequence,
            log_time: self.time_ns,
            publish_time: self.time_ns,
        };
        let message = self.encoder.bytes();
        Ok(self.mcap.write_to_known_channel(&header, message)?)
    }
}
