//! A delimited text file as a table of cells, whose errors name file, line and column.

use super::table_error::TableError;
use chrono::{DateTime, NaiveDateTime, NaiveTime, Timelike};
use serde::Deserialize;
use softdock_io::input::nearest;
use std::borrow::Cow;
use std::num::ParseFloatError;

/// A table with fewer rows and more columns than these holds one variable per row: no log is that short, no table that wide.
const FEWEST_ROWS: usize = 12;
const MOST_COLUMNS: usize = 100;

/// What stands between two cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Delimiter {
    /// One character.
    Character(u8),
    /// Any number of blanks and tabs.
    Blanks,
    /// A comma.
    #[default]
    Comma,
}

impl<'de> Deserialize<'de> for Delimiter {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let word = String::deserialize(deserializer)?;
        match (word.as_str(), word.as_bytes()) {
            ("comma" | ",", _) => Ok(Self::Comma),
            ("tab", _) => Ok(Self::Character(b'\t')),
            ("blanks" | " ", _) => Ok(Self::Blanks),
            (_, [byte]) if byte.is_ascii() => Ok(Self::Character(*byte)),
            _ => Err(serde::de::Error::custom(format!(
                "expected one character, \"tab\" or \"blanks\", found `{word}`"
            ))),
        }
    }
}

/// How a file is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Dialect {
    /// Between two cells.
    pub delimiter: Delimiter,
    /// The first line names the columns. If it holds values, the comment line right above it does.
    pub header: bool,
    /// `1,5` is one and a half.
    pub decimal_comma: bool,
    /// Lines before the table that are not read.
    pub skip_lines: usize,
    /// Each row of the file is a column.
    pub transposed: bool,
}

impl Default for Dialect {
    fn default() -> Self {
        Self {
            delimiter: Delimiter::Comma,
            header: true,
            decimal_comma: false,
            skip_lines: 0,
            transposed: false,
        }
    }
}

/// A table of text.
#[derive(Clone, Debug)]
pub struct Table {
    /// Name of the file in errors.
    pub file: String,
    /// Names of the columns; `1`, `2`, ... where the file has no header.
    pub names: Vec<String>,
    /// Names in comment lines farther above, the nearest first: the line right above the numbers may hold units.
    above: Vec<Vec<String>>,
    rows: Vec<csv::StringRecord>,
    /// The file's first row, also where it is not [kept](Self::keep).
    first: csv::StringRecord,
    decimal_comma: bool,
}

impl Table {
    /// Splits a text into cells.
    ///
    /// # Errors
    ///
    /// Nothing but a header, a row that is shorter or longer than the first, or broken quotes.
    pub fn read(file: &str, text: &str, dialect: &Dialect) -> Result<Self, TableError> {
        let table = Self::unchecked(file, text, dialect)?;
        table.check()?;
        Ok(table)
    }

    /// Splits a text into cells; rows of any length.
    ///
    /// # Errors
    ///
    /// Nothing but a header, or broken quotes.
    pub fn unchecked(file: &str, text: &str, dialect: &Dialect) -> Result<Self, TableError> {
        let text = text.trim_start_matches('\u{feff}');
        let start = text
            .split_inclusive('\n')
            .take(dialect.skip_lines)
            .map(str::len)
            .sum();
        let (skipped, text) = text.split_at(start);
        let lines_before = skipped.lines().count() as u64;
        let (text, delimiter) = match dialect.delimiter {
            Delimiter::Comma => (Cow::Borrowed(text), b','),
            Delimiter::Character(byte) => (Cow::Borrowed(text), byte),
            Delimiter::Blanks => (Cow::Owned(single_blanks(text)), b' '),
        };
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(delimiter)
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .from_reader(text.as_bytes());
        let mut rows = Vec::new();
        for row in reader.records() {
            let mut row = row.map_err(|error| TableError::NotCsv {
                file: file.to_owned(),
                why: error.to_string(),
            })?;
            if let Some(mut position) = row.position().cloned() {
                position.set_line(position.line() + lines_before);
                row.set_position(Some(position));
            }
            rows.push(row);
        }
        if dialect.transposed {
            rows = transposed(file, &rows)?;
        }
        let comments = comments_above(&text).into_iter();
        let comments = comments.map(|comment| cells(comment, delimiter));
        Self::named(file, rows, comments, dialect)
    }

    fn named(
        file: &str,
        mut rows: Vec<csv::StringRecord>,
        comments: impl Iterator<Item = Vec<String>>,
        dialect: &Dialect,
    ) -> Result<Self, TableError> {
        let no_row = || TableError::NoRow {
            file: file.to_owned(),
        };
        let Some(first) = rows.first_mut() else {
            return Err(no_row());
        };
        if ends_empty(first) {
            first.truncate(first.len() - 1);
        }
        let holds_values = first
            .iter()
            .any(|cell| is_value(cell, dialect.decimal_comma));
        let width = first.len();
        let taken = dialect.header && holds_values;
        let mut above = comments.filter(|names| taken && names.len() == width);
        let names: Vec<String> = match above.next() {
            Some(names) => names,
            None if dialect.header => rows.remove(0).iter().map(|n| n.trim().to_owned()).collect(),
            None => (1..=width).map(|n| n.to_string()).collect(),
        };
        for row in &mut rows {
            if row.len() == names.len() + 1 && ends_empty(row) {
                row.truncate(names.len());
            }
        }
        if rows.len() < FEWEST_ROWS && names.len() > MOST_COLUMNS {
            return Err(TableError::Wide {
                file: file.to_owned(),
                rows: rows.len(),
                columns: names.len(),
            });
        }
        Ok(Self {
            file: file.to_owned(),
            names,
            above: above.collect(),
            first: rows.first().cloned().ok_or_else(no_row)?,
            rows,
            decimal_comma: dialect.decimal_comma,
        })
    }

    /// Checks that each row has a cell for each column.
    ///
    /// # Errors
    ///
    /// The first row that is shorter or longer.
    pub fn check(&self) -> Result<(), TableError> {
        let expected = self.names.len();
        match self.rows.iter().find(|row| row.len() != expected) {
            Some(row) => Err(TableError::Ragged {
                file: self.file.clone(),
                line: line(row),
                expected,
                received: row.len(),
                hint: ragged(&self.names),
            }),
            None => Ok(()),
        }
    }

    /// Keeps the rows whose index `wanted` accepts.
    pub fn keep(&mut self, wanted: impl Fn(usize) -> bool) {
        let mut place = 0..;
        self.rows.retain(|_| place.next().is_some_and(&wanted));
    }

    /// The file's first row alone.
    pub fn beginning(&self) -> Self {
        Self {
            file: self.file.clone(),
            names: self.names.clone(),
            above: self.above.clone(),
            rows: vec![self.first.clone()],
            first: self.first.clone(),
            decimal_comma: self.decimal_comma,
        }
    }

    /// Number of rows without the header.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Only after [`Self::keep`]: a table without rows is refused.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Places of columns by their names.
    ///
    /// # Errors
    ///
    /// All names that do not exist, with the nearest that do; a name that exists twice.
    pub fn column_indices(&self, names: &[&str]) -> Result<Vec<usize>, TableError> {
        let missing: Vec<String> = names
            .iter()
            .filter(|name| self.places(name).is_empty())
            .map(|name| self.missing(name, names))
            .collect();
        if !missing.is_empty() {
            return Err(TableError::MissingColumns {
                file: self.file.clone(),
                missing: missing.join(", "),
                columns: listed(self.all_names()),
            });
        }
        let place = |name: &&str| match self.places(name).as_slice() {
            [place] => Ok(*place),
            places => Err(TableError::Ambiguous {
                file: self.file.clone(),
                column: (*name).to_owned(),
                count: places.len(),
            }),
        };
        names.iter().map(place).collect()
    }

    /// Places of the columns of a name, in the nearest line that has it.
    pub fn places(&self, name: &str) -> Vec<usize> {
        let mut lines = std::iter::once(&self.names).chain(&self.above);
        let line = lines.find(|names| names.iter().any(|n| n == name));
        let columns = line.into_iter().flatten().enumerate();
        columns
            .filter(|(_, n)| *n == name)
            .map(|(place, _)| place)
            .collect()
    }

    /// Names of the columns in all lines, the nearest line first.
    pub fn all_names(&self) -> impl Iterator<Item = &str> {
        self.names
            .iter()
            .chain(self.above.iter().flatten())
            .map(String::as_str)
    }

    /// "no column `name` (did you mean `other`?)", where `other` is none of the wanted.
    fn missing(&self, name: &str, wanted: &[&str]) -> String {
        match self.nearest_of(name, wanted) {
            Some(near) => format!("no column `{name}` (did you mean `{near}`?)"),
            None => format!("no column `{name}`"),
        }
    }

    /// The column that `name` was probably meant to be.
    pub fn nearest(&self, name: &str) -> Option<&str> {
        self.nearest_of(name, &[])
    }

    fn nearest_of(&self, name: &str, not: &[&str]) -> Option<&str> {
        let free = || self.all_names().filter(|n| !not.contains(n));
        let same_letters = free().find(|n| n.eq_ignore_ascii_case(name));
        same_letters.or_else(|| nearest(name, free()))
    }

    /// Numbers of a column.
    ///
    /// # Errors
    ///
    /// The first cell that is empty, not a number, or not finite.
    pub fn numbers(&self, place: usize) -> Result<Vec<f64>, TableError> {
        self.rows
            .iter()
            .map(|row| self.number(row, place))
            .collect()
    }

    /// The same; NaN for a cell that holds no number on purpose: empty, not finite, or `NA`.
    ///
    /// # Errors
    ///
    /// The first cell that holds something else.
    pub fn numbers_or_nan(&self, place: usize) -> Result<Vec<f64>, TableError> {
        /// What programs write for a value that they do not have.
        const NONE: [&str; 5] = ["", "NA", "N/A", "null", "None"];
        let holds_none = |row: &csv::StringRecord| {
            let cell = cell(row, place);
            NONE.contains(&cell) || cell.parse::<f64>().is_ok_and(|value| !value.is_finite())
        };
        let number = |row| match self.number(row, place) {
            Err(_) if holds_none(row) => Ok(f64::NAN),
            other => other,
        };
        self.rows.iter().map(number).collect()
    }

    /// Seconds since the file's first of a column of dates with their times, or of times of one day; those without a zone are
    /// of one zone.
    ///
    /// # Errors
    ///
    /// The first cell that holds no date.
    pub fn dates(&self, place: usize) -> Result<Vec<f64>, TableError> {
        let date = |row: &csv::StringRecord| {
            date_ns(cell(row, place)).ok_or_else(|| TableError::NotADate {
                file: self.file.clone(),
                line: line(row),
                column: self.column(place),
                received: cell(row, place).to_owned(),
            })
        };
        let all: Vec<i64> = self.rows.iter().map(date).collect::<Result<_, _>>()?;
        let first = date_ns(cell(&self.first, place)).or(all.first().copied());
        let first = first.unwrap_or(0);
        Ok(all
            .into_iter()
            .map(|ns| (ns - first) as f64 / 1e9)
            .collect())
    }

    fn number(&self, row: &csv::StringRecord, place: usize) -> Result<f64, TableError> {
        let cell = cell(row, place);
        match parsed(cell, self.decimal_comma) {
            Ok(value) if value.is_finite() => Ok(value),
            received => Err(TableError::NotANumber {
                file: self.file.clone(),
                line: line(row),
                column: self.column(place),
                received: match cell {
                    "" => "an empty cell".to_owned(),
                    text => format!("`{text}`"),
                },
                hint: hint(cell, received.is_ok(), self.decimal_comma),
            }),
        }
    }

    /// Words of a column.
    pub fn words(&self, place: usize) -> Vec<&str> {
        self.rows.iter().map(|row| cell(row, place)).collect()
    }

    /// Advice for columns that were named after a first row of values; empty if they have names.
    pub fn unnamed(&self) -> &'static str {
        let counted = |(n, name): (usize, &String)| *name == (n + 1).to_string();
        let values = self
            .names
            .iter()
            .filter(|name| is_value(name, self.decimal_comma));
        match 2 * values.count() > self.names.len() && !self.names.iter().enumerate().all(counted) {
            true => {
                "; these are numbers: if no line names the columns, say `header = false` in [table], and take them by \
                 their numbers from 1; a comment right above names them if it has as many cells"
            }
            false => "",
        }
    }

    /// Name of a column in errors.
    pub fn column(&self, place: usize) -> String {
        match self.names.get(place) {
            Some(name) if *name == (place + 1).to_string() => name.clone(),
            Some(name) => format!("`{name}`"),
            None => (place + 1).to_string(),
        }
    }

    /// Line of a row in the file, from 1.
    pub fn line(&self, row: usize) -> u64 {
        self.rows.get(row).map_or(0, line)
    }
}

/// Makes a row of each column. Its line is its place within a line of the file, from 1.
fn transposed(
    file: &str,
    lines: &[csv::StringRecord],
) -> Result<Vec<csv::StringRecord>, TableError> {
    let width = lines.first().map_or(0, csv::StringRecord::len);
    if let Some(other) = lines.iter().find(|cells| cells.len() != width) {
        return Err(TableError::Ragged {
            file: file.to_owned(),
            line: line(other),
            expected: width,
            received: other.len(),
            hint: ragged(&[]),
        });
    }
    let row = |place: usize| {
        let mut row: csv::StringRecord = lines.iter().map(|cells| &cells[place]).collect();
        let mut position = csv::Position::new();
        position.set_line(place as u64 + 1);
        row.set_position(Some(position));
        row
    };
    Ok((0..width).map(row).collect())
}

/// Names in an error, of many the first.
pub fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    const MOST: usize = 50;
    let names: Vec<&str> = names.collect();
    match names.get(..MOST) {
        Some(first) => format!("{} .. ({} in all)", first.join(", "), names.len()),
        None => names.join(", "),
    }
}

/// The comments right above the first row, the nearest first.
fn comments_above(text: &str) -> Vec<&str> {
    let above = text
        .lines()
        .take_while(|line| line.is_empty() || line.starts_with('#'));
    let mut above: Vec<&str> = above.collect();
    above.reverse();
    above
        .into_iter()
        .map_while(|line| line.strip_prefix('#'))
        .collect()
}

/// Names between delimiters.
fn cells(line: &str, delimiter: u8) -> Vec<String> {
    let cells = line.trim().split(char::from(delimiter));
    let mut cells: Vec<String> = cells
        .map(|cell| cell.trim().trim_matches('"').to_owned())
        .collect();
    if cells.len() > 1 && cells.last().is_some_and(String::is_empty) {
        cells.pop();
    }
    cells
}

/// Whether a cell holds a number or a date, and no name.
fn is_value(cell: &str, decimal_comma: bool) -> bool {
    parsed(cell.trim(), decimal_comma).is_ok() || date_ns(cell.trim()).is_some()
}

fn parsed(cell: &str, decimal_comma: bool) -> Result<f64, ParseFloatError> {
    match decimal_comma && cell.contains(',') {
        true => cell.replacen(',', ".", 1).parse(),
        false => cell.parse(),
    }
}

/// What to do about rows of different lengths. A decimal comma splits cells only where there are numbers.
fn ragged(names: &[String]) -> &'static str {
    match names {
        [only] if only.contains(';') => {
            "cells stand between semicolons here: say `delimiter = \";\"` in [table], and `decimal_comma = true` if \
             1,5 is one and a half"
        }
        [only] if only.contains('\t') => {
            "cells stand between tabs here: say `delimiter = \"tab\"` in [table]"
        }
        _ => "was the file cut off, or is it written with another delimiter?",
    }
}

/// A delimiter at the end of a line begins no cell.
fn ends_empty(row: &csv::StringRecord) -> bool {
    row.len() > 1 && row.get(row.len() - 1).is_some_and(|c| c.trim().is_empty())
}

fn cell(row: &csv::StringRecord, place: usize) -> &str {
    row.get(place).unwrap_or_default().trim()
}

fn line(row: &csv::StringRecord) -> u64 {
    row.position().map_or(0, csv::Position::line)
}

/// Nanoseconds of a date with its time, or of a time of day, since an instant that is the same for all cells of one format.
fn date_ns(cell: &str) -> Option<i64> {
    const DATES: [&str; 4] = [
        "%Y-%m-%dT%H:%M:%S%.f",
        "%Y-%m-%d %H:%M:%S%.f",
        "%Y/%m/%d %H:%M:%S%.f",
        "%d.%m.%Y %H:%M:%S%.f",
    ];
    if let Ok(zoned) = DateTime::parse_from_rfc3339(cell) {
        return zoned.timestamp_nanos_opt();
    }
    let dates = DATES.iter();
    let date = dates
        .filter_map(|form| NaiveDateTime::parse_from_str(cell, form).ok())
        .next();
    if let Some(date) = date {
        return date.and_utc().timestamp_nanos_opt();
    }
    let time = NaiveTime::parse_from_str(cell, "%H:%M:%S%.f").ok()?;
    Some(1_000_000_000 * i64::from(time.num_seconds_from_midnight()) + i64::from(time.nanosecond()))
}

fn hint(cell: &str, is_number: bool, decimal_comma: bool) -> &'static str {
    if date_ns(cell).is_some() {
        return "if this is the time of the row, say `unit = \"date\"` in [time] column";
    }
    if cell.is_empty() || is_number {
        "leave the row out (a mapping does with `incomplete = \"leave_out\"` in [rows]; where each row has some of the channels, \
         `\"interpolate\"`), or repair it: a gap that is filled in silently looks like an effect"
    } else if !decimal_comma && cell.contains(',') {
        "if this is a decimal comma, say `decimal_comma = true`"
    } else {
        "is there a header, or another delimiter?"
    }
}

/// The text with one blank between two cells and none around a line.
fn single_blanks(text: &str) -> String {
    let mut single = String::with_capacity(text.len());
    for line in text.lines() {
        let mut cells = line.split_whitespace();
        single.extend(cells.next());
        for cell in cells {
            single.push(' ');
            single.push_str(cell);
        }
        single.push('\n');
    }
    single
}
