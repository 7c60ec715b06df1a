//! Tables as Parquet.
//!
//! Every column is optional, rows stand in groups of a fixed size, and the file says neither when
//! nor by which version of a library it was written: the same table is the same file.

use super::{DataColumn, DataTable, Description, Values};
use anyhow::{Context, Result, bail, ensure};
use bytes::Bytes;
use crc::{CRC_64_XZ, Crc};
use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};
use std::ops::Range;
use std::sync::Arc;

/// Rows in a group.
const GROUP_ROWS: usize = 65_536;
/// Compression level of zstd: the one that its authors recommend.
const LEVEL: i32 = 3;
/// Writer that the file names.
const CREATED_BY: &str = "softdock";
/// Metadata key of the columns' descriptions.
const COLUMNS: &str = "softdock.columns";
/// Marks the checksum in the metadata: the digits follow.
const CHECKSUM: &str = "softdock.checksum=";
/// Placeholder of the checksum while the checksum is computed.
const NO_SUM: &str = "0000000000000000";
/// Definition level of a present value.
const PRESENT: i16 = 1;

impl DataTable {
    /// The table as a Parquet file.
    ///
    /// # Errors
    /// The columns do not make a table.
    pub fn to_parquet(&self) -> Result<Vec<u8>> {
        self.check()?;
        let mut file =
            SerializedFileWriter::new(Vec::new(), self.schema()?, self.properties()?.into())?;
        for start in (0..self.rows()).step_by(GROUP_ROWS) {
            let end = self.rows().min(start + GROUP_ROWS);
            let mut group = file.next_row_group()?;
            for column in &self.columns {
                let writer = group.next_column()?;
                let mut writer = writer.context("the schema has fewer columns than the table")?;
                column.values.write(start..end, &mut writer)?;
                writer.close()?;
            }
            group.close()?;
        }
        let mut bytes = file.into_inner()?;
        let (sum, place) = checksum(&bytes)?;
        bytes[place].copy_from_slice(sum.as_bytes());
        Ok(bytes)
    }

    fn descriptions(&self) -> Result<String> {
        let columns: Vec<Description> = self.columns.iter().map(Description::of).collect();
        Ok(serde_json::to_string(&columns)?)
    }

    fn schema(&self) -> Result<TypePtr> {
        let fields = self.columns.iter().map(|column| {
            let (physical, logical) = match column.values {
                Values::Number(_) => (Physical::DOUBLE, None),
                Values::Count(_) => (Physical::INT64, Some(LogicalType::integer(64, false))),
                Values::Flag(_) => (Physical::BOOLEAN, None),
                Values::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            };
            let field = Type::primitive_type_builder(&column.name, physical)
                .with_logical_type(logical)
                .with_repetition(Repetition::OPTIONAL);
            Ok(Arc::new(field.build()?))
        });
        let fields = fields.collect::<Result<_>>()?;
        let table = Type::group_type_builder("table").with_fields(fields);
        Ok(Arc::new(table.build()?))
    }

    fn properties(&self) -> Result<WriterProperties> {
        let columns = KeyValue::new(COLUMNS.to_owned(), self.descriptions()?);
        let metadata = self.metadata.iter().cloned();
        let metadata = metadata.map(|(name, text)| KeyValue::new(name, text));
        let sum = KeyValue::new("checksum".to_owned(), format!("{CHECKSUM}{NO_SUM}"));
        Ok(WriterProperties::builder()
            .set_created_by(CREATED_BY.to_owned())
            .set_compression(Compression::ZSTD(ZstdLevel::try_new(LEVEL)?))
            .set_key_value_metadata(Some([columns, sum].into_iter().chain(metadata).collect()))
            .build())
    }

    /// Reads what [`to_parquet`](Self::to_parquet) wrote. The checksum is compared before anything is decoded: decoders
    /// panic at some files that are damaged.
    pub(super) fn from_parquet(bytes: Vec<u8>) -> Result<Self> {
        let (sum, place) = checksum(&bytes)?;
        ensure!(
            bytes[place] == *sum.as_bytes(),
            "it is damaged: its checksum differs"
        );
        let file = SerializedFileReader::new(Bytes::from(bytes))?;
        let entries = file.metadata().file_metadata().key_value_metadata();
        let entries = entries.into_iter().flatten().cloned();
        let mut entries = entries.map(|entry| (entry.key, entry.value.unwrap_or_default()));
        let columns = entries.next().filter(|(name, _)| name == COLUMNS);
        let (_, columns) = columns.context("the columns have no descriptions")?;
        let descriptions: Vec<Description> = serde_json::from_str(&columns)?;
        let columns = descriptions.iter().enumerate();
        let columns = columns
            .map(|(place, description)| {
                let mut column = description.column()?;
                read_column(&file, place, &mut column)?;
                Ok(column)
            })
            .collect::<Result<_>>()?;
        Ok(Self {
            columns,
            // The first entry is the description, the second the checksum.
            metadata: entries.skip(1).collect(),
        })
    }
}

/// Computes the checksum of a file with zeros in its place. Returns its digits, and where in the file they belong.
fn checksum(file: &[u8]) -> Result<(String, Range<usize>)> {
    const CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);
    let mark = file
        .windows(CHECKSUM.len())
        .rposition(|text| text == CHECKSUM.as_bytes());
    let start = mark.context("it has no checksum")? + CHECKSUM.len();
    let place = start..start + NO_SUM.len();
    ensure!(place.end <= file.len(), "it is cut off");
    let mut digest = CRC.digest();
    digest.update(&file[..place.start]);
    digest.update(NO_SUM.as_bytes());
    digest.update(&file[place.end..]);
    Ok((format!("{:016x}", digest.finalize()), place))
}

impl Values {
    /// Writes some rows of the column.
    fn write(&self, rows: Range<usize>, to: &mut SerializedColumnWriter<'_>) -> Result<()> {
        match self {
            Self::Number(values) => write::<DoubleType, _>(to, &values[rows], |value| *value),
            Self::Count(values) => write::<Int64Type, _>(to, &values[rows], |v| v.cast_signed()),
            Self::Flag(values) => write::<BoolType, _>(to, &values[rows], |value| *value),
            Self::Text(values) => {
                write::<ByteArrayType, _>(to, &values[rows], |text| text.as_str().into())
            }
        }
    }
}

fn write<P: DataType, T>(
    to: &mut SerializedColumnWriter<'_>,
    values: &[Option<T>],
    stored: impl Fn(&T) -> P::T,
) -> Result<()> {
    let present: Vec<P::T> = values.iter().flatten().map(stored).collect();
    let levels = values.iter().map(|value| i16::from(value.is_some()));
    let levels: Vec<i16> = levels.collect();
    to.typed::<P>().write_batch(&present, Some(&levels), None)?;
    Ok(())
}

fn read_column(
    file: &SerializedFileReader<Bytes>,
    place: usize,
    DataColumn { name, values, .. }: &mut DataColumn,
) -> Result<()> {
    for group in 0..file.num_row_groups() {
        let group = file.get_row_group(group)?;
        let rows = usize::try_from(group.metadata().num_rows())?;
        ensure!(
            place < group.num_columns(),
            "the file has no column `{name}`"
        );
        let reader = group.get_column_reader(place)?;
        match (&mut *values, reader) {
            (Values::Number(to), ColumnReader::DoubleColumnReader(from)) => {
                read(from, rows, to, Ok)?;
            }
            (Values::Count(to), ColumnReader::Int64ColumnReader(from)) => {
                read(from, rows, to, |value| Ok(value.cast_unsigned()))?;
            }
            (Values::Flag(to), ColumnReader::BoolColumnReader(from)) => read(from, rows, to, Ok)?,
            (Values::Text(to), ColumnReader::ByteArrayColumnReader(from)) => {
                let text = |bytes: ByteArray| Ok(bytes.as_utf8()?.to_owned());
                read(from, rows, to, text)?;
            }
            _ => bail!("column `{name}` does not hold what its description says"),
        }
    }
    Ok(())
}

fn read<P: DataType, T>(
    mut from: ColumnReaderImpl<P>,
    rows: usize,
    to: &mut Vec<Option<T>>,
    value: impl Fn(P::T) -> Result<T>,
) -> Result<()> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    let (received, ..) = from.read_records(rows, Some(&mut levels), None, &mut values)?;
    ensure!(
        received == rows,
        "a column has {received} rows, expected {rows}"
    );
    let mut values = values.into_iter();
    for level in levels {
        let present = (level == PRESENT).then(|| values.next()).flatten();
        to.push(present.map(&value).transpose()?);
    }
    Ok(())
}
