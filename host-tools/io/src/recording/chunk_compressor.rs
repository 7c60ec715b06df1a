//! Compresses each chunk of an MCAP file in one call, on its way into the file.
//!
//! The crate `mcap` gives zstd each message in seven pieces, most of them of 1 to 8 bytes, and handing them over costs more
//! than compressing them. Here its records come by as they would stand in a file without compression. A chunk is replaced by a
//! compressed one, and the checksum of the data section by that of what was written.

use binrw::BinWrite as _;
use crc32fast::Hasher;
use mcap::records::{ChunkHeader, Record, op};
use mcap::{MAGIC, McapResult, WriteOptions, parse_record};
use std::borrow::Cow;
use std::io::{Cursor, Error, ErrorKind, Result, Seek, SeekFrom, Write};
use zstd::bulk::Compressor;
use zstd::zstd_safe::compress_bound;

/// Bytes of a record before its body: opcode and length.
const RECORD_HEAD: usize = 9;

/// What a [`mcap::Writer`] writes into. It asks for its place in the file, so that what it says of places there is true.
pub(super) struct ChunkCompressor<W> {
    sink: W,
    position: u64,
    /// Of the data section so far; none behind it.
    checksum: Option<Hasher>,
    /// The beginning of a record that is not whole yet.
    record: Vec<u8>,
    zstd: Compressor<'static>,
    /// Compressed records of the last chunk: memory that is used again.
    compressed: Vec<u8>,
}

impl<W: Write> ChunkCompressor<W> {
    /// A writer of MCAP files whose chunks are compressed with a level of zstd.
    pub(super) fn writer(
        options: WriteOptions,
        sink: W,
        level: i32,
    ) -> McapResult<mcap::Writer<Self>> {
        let compressor = Self {
            sink,
            position: 0,
            checksum: Some(Hasher::new()),
            record: Vec::new(),
            zstd: Compressor::new(level)?,
            compressed: Vec::new(),
        };
        options
            // All three are made here.
            .compression(None)
            .calculate_chunk_crcs(false)
            .calculate_data_section_crc(false)
            // It would go back to the header of a chunk.
            .disable_seeking(true)
            .create(compressor)
    }

    pub(super) fn into_inner(self) -> W {
        self.sink
    }

    /// Whether these bytes are a whole record, or of a part of the file in which nothing is changed.
    fn is_whole(&self, bytes: &[u8]) -> bool {
        if self.position == 0 {
            return bytes.len() == MAGIC.len();
        }
        let body = bytes.len().checked_sub(RECORD_HEAD);
        let length = bytes.get(1..RECORD_HEAD);
        let whole = body.is_some_and(|body| length == Some(&(body as u64).to_le_bytes()));
        self.checksum.is_none() || whole
    }

    fn append_record(&mut self, record: &[u8]) -> Result<()> {
        if let Some((header, records)) = plain_chunk(record) {
            return self.append_chunk(header, &records);
        }
        match record.split_at_checked(RECORD_HEAD) {
            Some((head @ [op::DATA_END, ..], _)) if let Some(sum) = self.checksum.take() => {
                self.append(head)?;
                self.append(&sum.finalize().to_le_bytes())
            }
            _ => self.append(record),
        }
    }

    fn append(&mut self, bytes: &[u8]) -> Result<()> {
        self.sink.write_all(bytes)?;
        self.position += bytes.len() as u64;
        if let Some(sum) = &mut self.checksum {
            sum.update(bytes);
        }
        Ok(())
    }

    fn append_chunk(&mut self, plain: ChunkHeader, records: &[u8]) -> Result<()> {
        let mut compressed = std::mem::take(&mut self.compressed);
        compressed.clear();
        compressed.reserve(compress_bound(records.len()));
        self.zstd.compress_to_buffer(records, &mut compressed)?;
        let header = ChunkHeader {
            uncompressed_crc: crc32fast::hash(records),
            compression: "zstd".to_owned(),
            compressed_size: compressed.len() as u64,
            ..plain
        };
        let mut head = Cursor::new(Vec::new());
        header.write_le(&mut head).map_err(Error::other)?;
        let head = head.into_inner();
        let length = head.len() + compressed.len();
        self.append(&[op::CHUNK])?;
        self.append(&(length as u64).to_le_bytes())?;
        self.append(&head)?;
        self.append(&compressed)?;
        self.compressed = compressed;
        Ok(())
    }
}

/// Header and records of a chunk, if these bytes are one that is not compressed.
fn plain_chunk(bytes: &[u8]) -> Option<(ChunkHeader, Cow<'_, [u8]>)> {
    let (head, body) = bytes.split_at_checked(RECORD_HEAD)?;
    let length = (body.len() as u64).to_le_bytes();
    if head.split_first() != Some((&op::CHUNK, &length)) {
        return None;
    }
    match parse_record(op::CHUNK, body) {
        Ok(Record::Chunk { header, data }) if header.compression.is_empty() => Some((header, data)),
        _ => None,
    }
}

impl<W: Write> Write for ChunkCompressor<W> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        self.record.extend_from_slice(bytes);
        if self.is_whole(&self.record) {
            let mut record = std::mem::take(&mut self.record);
            self.append_record(&record)?;
            record.clear();
            self.record = record;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<()> {
        self.sink.flush()
    }
}

/// The place in the file can be asked for, not changed.
impl<W> Seek for ChunkCompressor<W> {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        match to {
            SeekFrom::Current(0) => Ok(self.position + self.record.len() as u64),
            _ => Err(ErrorKind::Unsupported.into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mcap::records::{MessageHeader, Metadata};
    use mcap::{MessageStream, Summary};
    use std::collections::BTreeMap;

    const MESSAGES: u32 = 1000;

    /// A chunk of messages that are alike, metadata behind it.
    fn file() -> (Vec<u8>, Metadata) {
        let options = WriteOptions::new().emit_message_indexes(false);
        let mut mcap = ChunkCompressor::writer(options, Vec::new(), 1).unwrap();
        let entries = BTreeMap::new();
        let channel_id = mcap.add_channel(0, "/topic", "cdr", &entries).unwrap();
        for sequence in 0..MESSAGES {
            let time = u64::from(sequence);
            let header = MessageHeader {
                channel_id,
                sequence,
                log_time: time,
                publish_time: time,
            };
            mcap.write_to_known_channel(&header, &[7; 100]).unwrap();
        }
        let metadata = Metadata {
            name: "after".to_owned(),
            metadata: [("key".to_owned(), "value".to_owned())].into(),
        };
        mcap.write_metadata(&metadata).unwrap();
        mcap.finish().unwrap();
        (mcap.into_inner().into_inner(), metadata)
    }

    #[test]
    fn a_chunk_is_compressed_and_the_places_in_the_file_are_true() {
        let (file, metadata) = file();
        assert!(file.len() < 10_000, "{}", file.len());
        let summary = Summary::read(&file).unwrap().unwrap();
        let [index] = summary.metadata_indexes.as_slice() else {
            panic!("{summary:?}");
        };
        assert_eq!(mcap::read::metadata(&file, index).unwrap(), metadata);
        let messages = MessageStream::new(&file).unwrap();
        let sequences: Vec<u32> = messages.map(|message| message.unwrap().sequence).collect();
        assert!(sequences.into_iter().eq(0..MESSAGES));
    }

    #[test]
    fn the_data_section_has_a_checksum() {
        let (file, _) = file();
        let summary = mcap::read::footer(&file).unwrap().summary_start as usize;
        let (data, end) = file[..summary].split_at(summary - RECORD_HEAD - size_of::<u32>());
        assert_eq!(end[0], op::DATA_END);
        assert_eq!(end[RECORD_HEAD..], crc32fast::hash(data).to_le_bytes());
    }
}
