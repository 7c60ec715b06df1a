//! What may be wrong with a table.

/// Something in a table that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TableError {
    /// No row of numbers.
    #[error("{file}: expected a table, received no row")]
    NoRow {
        /// File.
        file: String,
    },
    /// Columns that do not exist.
    #[error("{file}: {missing}; the columns are {columns}")]
    MissingColumns {
        /// File.
        file: String,
        /// "no column `a` (did you mean `A`?), no column `b`".
        missing: String,
        /// Names of those that exist.
        columns: String,
    },
    /// Each row seems to hold one variable.
    #[error(
        "{file}: {rows} rows of {columns} cells; expected a row for each instant: if each row holds a variable, say \
         `transposed = true` in [table]"
    )]
    Wide {
        /// File.
        file: String,
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
    },
    /// Two columns of one name.
    #[error(
        "{file}: {count} columns are called `{column}`; give the number of the one that counts"
    )]
    Ambiguous {
        /// File.
        file: String,
        /// Their name.
        column: String,
        /// How many there are.
        count: usize,
    },
    /// A row of another length.
    #[error(
        "{file}, line {line}: expected {expected} cells as in the first row, received {received}; \
         {hint}"
    )]
    Ragged {
        /// File.
        file: String,
        /// Line, from 1.
        line: u64,
        /// Cells of the first row.
        expected: usize,
        /// Cells of this one.
        received: usize,
        /// What to do.
        hint: &'static str,
    },
    /// A cell that is no finite number.
    #[error("{file}, line {line}, column {column}: expected a number, received {received}; {hint}")]
    NotANumber {
        /// File.
        file: String,
        /// Line, from 1.
        line: u64,
        /// Name or number of the column.
        column: String,
        /// What stands there.
        received: String,
        /// What to do.
        hint: &'static str,
    },
    /// A cell that is no date.
    #[error(
        "{file}, line {line}, column {column}: expected a date as `2026-03-01 14:05:09.25`, or a time of day, received \
         `{received}`"
    )]
    NotADate {
        /// File.
        file: String,
        /// Line, from 1.
        line: u64,
        /// Name or number of the column.
        column: String,
        /// What stands there.
        received: String,
    },
    /// A row that is not valid CSV.
    #[error("{file}: {why}")]
    NotCsv {
        /// File.
        file: String,
        /// What the reader says.
        why: String,
    },
}
