//! Tables that other programs read: columns of numbers, counts, yes or no, and text, each with its
//! unit and meaning, as CSV and as Parquet. (What a person reads is a `softdock_report::Table`.)
//!
//! The same table gives the same bytes: they depend on no clock, host or order of threads.
//!
//! ```
//! use softdock_io::data_table::{DataColumn, DataTable};
//!
//! let mut table = DataTable::default();
//! table.columns.push(DataColumn::new("time_s", "s", "since the first cycle", vec![0.0, 0.004]));
//! table.columns.push(DataColumn::new("captured", "1", "the latches closed", vec![None, Some(true)]));
//! table.metadata.push(("softdock".into(), "0.1.0".into()));
//! let folder = tempfile::tempdir()?;
//! let file = folder.path().join("series.parquet");
//! table.write(&file)?;
//! assert_eq!(DataTable::read_parquet(&file)?, table);
//! # Ok::<(), anyhow::Error>(())
//! ```

mod csv_file;
mod description;
mod parquet_file;

pub use description::Description;

use crate::output::{NewFile, write_whole};
use anyhow::{Context, Result, bail, ensure};
use std::collections::BTreeSet;
use std::path::Path;

/// A table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DataTable {
    /// The columns, all equally long, each with a name of its own.
    pub columns: Vec<DataColumn>,
    /// Metadata of the whole table: names and texts.
    pub metadata: Vec<(String, String)>,
}

/// A column.
#[derive(Clone, Debug, PartialEq)]
pub struct DataColumn {
    /// Name, which ends with the unit: `peak_force_n`.
    pub name: String,
    /// Unit as printed: `N`; `1` for none.
    pub unit: String,
    /// Meaning of the column.
    pub meaning: String,
    /// Its values, one for each row.
    pub values: Values,
}

impl DataColumn {
    /// A column with values of any type that a table can hold.
    pub fn new(
        name: impl Into<String>,
        unit: impl Into<String>,
        meaning: impl Into<String>,
        values: impl Into<Values>,
    ) -> Self {
        Self {
            name: name.into(),
            unit: unit.into(),
            meaning: meaning.into(),
            values: values.into(),
        }
    }
}

/// The values of a column; `None` for a missing value.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum Values {
    /// Numbers.
    Number(Vec<Option<f64>>),
    /// Counts and indices.
    Count(Vec<Option<u64>>),
    /// Yes or no.
    Flag(Vec<Option<bool>>),
    /// Words.
    Text(Vec<Option<String>>),
}

impl Values {
    /// Number of rows.
    pub fn len(&self) -> usize {
        match self {
            Self::Number(values) => values.len(),
            Self::Count(values) => values.len(),
            Self::Flag(values) => values.len(),
            Self::Text(values) => values.len(),
        }
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

macro_rules! values {
    ($($type:ty => $variant:ident),+) => {$(
        impl From<Vec<Option<$type>>> for Values {
            fn from(values: Vec<Option<$type>>) -> Self {
                Self::$variant(values)
            }
        }
        impl From<Vec<$type>> for Values {
            fn from(values: Vec<$type>) -> Self {
                Self::$variant(values.into_iter().map(Some).collect())
            }
        }
    )+};
}

values!(f64 => Number, u64 => Count, bool => Flag, String => Text);

impl DataTable {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    /// The values of a column.
    ///
    /// # Errors
    /// There is no such column; the error names those that there are.
    pub fn values(&self, name: &str) -> Result<&Values> {
        let found = self.columns.iter().find(|column| column.name == name);
        let values = found.map(|column| &column.values);
        values.with_context(|| {
            let names: Vec<&str> = self.columns.iter().map(|c| c.name.as_str()).collect();
            format!("no column `{name}`; there are {}", names.join(", "))
        })
    }

    /// The text of a metadata entry; None if there is no such entry.
    pub fn metadata(&self, name: &str) -> Option<&str> {
        let found = self.metadata.iter().find(|(known, _)| known == name);
        found.map(|(_, text)| text.as_str())
    }

    /// Writes the table, whole or not at all: `.parquet`, or `.csv` with its description as `.json`
    /// beside it.
    ///
    /// # Errors
    /// The name has another ending, the columns do not make a table, or the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("parquet") => write_whole(path, self.to_parquet()?),
            Some("csv") => {
                let table = NewFile::of(path, self.to_csv()?)?;
                let json = NewFile::of(&path.with_extension("json"), self.description()?)?;
                json.keep()?;
                table.keep()
            }
            _ => bail!(
                "{}: a table is written as .parquet or .csv; choose one of these endings",
                path.display()
            ),
        }
    }

    /// Reads a table that was written as Parquet.
    ///
    /// # Errors
    /// The file cannot be read, or is no whole table of softdock.
    pub fn read_parquet(path: &Path) -> Result<Self> {
        let bytes =
            std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        Self::of_parquet(bytes, &path.display().to_string())
    }

    /// Reads a table from the bytes of a Parquet file; `name` stands for the file in errors.
    ///
    /// # Errors
    /// It is no whole table of softdock.
    pub fn of_parquet(bytes: Vec<u8>, name: &str) -> Result<Self> {
        Self::from_parquet(bytes)
            .with_context(|| format!("{name} is not a whole table of softdock (Parquet)"))
    }

    /// An error unless all columns are equally long and have different names.
    fn check(&self) -> Result<()> {
        let mut names = BTreeSet::new();
        for DataColumn { name, values, .. } in &self.columns {
            ensure!(names.insert(name), "column `{name}` stands twice");
            let (expected, received) = (self.rows(), values.len());
            ensure!(
                expected == received,
                "column `{name}` has {received} rows, expected {expected} as the first column has"
            );
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
