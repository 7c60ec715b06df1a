//! Writes a table of numbers as a topic: one message per row.

use super::cdr::Encoder;
use super::field::EachNumber;
use crate::data_table::{DataTable, Values};
use anyhow::{Result, bail};
use std::fmt::Write;

/// A table whose columns hold numbers.
pub(super) struct NumbersTopic<'a> {
    table: &'a DataTable,
    columns: Vec<&'a [Option<f64>]>,
    /// Name of the message type in the schema.
    pub(super) schema_name: &'static str,
}

impl<'a> NumbersTopic<'a> {
    /// # Errors
    /// A column that does not hold numbers.
    pub(super) fn new(table: &'a DataTable, schema_name: &'static str) -> Result<Self> {
        let columns = table.columns.iter().map(|column| match &column.values {
            Values::Number(values) => Ok(values.as_slice()),
            _ => bail!("column `{}` holds no numbers", column.name),
        });
        Ok(Self {
            table,
            columns: columns.collect::<Result<_>>()?,
            schema_name,
        })
    }

    /// Encodes a row; a missing value is NaN.
    pub(super) fn row(&self, row: usize, message: &mut Encoder) {
        let values = self.columns.iter().map(|column| column.get(row).copied());
        values.for_each(|value| message.number(value.flatten().unwrap_or(f64::NAN)));
    }

    /// The schema of the messages (`ros2msg`).
    pub(super) fn ros2msg(&self) -> String {
        let columns = self.table.columns.iter();
        columns.fold(String::new(), |mut text, column| {
            // Writing into a String does not fail.
            let _ = writeln!(
                text,
                "# {}; {}\nfloat64 {}",
                column.meaning, column.unit, column.name
            );
            text
        })
    }
}
