//! Writes a recording as an MCAP file while the run goes on.
//!
//! A chunk is built in memory and handed to the operating system as a whole, a quarter of a second of cycles at a time.
//! However the program ends, the file holds every chunk before.

use super::cdr::Encoder;
use super::file_format::{LIBRARY, MESSAGE_ENCODING, SCHEMA_ENCODING, channel_metadata, metadata};
use super::mcap_file::{McapFile, Stamp};
use super::recomputation::checksum;
use super::schema::ros2msg;
use super::topics::{Form, Row, Topic};
use super::{Header, PROFILE, Recording, TruthRecord, WallClock, table};
use crate::output::{cannot_write, write_whole_with};
use anyhow::ensure;
use mcap::records::{Channel, Metadata};
use softdock_app::record::CycleRecord;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Cycles in a chunk: a quarter of a second of 4 ms cycles, 100 to 130 kB before compression.
pub(super) const CHUNK_CYCLES: u32 = 64;
/// Compression level of zstd: the fastest, which reduces a chunk to a quarter. In motion that quarter is mostly digits of
/// numbers that are new in each cycle: level 9 saves 5 % in seven times the time, level 19 saves 12 % in 300 times. Messages
/// grouped by topic are 2 % smaller in motion, 8 % larger at rest; grouped, at level 19, in chunks of 1024 cycles they are a
/// quarter smaller.
const LEVEL: i32 = 1;

/// Writes cycles one by one.
///
/// ```no_run
/// # fn main() -> anyhow::Result<()> {
/// use softdock_io::recording::{Header, RecordingWriter};
/// use softdock_app::record::CycleRecord;
/// let mut writer = RecordingWriter::create("run.mcap".as_ref(), &Header::default())?;
/// writer.push(&CycleRecord::default(), None)?;
/// writer.finish()?;
/// # Ok(())
/// # }
/// ```
///
/// Dropping the writer ends its file as far as that is possible, but errors are lost.
pub struct RecordingWriter<W: Write = BufWriter<File>> {
    mcap: McapFile<W>,
    /// Topics with the numbers of their channels; empty before the first cycle.
    channels: Vec<(Form, u16)>,
    truth: bool,
    /// Whether computed numbers are in single precision.
    single: bool,
    /// Buffer for checksums.
    scratch: Encoder,
    cycles_in_chunk: u32,
    /// Wall clock; where it is not known, time counts from the board's first cycle.
    clock: WallClock,
    /// Path of the file, for errors.
    path: Option<PathBuf>,
}

impl RecordingWriter {
    /// Creates or overwrites the file.
    pub fn create(path: &Path, header: &Header) -> anyhow::Result<Self> {
        File::create(path)
            .map_err(anyhow::Error::from)
            .and_then(|file| Self::new(BufWriter::new(file), header))
            .map(|writer| Self {
                path: Some(path.to_owned()),
                ..writer
            })
            .map_err(|error| cannot_write(path, error))
    }
}

/// Adds the path of the file to an error.
fn named<T>(path: Option<&Path>, written: anyhow::Result<T>) -> anyhow::Result<T> {
    match path {
        Some(path) => written.map_err(|error| cannot_write(path, error)),
        None => written,
    }
}

impl<W: Write> RecordingWriter<W> {
    /// Begins a recording on any sink.
    pub fn new(sink: W, header: &Header) -> anyhow::Result<Self> {
        Self::with_cut(sink, header, None)
    }

    /// Begins the copy of a recording that may have been cut off; `cut` is the reason.
    fn with_cut(sink: W, header: &Header, cut: Option<&str>) -> anyhow::Result<Self> {
        // There are no indexes. That of messages has 16 bytes for each, uncompressed: half of the file. An index of chunks
        // alone is an error to MCAP's reader in TypeScript.
        let mut mcap = McapFile::new(sink, PROFILE, LIBRARY, LEVEL)?;
        mcap.write_metadata(&metadata(header, cut))?;
        mcap.flush()?;
        Ok(Self {
            mcap,
            channels: Vec::new(),
            truth: false,
            single: false,
            scratch: Encoder::default(),
            cycles_in_chunk: 0,
            clock: WallClock::default(),
            path: None,
        })
    }

    /// Marks a run that this program computes. If the recording has its beginning, it can be computed again, so computed
    /// numbers are stored in single precision: see `recomputation`. To be called before the first cycle is pushed.
    #[must_use]
    pub fn simulated(self) -> Self {
        let single = true;
        Self { single, ..self }
    }

    /// Appends a cycle. `truth` is given for every cycle (a simulated rig) or for none.
    pub fn push(&mut self, cycle: &CycleRecord, truth: Option<&TruthRecord>) -> anyhow::Result<()> {
        let pushed = self.append(cycle, truth);
        named(self.path.as_deref(), pushed)
    }

    fn append(&mut self, cycle: &CycleRecord, truth: Option<&TruthRecord>) -> anyhow::Result<()> {
        if self.channels.is_empty() {
            self.single &= cycle.trace.cycle == 0;
            self.begin(truth.is_some())?;
        }
        ensure!(
            self.truth == truth.is_some(),
            "cycle {}: the rig's truth is recorded for every cycle or for none",
            cycle.trace.cycle
        );
        let mut row = Row {
            cycle: *cycle,
            truth: truth.copied().unwrap_or_default(),
            ..Row::default()
        };
        if self.single {
            row.checksum = checksum(&mut self.scratch, &mut row);
        }
        // Shown by viewers; a replay uses the time in the message.
        let time_ns = self.clock.unix_ns(cycle.trace.time_s).unwrap_or_default();
        let stamp = Stamp {
            // For readers that count messages: the number of the cycle, which wraps after 198 days.
            sequence: cycle.trace.cycle as u32,
            time_ns,
        };
        for (form, channel) in &self.channels {
            self.mcap.message(*channel, stamp, |message| {
                let Ok(()) = form.visit(message, &mut row);
            });
        }
        self.cycles_in_chunk += 1;
        if self.cycles_in_chunk == CHUNK_CYCLES {
            self.cycles_in_chunk = 0;
            self.mcap.flush()?;
        }
        Ok(())
    }

    /// Notes the time of day of one of its cycles. To be called before the first cycle is pushed.
    pub(super) fn note_clock(&mut self, clock: WallClock) -> anyhow::Result<()> {
        let Metadata { name, metadata } = clock.metadata();
        self.note(&name, metadata)?;
        self.clock = clock;
        Ok(())
    }

    /// Adds metadata that became known during the recording, under a name of its own. Readers of MCAP show it; the header of
    /// the recording stays unchanged.
    pub fn note(&mut self, name: &str, entries: BTreeMap<String, String>) -> anyhow::Result<()> {
        let name = name.to_owned();
        let metadata = entries;
        // Writing metadata ends the present chunk.
        self.cycles_in_chunk = 0;
        self.mcap.write_metadata(&Metadata { name, metadata })
    }

    /// Ends the recording and returns the sink.
    pub fn finish(self) -> anyhow::Result<W> {
        named(self.path.as_deref(), self.mcap.finish())
    }

    /// Adds schemas and channels to the first chunk.
    fn begin(&mut self, truth: bool) -> anyhow::Result<()> {
        self.truth = truth;
        let topics = Topic::all(truth).iter().copied();
        let forms: Vec<Form> = if self.single {
            let checksum = Form::Full(Topic::Checksum);
            topics.map(Topic::in_single).chain([checksum]).collect()
        } else {
            topics.map(Form::Full).collect()
        };
        for form in forms {
            let (name, text) = (form.schema_name(), ros2msg(form));
            let schema = (name.as_str(), SCHEMA_ENCODING, text.as_str());
            let channel = Channel {
                id: 0,
                schema_id: 0,
                topic: form.topic().name().to_owned(),
                message_encoding: MESSAGE_ENCODING.to_owned(),
                metadata: channel_metadata(),
            };
            let id = self.mcap.add_channel(schema, channel)?;
            self.channels.push((form, id));
        }
        Ok(())
    }
}

impl Recording {
    /// Writes the recording into a file, whole or not at all.
    ///
    /// # Errors
    /// Those of [`write_whole_with`].
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        write_whole_with(path, |file| self.write_to(BufWriter::new(file)).map(drop))
    }

    /// Writes the recording into any sink and returns the sink.
    pub fn write_to<W: Write>(&self, sink: W) -> anyhow::Result<W> {
        if table::fits(self) {
            return table::write(self, sink);
        }
        let truths = self.truths()?;
        let mut writer = RecordingWriter::with_cut(sink, &self.header, self.cut.as_deref())?;
        if let Some(clock) = self.wall_clock {
            writer.note_clock(clock)?;
        }
        for (cycle, truth) in self.cycles.iter().zip(truths) {
            writer.push(cycle, truth)?;
        }
        writer.finish()
    }

    /// The truth of each cycle; `None` for each cycle of a real rig.
    pub(super) fn truths(&self) -> anyhow::Result<impl Iterator<Item = Option<&TruthRecord>> + '_> {
        let (cycles, truths) = (self.cycles.len(), self.truth.len());
        ensure!(
            truths == 0 || truths == cycles,
            "expected the rig's truth for all {cycles} cycles or for none, received {truths}"
        );
        Ok((0..cycles).map(|i| self.truth.get(i)))
    }
}
