//! Reads a recording from an MCAP file, up to the last whole chunk of a file that was cut off.
//!
//! A chunk is used only after its checksum was found right, so that nothing half-written or
//! damaged gets into a recording. The file may come from anywhere: no length in it is trusted.

use super::cdr::Decoder;
use super::file_format::{MESSAGE_ENCODING, NS_PER_S, SCHEMA_ENCODING};
use super::outline::Outline;
use super::recomputation::{Recomputation, Rounded};
use super::schema::{declarations, ros2msg, ros2msg_of_arrays};
use super::table::{self, TableReader};
use super::topics::{Form, Row, Topic};
use super::{FORMAT, Header, METADATA, OWN_PROFILE, PROFILE, Recording, WALL_CLOCK, WallClock};
use crate::identity;
use anyhow::{Context, bail, ensure};
use mcap::records::{Metadata, Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError, Summary, parse_record};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

/// Largest chunk that is decompressed, bytes: sixteen times the default of other programs. A few forged bytes could otherwise
/// claim any size.
const LARGEST_CHUNK: usize = 64 << 20;

impl Recording {
    /// Reads a file. If it was cut off or damaged, the recording holds the whole chunks before,
    /// and [`Recording::cut`] says what happened. Files of other programs and other versions are
    /// errors.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        File::open(path)
            .and_then(|file| Ok((file.metadata()?.len(), file)))
            .map_err(anyhow::Error::from)
            .and_then(|(length, file)| Self::read_from(BufReader::new(file), length))
            .with_context(|| format!("cannot read the recording `{}`", path.display()))
    }

    /// Reads a recording of `length` bytes from any source.
    pub fn read_from(mut source: impl Read, length: u64) -> anyhow::Result<Self> {
        let mut start = Vec::new();
        let magic_length = MAGIC.len() as u64;
        source.by_ref().take(magic_length).read_to_end(&mut start)?;
        let is_text = start
            .iter()
            .all(|byte| byte.is_ascii_graphic() || byte.is_ascii_whitespace());
        let hint = if is_text {
            "; it is a text: were two files swapped? (`softdock import` makes a recording of a table)"
        } else {
            ""
        };
        ensure!(
            MAGIC.starts_with(&start),
            "not an MCAP file: expected the first bytes {MAGIC:02x?}, received {start:02x?}{hint}"
        );

        let mut loader = Loader::default();
        let options = LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_record_length_limit(usize::try_from(length)?);
        let mut source = start.as_slice().chain(source);
        let end = each_record(options, &mut source, |opcode, body| {
            loader.file_record(opcode, body)
        })?;
        loader.finish(end, length)
    }
}

/// Why and where reading ended before the end of the file.
pub(super) struct Broken {
    why: McapError,
    /// End of the last whole record.
    byte: u64,
}

/// Calls `each` with each complete record. An error of `each` ends the walk. A break of the file, found by the reader or by
/// `each`, is returned.
pub(super) fn each_record(
    options: LinearReaderOptions,
    source: &mut impl Read,
    mut each: impl FnMut(u8, &[u8]) -> anyhow::Result<Option<McapError>>,
) -> anyhow::Result<Option<Broken>> {
    let mut reader = LinearReader::new_with_options(options);
    let (mut fed, mut byte) = (0, 0);
    while let Some(event) = reader.next_event() {
        let broken = match event {
            Ok(LinearReadEvent::ReadRequest(wanted)) => {
                let read = source.read(reader.insert(wanted))?;
                reader.notify_read(read);
                fed += read as u64;
                continue;
            }
            Ok(LinearReadEvent::Record { opcode, data }) => each(opcode, data)?,
            Err(why) => Some(why),
        };
        if let Some(why) = broken {
            return Ok(Some(Broken { why, byte }));
        }
        // The reader never asks for bytes beyond the present record.
        byte = fed;
    }
    Ok(None)
}

/// Builds a recording from the records of a file.
#[derive(Default)]
pub(super) struct Loader {
    /// Whether the file's first record was seen and is the header of a softdock file.
    ours: bool,
    /// Header of the recording, once it was read.
    pub(super) header: Option<Header>,
    recording: Recording,
    schemas: BTreeMap<u16, (String, String, Vec<u8>)>,
    channels: BTreeMap<u16, Form>,
    /// Whether the file has the rig's truth.
    truth: bool,
    /// Whether computed numbers are in single precision, with a checksum.
    single: bool,
    /// Recomputes these numbers, as long as the checksums agree.
    recomputation: Option<Recomputation>,
    /// The cycle whose messages are being read.
    row: Row,
    /// Bits of the topics that were read of this cycle.
    seen: u16,
    /// Channel and reader of a table, if the cycles are rows of one.
    table: Option<(u16, TableReader)>,
}

impl Loader {
    /// Takes a record outside of chunks. Returns an error of the format if the file is damaged there.
    pub(super) fn file_record(
        &mut self,
        opcode: u8,
        body: &[u8],
    ) -> anyhow::Result<Option<McapError>> {
        if !self.ours {
            ensure!(
                opcode == op::HEADER,
                "not a softdock recording: an MCAP file begins with a header record"
            );
            let Record::Header(header) = parse_record(opcode, body)? else {
                return Ok(None);
            };
            ensure!(
                [PROFILE, OWN_PROFILE].contains(&header.profile.as_str()),
                "this MCAP file is not a softdock recording: expected profile `{PROFILE}`, \
                 received `{}`, written by `{}`",
                header.profile,
                header.library
            );
            self.ours = true;
            return Ok(None);
        }
        match opcode {
            op::METADATA => self.metadata(body)?,
            op::CHUNK => return self.chunk(body),
            op::DATA_END => {
                self.header.as_ref().with_context(no_header)?;
            }
            // Indexes, and records that other programs may have added.
            _ => {}
        }
        Ok(None)
    }

    fn metadata(&mut self, body: &[u8]) -> anyhow::Result<()> {
        let record = parse_record(op::METADATA, body).context("a damaged header")?;
        let Record::Metadata(Metadata { name, mut metadata }) = record else {
            return Ok(());
        };
        if name == WALL_CLOCK {
            self.recording.wall_clock = WallClock::from_entries(&metadata);
        }
        if name != METADATA || self.header.is_some() {
            return Ok(());
        }
        let format = metadata.remove("format").unwrap_or_default();
        ensure!(
            format == FORMAT,
            "expected a recording of format `{FORMAT}`, received `{format}`: read it with the \
             version of softdock that recorded it"
        );
        let mut entry = |key: &str| {
            let missing = || format!("the header of the recording lacks `{key}`");
            metadata.remove(key).with_context(missing)
        };
        self.header = Some(Header {
            identity: entry("identity")?,
            settings_toml: entry("settings")?,
            scenario_toml: entry("scenario").ok(),
            whole_turns: match entry("whole_turns") {
                Ok(turns) => turns
                    .parse()
                    .context("`whole_turns` in the header of the recording")?,
                Err(_) => 0,
            },
            began: match entry("began") {
                Ok(began) => Some(
                    serde_json::from_str(&began)
                        .context("`began` in the header of the recording")?,
                ),
                Err(_) => None,
            },
        });
        self.recording.cut = metadata.remove("cut");
        Ok(())
    }

    /// Takes all cycles of a chunk if it is undamaged.
    fn chunk(&mut self, body: &[u8]) -> anyhow::Result<Option<McapError>> {
        self.header.as_ref().with_context(no_header)?;
        let (header, data) = match parse_record(op::CHUNK, body) {
            Ok(Record::Chunk { header, data }) => (header, data),
            Ok(_) => return Ok(None),
            Err(why) => return Ok(Some(why)),
        };
        ensure!(
            matches!(header.compression.as_str(), "" | "zstd"),
            "the recording was compressed (`{}`) by another program: decompress it first, for \
             example with `mcap decompress`",
            header.compression
        );
        // Record: opcode, length. Chunk: two times, size, checksum, length of the compression's name, size.
        const RECORD_HEAD: usize = 1 + 8;
        const CHUNK_HEAD: usize = 8 + 8 + 8 + 4 + 4 + 8;
        if body.len() != CHUNK_HEAD + header.compression.len() + data.len() {
            return Ok(Some(McapError::UnexpectedEoc));
        }
        let mut head = [op::CHUNK; RECORD_HEAD];
        if let Some(length) = head.last_chunk_mut() {
            *length = (body.len() as u64).to_le_bytes();
        }
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(body.len().max(LARGEST_CHUNK));
        let end = each_record(options, &mut head.as_slice().chain(body), |opcode, body| {
            self.chunk_record(opcode, body)
                .with_context(|| format!("after {} whole cycles", self.recording.cycles.len()))
                .map(|()| None)
        })?;
        ensure!(
            self.seen == 0,
            "cycle {} ends without {}",
            self.recording.cycles.len(),
            self.missing()
        );
        Ok(end.map(|broken| broken.why))
    }

    fn chunk_record(&mut self, opcode: u8, body: &[u8]) -> anyhow::Result<()> {
        if !matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
            return Ok(());
        }
        match parse_record(opcode, body)? {
            Record::Schema { header, data } => {
                let schema = (header.name, header.encoding, data.into_owned());
                self.schemas.insert(header.id, schema);
            }
            Record::Channel(channel) => self.channel(&channel)?,
            Record::Message { header, data } => match &self.table {
                Some((id, table)) if *id == header.channel_id => {
                    self.recording.cycles.push(table.cycle(&header, &data)?);
                }
                _ => self.message(header.channel_id, &data)?,
            },
            _ => {}
        }
        Ok(())
    }

    /// Registers a channel. One of softdock must have the known schema; others are ignored.
    fn channel(&mut self, channel: &mcap::records::Channel) -> anyhow::Result<()> {
        let schema = self.schemas.get(&channel.schema_id);
        if channel.topic == table::TOPIC {
            let text = schema.map(|(_, _, text)| String::from_utf8_lossy(text));
            let reader = TableReader::new(&text.unwrap_or_default(), &channel.metadata)?;
            self.table = Some((channel.id, reader));
            return Ok(());
        }
        let Some(topic) = Topic::from_name(&channel.topic) else {
            return Ok(());
        };
        let is = |form: &Form| {
            schema.is_some_and(|(name, encoding, text)| {
                let text = String::from_utf8_lossy(text);
                let known = [ros2msg(*form), ros2msg_of_arrays(*form)];
                *name == form.schema_name()
                    && encoding == SCHEMA_ENCODING
                    && known
                        .iter()
                        .any(|k| declarations(&text).eq(declarations(k)))
            })
        };
        let form = topic.forms().into_iter().find(is);
        let Some(form) = form.filter(|_| channel.message_encoding == MESSAGE_ENCODING) else {
            bail!(
                "topic `{}` has other fields than those of format `{FORMAT}`{}",
                topic.name(),
                self.other_version()
            );
        };
        self.truth |= topic == Topic::Truth;
        let single = topic == Topic::Checksum || matches!(form, Form::Single(_));
        if single && !self.single {
            self.single = true;
            self.recomputation = self.header.as_ref().and_then(Recomputation::new);
        }
        self.channels.insert(channel.id, form);
        Ok(())
    }

    /// Error text on which version wrote the file, and how to read it with this one.
    fn other_version(&self) -> String {
        let writer = self.header.as_ref().map(|header| header.identity.as_str());
        let writer = writer.filter(|identity| !identity.is_empty());
        format!(
            ": it was recorded by `{}`, and this is `{}`. Read it with that version, or write it there \
             as a table (`softdock export RUN.mcap -o run.csv`) and read that here with a mapping of \
             its columns (`softdock import run.csv --mapping MAPPING.toml -o FOLDER`)",
            writer.unwrap_or("a version without a name"),
            identity::text()
        )
    }

    fn message(&mut self, channel_id: u16, data: &[u8]) -> anyhow::Result<()> {
        let Some(form) = self.channels.get(&channel_id).copied() else {
            return Ok(());
        };
        let topic = form.topic();
        if self.seen & topic.bit() != 0 {
            bail!("`{}` comes twice before {}", topic.name(), self.missing());
        }
        let mut decode = || {
            let mut decoder = Decoder::new(data)?;
            form.visit(&mut decoder, &mut self.row)?;
            decoder.finish()
        };
        decode().with_context(|| format!("a message on `{}`", topic.name()))?;
        self.seen |= topic.bit();
        if self.topics().all(|topic| self.seen & topic.bit() != 0) {
            self.complete();
            self.recording.cycles.push(self.row.cycle);
            if self.truth {
                self.recording.truth.push(self.row.truth);
            }
            self.seen = 0;
        }
        Ok(())
    }

    /// The topics of which every cycle has a message.
    fn topics(&self) -> impl Iterator<Item = Topic> + use<> {
        let checksum = self.single.then_some(Topic::Checksum);
        Topic::all(self.truth).iter().copied().chain(checksum)
    }

    /// Restores all digits of a simulated cycle, or notes that this version computes other numbers.
    fn complete(&mut self) {
        if !self.single || self.recording.rounded.is_some() {
            return;
        }
        let recomputation = self.recomputation.as_mut();
        if !recomputation.is_some_and(|recomputation| recomputation.complete(&mut self.row)) {
            self.recording.rounded = Some(Rounded {
                place: self.recording.cycles.len(),
                checksum: self.row.checksum,
            });
        }
    }

    /// The first topic that the present cycle lacks, for errors.
    fn missing(&self) -> String {
        let lacks = |topic: &Topic| self.seen & topic.bit() == 0;
        let name = self.topics().find(lacks).map(Topic::name);
        format!("`{}`", name.unwrap_or("the next cycle"))
    }

    /// The outline according to the file's summary. None if it has no statistics, or not the same number of messages on each
    /// topic.
    pub(super) fn outline(mut self, summary: &Summary) -> Option<Outline> {
        let statistics = summary.stats.as_ref()?;
        let mut counts = BTreeSet::new();
        for (id, channel) in &summary.channels {
            if Topic::from_name(&channel.topic).is_none() && channel.topic != table::TOPIC {
                continue;
            }
            let schema = channel.schema.as_ref()?;
            let content = (
                schema.name.clone(),
                schema.encoding.clone(),
                schema.data.to_vec(),
            );
            self.schemas.insert(schema.id, content);
            let own = mcap::records::Channel {
                id: *id,
                schema_id: schema.id,
                topic: channel.topic.clone(),
                message_encoding: channel.message_encoding.clone(),
                metadata: channel.metadata.clone(),
            };
            self.channel(&own).ok()?;
            let count = statistics.channel_message_counts.get(id);
            counts.insert(count.copied().unwrap_or_default());
        }
        let cycles = counts.pop_first().unwrap_or_default();
        let length_ns = statistics
            .message_end_time
            .checked_sub(statistics.message_start_time)?;
        let outline = Outline {
            header: self.header?,
            cut: self.recording.cut,
            cycles: usize::try_from(cycles).ok()?,
            duration_s: length_ns as f64 / NS_PER_S,
        };
        counts.is_empty().then_some(outline)
    }

    fn finish(mut self, end: Option<Broken>, length: u64) -> anyhow::Result<Recording> {
        let mut recording = self.recording;
        if let Some(Broken { why, byte }) = end {
            recording.cut = Some(match recording.cycles.last() {
                Some(last) => format!(
                    "{} cycles up to {:.3} s are whole; after byte {byte} of {length}: {why}",
                    recording.cycles.len(),
                    last.trace.time_s
                ),
                None => format!("no cycle is whole; after byte {byte} of {length}: {why}"),
            });
        }
        recording.header = self.header.take().unwrap_or_default();
        Ok(recording)
    }
}

fn no_header() -> String {
    format!("not a softdock recording: it has no metadata `{METADATA}` before its cycles")
}
