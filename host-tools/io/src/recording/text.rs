//! Messages as text: the cells of a CSV row.

use super::field::{Field, Number, Visitor, Words};
use super::schema::fields;
use super::topics::Topic;
use std::convert::Infallible;

/// Names of all columns of a topic, one for each number.
pub(super) fn columns(topic: Topic) -> impl Iterator<Item = String> {
    let prefix = topic.prefix();
    let names = move |described: super::schema::Described| described.field.columns(&prefix);
    fields(topic).into_iter().flat_map(names)
}

/// Writes each number as one cell.
#[derive(Debug, Default)]
pub(super) struct CellWriter {
    pub(super) cells: Vec<String>,
}

impl Visitor for CellWriter {
    type Error = Infallible;

    fn numbers<T: Number>(&mut self, _: &Field, values: &mut [T]) -> Result<(), Infallible> {
        self.cells.extend(values.iter().map(|value| value.text()));
        Ok(())
    }

    fn choice(&mut self, _: &Field, words: Words, code: &mut u8) -> Result<(), Infallible> {
        let word = words.get(usize::from(*code)).copied();
        self.cells.push(word.unwrap_or_default().to_owned());
        Ok(())
    }
}

/// A cell that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected {expected}, received `{received}`")]
pub(super) struct CellError {
    expected: String,
    received: String,
}

/// Reads the cells of a row in order.
#[derive(Debug)]
pub(super) struct CellReader<'a> {
    row: &'a csv::StringRecord,
    place: usize,
}

impl<'a> CellReader<'a> {
    pub(super) fn new(row: &'a csv::StringRecord) -> Self {
        Self { row, place: 0 }
    }

    /// Index of the cell that was read last.
    pub(super) fn last_place(&self) -> usize {
        self.place.saturating_sub(1)
    }

    fn next<T>(
        &mut self,
        parse: impl FnOnce(&str) -> Option<T>,
        expected: impl FnOnce() -> String,
    ) -> Result<T, CellError> {
        let text = self.row.get(self.place).unwrap_or_default();
        self.place += 1;
        parse(text).ok_or_else(|| CellError {
            expected: expected(),
            received: text.to_owned(),
        })
    }
}

impl Visitor for CellReader<'_> {
    type Error = CellError;

    fn numbers<T: Number>(&mut self, _: &Field, values: &mut [T]) -> Result<(), CellError> {
        for value in values {
            *value = self.next(T::parse, || format!("a number ({})", T::ROS_TYPE))?;
        }
        Ok(())
    }

    fn choice(&mut self, _: &Field, words: Words, code: &mut u8) -> Result<(), CellError> {
        let place = |text: &str| words.iter().position(|word| *word == text);
        let parse = |text: &str| place(text).and_then(|place| u8::try_from(place).ok());
        *code = self.next(parse, || format!("one of {}", words.join(", ")))?;
        Ok(())
    }
}
