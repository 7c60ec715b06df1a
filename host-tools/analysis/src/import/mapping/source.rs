//! Tables side by side, from which columns are taken by name or number.

use super::column::{Column, ColumnName, Quantity};
use super::file::{Incomplete, Mapping};
use crate::import::table::{Table, listed};
use crate::import::table_error::TableError;
use anyhow::{Context, bail, ensure};
use std::path::Path;

/// Tables whose rows belong together.
#[derive(Debug)]
pub(super) struct Source {
    tables: Vec<Table>,
    /// Numbers of the rows in the tables, from 0.
    rows: Vec<usize>,
    /// Columns that were asked for and do not exist.
    missing: Vec<String>,
    /// What becomes of cells without a number.
    incomplete: Incomplete,
}

impl Source {
    /// Reads the files of a folder.
    ///
    /// # Errors
    ///
    /// A file that cannot be read or is no table, or tables of different lengths. Rows are not looked
    /// at before [`Self::check`].
    pub(super) fn read(folder: &Path, files: &[String], mapping: &Mapping) -> anyhow::Result<Self> {
        let tables = files
            .iter()
            .map(|file| {
                let path = folder.join(file);
                let bytes = std::fs::read(&path)
                    .with_context(|| format!("cannot read {}", path.display()))?;
                // A degree sign of another encoding in a header does not matter.
                let text = String::from_utf8_lossy(&bytes);
                anyhow::Ok(Table::unchecked(file, &text, &mapping.table)?)
            })
            .collect::<Result<Vec<_>, _>>()?;
        if let [first, rest @ ..] = tables.as_slice() {
            for other in rest {
                ensure!(
                    other.len() == first.len(),
                    "{} has {} rows and {} has {}; expected files whose rows belong together; several logs are a list of \
                     lists, [[\"one.csv\"], [\"other.csv\"]]",
                    first.file,
                    first.len(),
                    other.file,
                    other.len()
                );
            }
        }
        let rows = (0..tables.first().map_or(0, Table::len)).collect();
        Ok(Self {
            tables,
            rows,
            missing: Vec::new(),
            incomplete: mapping.rows.incomplete,
        })
    }

    /// Names of the files.
    pub(super) fn name(&self) -> String {
        let files: Vec<&str> = self.tables.iter().map(|t| t.file.as_str()).collect();
        files.join(" + ")
    }

    /// The first row of each table, also where it is not kept.
    pub(super) fn beginning(&self) -> Self {
        Self {
            tables: self.tables.iter().map(Table::beginning).collect(),
            rows: vec![0],
            missing: Vec::new(),
            incomplete: self.incomplete,
        }
    }

    /// Number of rows.
    pub(super) fn rows(&self) -> usize {
        self.rows.len()
    }

    /// Numbers of the rows in their file, from 0.
    pub(super) fn numbers_of_rows(&self) -> impl Iterator<Item = usize> {
        self.rows.iter().copied()
    }

    /// Keeps the rows whose index `wanted` accepts.
    pub(super) fn keep(&mut self, wanted: impl Fn(usize) -> bool) {
        self.tables.iter_mut().for_each(|table| table.keep(&wanted));
        let mut place = 0..;
        self.rows.retain(|_| place.next().is_some_and(&wanted));
    }

    /// Checks that the rows that are left are whole.
    ///
    /// # Errors
    ///
    /// A row that is shorter or longer than its table's first.
    pub(super) fn check(&self) -> Result<(), TableError> {
        self.tables.iter().try_for_each(Table::check)
    }

    /// Whether a column was requested that does not exist; [`Self::finish`] names it.
    pub(super) fn lacks_columns(&self) -> bool {
        !self.missing.is_empty()
    }

    /// Ends the reading: all columns that were missing in one error.
    ///
    /// # Errors
    ///
    /// A column was missing.
    pub(super) fn finish(self) -> anyhow::Result<()> {
        if self.missing.is_empty() {
            return Ok(());
        }
        let mut unnamed = self.tables.iter().map(Table::unnamed);
        bail!(
            "{}: {}; the columns are {}{}",
            self.name(),
            self.missing.join(", "),
            listed(self.tables.iter().flat_map(Table::all_names)),
            unnamed.find(|hint| !hint.is_empty()).unwrap_or_default()
        )
    }

    /// Values of a column in SI; zeros if it is missing, which [`Self::finish`] reports; NaN where a cell holds no number and
    /// rows with such cells are allowed. `place` is its key in the mapping.
    ///
    /// # Errors
    ///
    /// A cell that is no number, or a unit that does not fit.
    pub(super) fn numbers(
        &mut self,
        column: &Column,
        quantity: Quantity,
        place: &str,
    ) -> anyhow::Result<Vec<f64>> {
        let (scale, offset) = column.to_si(quantity, place)?;
        let mut numbers = match self.find(&column.column, place)? {
            Some((table, index)) if column.is_date() => self.tables[table].dates(index)?,
            Some((table, index)) => match self.incomplete {
                Incomplete::Refuse => self.tables[table].numbers(index)?,
                Incomplete::LeaveOut | Incomplete::Interpolate => {
                    self.tables[table].numbers_or_nan(index)?
                }
            },
            None => vec![0.0; self.rows()],
        };
        for value in &mut numbers {
            *value = scale * *value + offset;
        }
        if let Some(other) = &column.minus {
            let taken = self.numbers(other, quantity, &format!("{place} minus"))?;
            let both = numbers.iter_mut().zip(taken);
            both.for_each(|(value, taken)| *value -= taken);
        }
        Ok(numbers)
    }

    /// Words of a column, none if it is missing.
    ///
    /// # Errors
    ///
    /// A name that two files have.
    pub(super) fn words(&mut self, column: &ColumnName, place: &str) -> anyhow::Result<Vec<&str>> {
        Ok(match self.find(column, place)? {
            Some((table, index)) => self.tables[table].words(index),
            None => Vec::new(),
        })
    }

    fn find(&mut self, column: &ColumnName, place: &str) -> anyhow::Result<Option<(usize, usize)>> {
        let found = match column {
            ColumnName::Number(number) => self.by_number(*number),
            ColumnName::Name(name) => self.by_name(name)?,
        };
        if found.is_none() {
            let missing = match column {
                ColumnName::Number(number) => format!("no column {number}"),
                ColumnName::Name(name) => self.missing_name(name),
            };
            self.missing.push(format!("{missing} for {place}"));
        }
        Ok(found)
    }

    fn by_number(&self, number: usize) -> Option<(usize, usize)> {
        let mut index = number.checked_sub(1)?;
        for (table, names) in self.tables.iter().map(|t| &t.names).enumerate() {
            if index < names.len() {
                return Some((table, index));
            }
            index -= names.len();
        }
        None
    }

    fn by_name(&self, name: &str) -> anyhow::Result<Option<(usize, usize)>> {
        let tables = self.tables.iter().enumerate();
        let places = |(table, t): (usize, &Table)| {
            let places = t.places(name).into_iter();
            places.map(move |place| (table, place))
        };
        let mut found = tables.flat_map(places);
        let first = found.next();
        let hint = match self.tables.len() {
            1 => "",
            _ => {
                ": files in one list stand side by side; several logs are a list of lists, [[\"one.csv\"], [\"other.csv\"]]"
            }
        };
        ensure!(
            found.next().is_none(),
            "{}: several columns are called `{name}`; give the number of the one that counts{hint}",
            self.name()
        );
        Ok(first)
    }

    fn missing_name(&self, name: &str) -> String {
        let hints = self.tables.iter().filter_map(|table| table.nearest(name));
        match hints.into_iter().next() {
            Some(near) => format!("no column `{name}` (did you mean `{near}`?)"),
            None => format!("no column `{name}`"),
        }
    }
}
