//! The stored row of a campaign, and whether a new run of it gives the same.

use super::journal;
use super::place::Place;
use super::plan::Plan;
use super::status::{indices, parts};
use super::table::table;
use anyhow::Result;
use softdock_io::data_table::{DataTable, Values};

/// A row of a part or of a journal.
#[derive(Clone, Debug)]
pub struct StoredRow {
    /// Part or journal in which the row is stored, in words.
    pub place: String,
    table: DataTable,
    row: usize,
}

impl StoredRow {
    /// Finds a row in the parts of a campaign, then in the journals of shards that are not complete. None if the row has not
    /// been computed.
    ///
    /// # Errors
    /// A part is no table of this plan and program, or the campaign cannot be read.
    pub fn find(plan: &Plan, place: &Place, index: u64) -> Result<Option<Self>> {
        for (shard, part) in parts(plan, place)? {
            if let Some(row) = indices(&part)?.iter().position(|own| *own == index) {
                return Ok(Some(Self {
                    place: format!("part {shard}"),
                    table: part,
                    row,
                }));
            }
        }
        let journals = journal::all(plan, place.journals())?.into_iter();
        let mut rows = journals.flat_map(|(_, rows)| rows);
        let row = rows.find(|(own, _)| *own == index);
        Ok(row.map(|row| Self {
            place: "a journal".to_owned(),
            table: table(plan, &[row]),
            row: 0,
        }))
    }

    /// Compares with a table of one row, bit by bit. Returns the first column that differs, with both values.
    ///
    /// # Errors
    /// The part lacks a column.
    pub fn difference(&self, again: &DataTable) -> Result<Option<String>> {
        for column in &again.columns {
            let stored = value(self.table.values(&column.name)?, self.row);
            let now = value(&column.values, 0);
            if stored != now {
                let [stored, now] = [stored, now].map(|value| value.unwrap_or("none".to_owned()));
                let name = &column.name;
                return Ok(Some(format!("`{name}`: stored {stored}, now {now}")));
            }
        }
        Ok(None)
    }
}

/// A value as text with all digits, which reads back bit for bit; None for a missing value.
pub fn value(values: &Values, row: usize) -> Option<String> {
    fn text<T: ToString>(values: &[Option<T>], row: usize) -> Option<String> {
        values.get(row)?.as_ref().map(T::to_string)
    }
    match values {
        Values::Number(values) => text(values, row),
        Values::Count(values) => text(values, row),
        Values::Flag(values) => text(values, row),
        Values::Text(values) => text(values, row),
    }
}
