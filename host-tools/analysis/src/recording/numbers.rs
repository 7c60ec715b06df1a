//! Tables of numbers as MCAP: a message for each row, at the times of the recording that they belong to, so that
//! Foxglove and PlotJuggler show both together.

use super::PROFILE;
use super::cdr::Encoder;
use super::field::EachNumber;
use super::ros2;
use super::writer::{LIBRARY, MESSAGE_ENCODING, NS_PER_S, SCHEMA_ENCODING};
use crate::data_table::{DataTable, Values};
use anyhow::{Context, Result, bail};
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Compression, WriteOptions};
use std::fmt::Write;

/// Rows in a chunk.
const CHUNK_ROWS: usize = 1024;

/// The table as an MCAP file with one topic. The first column is the time in s; a missing value is NaN.
///
/// # Errors
/// A column that does not hold numbers, or a time that is missing or negative.
pub(crate) fn mcap_of_numbers(
    table: &DataTable,
    topic: &str,
    schema_name: &str,
) -> Result<Vec<u8>> {
    let columns: Vec<&[Option<f64>]> = table
        .columns
        .iter()
        .map(|column| match &column.values {
            Values::Number(values) => Ok(values.as_slice()),
            _ => bail!("column `{}` holds no numbers", column.name),
        })
        .collect::<Result<_>>()?;
    let mut mcap = WriteOptions::new()
        .compression(Some(Compression::Zstd))
        .compression_threads(0)
        .profile(PROFILE)
        .library(LIBRARY)
        .chunk_size(None)
        .disable_seeking(true)
        .create(NoSeek::new(Vec::new()))?;
    mcap.write_metadata(&Metadata {
        name: "softdock-series".to_owned(),
        metadata: table.metadata.iter().cloned().collect(),
    })?;
    let schema = mcap.add_schema(schema_name, SCHEMA_ENCODING, ros2msg(table).as_bytes())?;
    let channel_id =
        mcap.add_channel(schema, topic, MESSAGE_ENCODING, &ros2::channel_metadata())?;
    let mut encoder = Encoder::default();
    for row in 0..table.rows() {
        encoder.begin();
        for column in &columns {
            encoder.number(column[row].unwrap_or(f64::NAN));
        }
        let time_s = columns[0][row].filter(|time| *time >= 0.0);
        let time_s = time_s.with_context(|| format!("row {} has no time", row + 1))?;
        let time_ns = (time_s * NS_PER_S).round() as u64;
        let header = MessageHeader {
            channel_id,
            sequence: row as u32,
            log_time: time_ns,
            publish_time: time_ns,
        };
        mcap.write_to_known_channel(&header, encoder.bytes())?;
        if (row + 1) % CHUNK_ROWS == 0 {
            mcap.flush()?;
        }
    }
    mcap.finish()?;
    Ok(mcap.into_inner().into_inner())
}

fn ros2msg(table: &DataTable) -> String {
    table
        .columns
        .iter()
        .fold(String::new(), |mut text, column| {
            // Writing into a String does not fail.
            let _ = writeln!(
                text,
                "# {}; {}\nfloat64 {}",
                column.meaning, column.unit, column.name
            );
            text
        })
}
