//! Tables as CSV: a header row, then one row of text each; an empty cell where there is no value.
//! Units, meanings and metadata stand in a JSON file beside it.

use super::{DataTable, Description, Values};
use anyhow::Result;
use serde::Serialize;

/// Content of the JSON file.
#[derive(Serialize)]
struct Sidecar<'a> {
    metadata: serde_json::Map<String, serde_json::Value>,
    columns: &'a [Description],
}

impl DataTable {
    /// The rows as CSV.
    ///
    /// # Errors
    /// The columns do not make a table.
    pub fn to_csv(&self) -> Result<Vec<u8>> {
        self.check()?;
        let mut csv = csv::Writer::from_writer(Vec::new());
        csv.write_record(self.columns.iter().map(|column| &column.name))?;
        for row in 0..self.rows() {
            csv.write_record(self.columns.iter().map(|column| column.values.text(row)))?;
        }
        Ok(csv.into_inner()?)
    }

    /// Units and meanings of the columns, and the metadata, as JSON.
    pub(super) fn description(&self) -> Result<String> {
        let columns: Vec<Description> = self.columns.iter().map(Description::of).collect();
        let metadata = self.metadata.iter().cloned();
        let sidecar = Sidecar {
            metadata: metadata.map(|(name, text)| (name, text.into())).collect(),
            columns: &columns,
        };
        Ok(serde_json::to_string_pretty(&sidecar)?)
    }
}

impl Values {
    /// A value as the shortest text that reads back to the same value; empty for a missing one.
    fn text(&self, row: usize) -> String {
        let text = match self {
            // `{:?}` writes very large and very small numbers with an exponent.
            Self::Number(values) => values[row].map(|value| format!("{value:?}")),
            Self::Count(values) => values[row].map(|value| value.to_string()),
            Self::Flag(values) => values[row].map(|value| value.to_string()),
            Self::Text(values) => values[row].clone(),
        };
        text.unwrap_or_default()
    }
}
