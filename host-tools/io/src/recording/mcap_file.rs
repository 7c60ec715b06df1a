//! Writes an MCAP file whose messages are encoded directly into the buffer of the chunk.
//!
//! The crate `mcap` takes messages as bytes and passes each of them on in seven pieces, through four layers. That takes as
//! long as encoding and compressing them. Here a chunk is one buffer: messages are encoded into it, and zstd compresses it in
//! one call. There is no index of chunks or messages. Everything else is as that crate writes it, and uses its record types.

use super::cdr::Encoder;
use anyhow::{Context, Result};
use binrw::BinWrite;
use crc32fast::Hasher;
use mcap::MAGIC;
use mcap::records::{
    Channel, ChunkHeader, DataEnd, Footer, Header, Metadata, MetadataIndex, SchemaHeader,
    Statistics, SummaryOffset, op,
};
use std::io::{Cursor, Write};
use zstd::bulk::Compressor;
use zstd::zstd_safe::compress_bound;

/// Bytes of a record before its body: opcode and length.
const RECORD_HEAD: usize = 9;
/// Bytes of a message record before its data: record head, channel, sequence, two times.
const MESSAGE_HEAD: usize = RECORD_HEAD + 2 + 4 + 8 + 8;

/// Cycle of a message: its number, and the time (ns) at which it was logged and published.
#[derive(Clone, Copy)]
pub(super) struct Stamp {
    pub(super) sequence: u32,
    pub(super) time_ns: u64,
}

/// A file that is being written. Dropping it ends the file as far as that is possible.
pub(super) struct McapFile<W: Write> {
    /// None once the file has ended or a write has failed: nothing may be written after that.
    sink: Option<W>,
    position: u64,
    /// Checksum of the data section so far.
    checksum: Hasher,
    /// Records of the present chunk.
    chunk: Encoder,
    /// Times of the present chunk's first and last message, ns.
    chunk_times: Option<(u64, u64)>,
    zstd: Compressor<'static>,
    /// Compressed records of the last chunk; kept to reuse its memory.
    compressed: Vec<u8>,
    schemas: Vec<(SchemaHeader, Vec<u8>)>,
    /// Channels, each with its number of messages.
    channels: Vec<(Channel, u64)>,
    metadata: Vec<MetadataIndex>,
    chunks: u32,
    /// Times of the file's first and last message, ns.
    times: Option<(u64, u64)>,
}

impl<W: Write> McapFile<W> {
    /// Begins a file of an MCAP profile, written by `library`. `level` is the compression level of zstd.
    pub(super) fn new(sink: W, profile: &str, library: &str, level: i32) -> Result<Self> {
        let mut file = Self {
            sink: Some(sink),
            position: 0,
            checksum: Hasher::new(),
            chunk: Encoder::default(),
            chunk_times: None,
            zstd: Compressor::new(level)?,
            compressed: Vec::new(),
            schemas: Vec::new(),
            channels: Vec::new(),
            metadata: Vec::new(),
            chunks: 0,
            times: None,
        };
        let header = Header {
            profile: profile.to_owned(),
            library: library.to_owned(),
        };
        file.append(MAGIC)?;
        file.append(&record(op::HEADER, &header)?)?;
        Ok(file)
    }

    /// Ends the present chunk and writes metadata.
    pub(super) fn write_metadata(&mut self, metadata: &Metadata) -> Result<()> {
        self.end_chunk()?;
        let record = record(op::METADATA, metadata)?;
        self.metadata.push(MetadataIndex {
            offset: self.position,
            length: record.len() as u64,
            name: metadata.name.clone(),
        });
        self.append(&record)
    }

    /// Adds a channel, and its schema unless an equal one exists. Returns the channel's number; the numbers of channel and
    /// schema are assigned here.
    pub(super) fn add_channel(
        &mut self,
        schema: (&str, &str, &str),
        mut channel: Channel,
    ) -> Result<u16> {
        channel.schema_id = self.add_schema(schema)?;
        channel.id = number(self.channels.len())?;
        self.chunk.raw(&record(op::CHANNEL, &channel)?);
        let id = channel.id;
        self.channels.push((channel, 0));
        Ok(id)
    }

    /// The number of the schema with this name, encoding and text, which is added if necessary.
    fn add_schema(&mut self, (name, encoding, text): (&str, &str, &str)) -> Result<u16> {
        let same = |(header, data): &&(SchemaHeader, Vec<u8>)| {
            header.name == name && header.encoding == encoding && data == text.as_bytes()
        };
        if let Some((header, _)) = self.schemas.iter().find(same) {
            return Ok(header.id);
        }
        let header = SchemaHeader {
            id: number(self.schemas.len())?,
            name: name.to_owned(),
            encoding: encoding.to_owned(),
        };
        let id = header.id;
        let data = text.as_bytes().to_vec();
        self.chunk.raw(&schema_record(&header, &data)?);
        self.schemas.push((header, data));
        Ok(id)
    }

    /// Adds a message to the present chunk.
    pub(super) fn message(
        &mut self,
        channel: u16,
        stamp: Stamp,
        encode: impl FnOnce(&mut Encoder),
    ) {
        let Stamp { sequence, time_ns } = stamp;
        let mut head = [op::MESSAGE; MESSAGE_HEAD];
        head[9..11].copy_from_slice(&channel.to_le_bytes());
        head[11..15].copy_from_slice(&sequence.to_le_bytes());
        head[15..23].copy_from_slice(&time_ns.to_le_bytes());
        head[23..31].copy_from_slice(&time_ns.to_le_bytes());
        let begin = self.chunk.bytes().len();
        self.chunk.raw(&head);
        self.chunk.begin_next();
        encode(&mut self.chunk);
        let record = &mut self.chunk.bytes_mut()[begin..];
        let length = (record.len() - RECORD_HEAD) as u64;
        record[1..RECORD_HEAD].copy_from_slice(&length.to_le_bytes());
        self.chunk_times = Some(with(self.chunk_times, (time_ns, time_ns)));
        if let Some((_, count)) = self.channels.get_mut(usize::from(channel).wrapping_sub(1)) {
            *count += 1;
        }
    }

    /// Writes the present chunk and flushes the sink.
    pub(super) fn flush(&mut self) -> Result<()> {
        self.end_chunk()?;
        Ok(self.sink()?.flush()?)
    }

    /// Ends the file and returns the sink.
    pub(super) fn finish(mut self) -> Result<W> {
        self.end()?;
        let mut sink = self.sink.take().context(ENDED)?;
        sink.flush()?;
        Ok(sink)
    }

    fn sink(&mut self) -> Result<&mut W> {
        self.sink.as_mut().context(ENDED)
    }

    fn append(&mut self, bytes: &[u8]) -> Result<()> {
        let written = self.sink()?.write_all(bytes);
        if written.is_err() {
            self.sink = None;
        }
        self.position += bytes.len() as u64;
        self.checksum.update(bytes);
        Ok(written?)
    }

    fn end_chunk(&mut self) -> Result<()> {
        let records = self.chunk.bytes();
        if records.is_empty() {
            return Ok(());
        }
        let mut compressed = std::mem::take(&mut self.compressed);
        compressed.clear();
        compressed.reserve(compress_bound(records.len()));
        self.zstd.compress_to_buffer(records, &mut compressed)?;
        let times = self.chunk_times.take().unwrap_or_default();
        let header = ChunkHeader {
            message_start_time: times.0,
            message_end_time: times.1,
            uncompressed_size: records.len() as u64,
            uncompressed_crc: crc32fast::hash(records),
            compression: "zstd".to_owned(),
            compressed_size: compressed.len() as u64,
        };
        let header = bytes_of(&header)?;
        self.append(&record_head(op::CHUNK, header.len() + compressed.len()))?;
        self.append(&header)?;
        self.append(&compressed)?;
        self.chunk.clear();
        self.compressed = compressed;
        self.chunks += 1;
        self.times = Some(with(self.times, times));
        Ok(())
    }

    /// Writes the end of the data section, the summary, and the footer with the summary's checksum.
    fn end(&mut self) -> Result<()> {
        self.end_chunk()?;
        let data_section_crc = std::mem::take(&mut self.checksum).finalize();
        self.append(&record(op::DATA_END, &DataEnd { data_section_crc })?)?;
        let summary_start = self.position;
        let (mut summary, mut offsets) = (Vec::new(), Vec::new());
        for (group_opcode, records) in self.summary()? {
            let offset = SummaryOffset {
                group_opcode,
                group_start: summary_start + summary.len() as u64,
                group_length: records.len() as u64,
            };
            if !records.is_empty() {
                offsets.extend(record(op::SUMMARY_OFFSET, &offset)?);
            }
            summary.extend(records);
        }
        let footer = Footer {
            summary_start,
            summary_offset_start: summary_start + summary.len() as u64,
            summary_crc: 0,
        };
        summary.extend(offsets);
        summary.extend(record(op::FOOTER, &footer)?);
        summary.truncate(summary.len() - size_of_val(&footer.summary_crc));
        summary.extend(crc32fast::hash(&summary).to_le_bytes());
        summary.extend(MAGIC);
        self.append(&summary)
    }

    /// Opcodes and records of each group of the summary.
    fn summary(&self) -> Result<[(u8, Vec<u8>); 4]> {
        let schemas = self
            .schemas
            .iter()
            .map(|(header, data)| schema_record(header, data));
        let channels = self.channels.iter();
        let channels = channels.map(|(channel, _)| record(op::CHANNEL, channel));
        let metadata = self.metadata.iter();
        let metadata = metadata.map(|index| record(op::METADATA_INDEX, index));
        let statistics = record(op::STATISTICS, &self.statistics()?)?;
        Ok([
            (op::SCHEMA, schemas.collect::<Result<Vec<_>>>()?.concat()),
            (op::CHANNEL, channels.collect::<Result<Vec<_>>>()?.concat()),
            (op::STATISTICS, statistics),
            (
                op::METADATA_INDEX,
                metadata.collect::<Result<Vec<_>>>()?.concat(),
            ),
        ])
    }

    fn statistics(&self) -> Result<Statistics> {
        let (message_start_time, message_end_time) = self.times.unwrap_or_default();
        let counted = self.channels.iter().filter(|(_, count)| *count > 0);
        Ok(Statistics {
            message_count: self.channels.iter().map(|(_, count)| count).sum(),
            schema_count: self.schemas.len().try_into()?,
            channel_count: self.channels.len().try_into()?,
            attachment_count: 0,
            metadata_count: self.metadata.len().try_into()?,
            chunk_count: self.chunks,
            message_start_time,
            message_end_time,
            channel_message_counts: counted
                .map(|(channel, count)| (channel.id, *count))
                .collect(),
        })
    }
}

impl<W: Write> Drop for McapFile<W> {
    fn drop(&mut self) {
        if self.sink.is_some() {
            let _ = self.end();
        }
    }
}

const ENDED: &str = "the file is ended already, or could not be written";

/// Number of an item that is added after `count` others: MCAP counts from 1.
fn number(count: usize) -> Result<u16> {
    Ok(u16::try_from(count + 1)?)
}

/// Smallest period that contains both; `period` may be missing.
fn with(period: Option<(u64, u64)>, other: (u64, u64)) -> (u64, u64) {
    period.map_or(other, |(start, end)| (start.min(other.0), end.max(other.1)))
}

/// A record of one of MCAP's types.
fn record<T: for<'a> BinWrite<Args<'a> = ()>>(opcode: u8, content: &T) -> Result<Vec<u8>> {
    let body = bytes_of(content)?;
    Ok([&record_head(opcode, body.len())[..], &body].concat())
}

fn schema_record(header: &SchemaHeader, data: &[u8]) -> Result<Vec<u8>> {
    let header = bytes_of(header)?;
    let size = u32::try_from(data.len())?.to_le_bytes();
    let head = record_head(op::SCHEMA, header.len() + size.len() + data.len());
    Ok([&head[..], &header, &size, data].concat())
}

fn record_head(opcode: u8, length: usize) -> [u8; RECORD_HEAD] {
    let mut head = [opcode; RECORD_HEAD];
    head[1..].copy_from_slice(&(length as u64).to_le_bytes());
    head
}

fn bytes_of<T: for<'a> BinWrite<Args<'a> = ()>>(content: &T) -> Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    content.write_le(&mut bytes)?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use mcap::{MessageStream, Summary};
    use std::collections::BTreeMap;
    use std::io;

    const MESSAGES: u32 = 1000;

    fn channel(topic: &str) -> Channel {
        Channel {
            id: 0,
            schema_id: 0,
            topic: topic.to_owned(),
            message_encoding: "cdr".to_owned(),
            metadata: BTreeMap::new(),
        }
    }

    fn metadata() -> Metadata {
        Metadata {
            name: "after".to_owned(),
            metadata: [("key".to_owned(), "value".to_owned())].into(),
        }
    }

    /// Writes two channels of one schema: a chunk of similar messages, metadata, another chunk.
    fn written(file: &mut McapFile<impl Write>) -> Result<()> {
        let schema = ("package/msg/Type", "ros2msg", "uint8[100] x\n");
        let ids = [
            file.add_channel(schema, channel("/a"))?,
            file.add_channel(schema, channel("/b"))?,
        ];
        for sequence in 0..MESSAGES {
            let time_ns = u64::from(sequence) + 7;
            let id = ids[usize::from(sequence == 500)];
            file.message(id, Stamp { sequence, time_ns }, |encoder| {
                encoder.raw(&[7; 100])
            });
            if sequence == 900 {
                file.write_metadata(&metadata())?;
            }
        }
        Ok(())
    }

    fn new<W: Write>(sink: W) -> Result<McapFile<W>> {
        McapFile::new(sink, "profile", "library", 1)
    }

    fn file() -> Vec<u8> {
        let mut file = new(Vec::new()).unwrap();
        written(&mut file).unwrap();
        file.finish().unwrap()
    }

    #[test]
    fn what_it_says_of_itself_is_true() {
        let file = file();
        assert!(file.len() < 10_000, "{}", file.len());
        let summary = Summary::read(&file).unwrap().unwrap();
        let [index] = summary.metadata_indexes.as_slice() else {
            panic!("{summary:?}");
        };
        assert_eq!(mcap::read::metadata(&file, index).unwrap(), metadata());
        let statistics = summary.stats.unwrap();
        let counts = [(1, 999), (2, 1)].into();
        assert_eq!(statistics.channel_message_counts, counts);
        let Statistics {
            message_count,
            message_start_time,
            message_end_time,
            ..
        } = statistics;
        assert_eq!(
            (message_count, message_start_time, message_end_time),
            (1000, 7, 1006)
        );
        assert_eq!((statistics.chunk_count, statistics.metadata_count), (2, 1));
        assert_eq!((statistics.schema_count, statistics.channel_count), (1, 2));
        assert!(
            summary
                .channels
                .values()
                .all(|channel| channel.schema.is_some())
        );
    }

    #[test]
    fn its_messages_come_back() {
        let file = file();
        for (message, sequence) in MessageStream::new(&file).unwrap().zip(0..) {
            let message = message.unwrap();
            let topic = if sequence == 500 { "/b" } else { "/a" };
            let time = u64::from(sequence) + 7;
            assert_eq!(
                (message.sequence, message.channel.topic.as_str()),
                (sequence, topic)
            );
            assert_eq!((message.log_time, message.publish_time), (time, time));
            assert_eq!(message.data[4..], [7; 100]);
        }
    }

    #[test]
    fn the_data_section_has_a_checksum() {
        let file = file();
        let summary = mcap::read::footer(&file).unwrap().summary_start as usize;
        let (data, end) = file[..summary].split_at(summary - RECORD_HEAD - size_of::<u32>());
        assert_eq!(end[0], op::DATA_END);
        assert_eq!(end[RECORD_HEAD..], crc32fast::hash(data).to_le_bytes());
    }

    /// A disk with room for a limited number of bytes.
    struct Disk<'a>(&'a mut Vec<u8>, usize);

    impl Write for Disk<'_> {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let room = bytes.len().min(self.1 - self.0.len());
            self.0.extend_from_slice(&bytes[..room]);
            Ok(room)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// After a write that failed nothing more is written.
    #[test]
    fn a_full_disk_ends_the_file() {
        let whole = file();
        for room in 0..whole.len() {
            let mut bytes = Vec::new();
            let result = new(Disk(&mut bytes, room)).and_then(|mut file| {
                written(&mut file)?;
                file.finish().map(drop)
            });
            assert!(result.is_err());
            assert_eq!(bytes, whole[..room]);
        }
    }
}
