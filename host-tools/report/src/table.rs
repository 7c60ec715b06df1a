//! One table for both readers: the HTML page and the terminal show the same texts from the same cells. [`super::terminal`]
//! has the layout on a terminal.

use super::number::{self, Format};
use super::text;
/// Words of up to this many characters are not broken on a page.
const SHORT_TEXT: usize = 24;

/// Head of a column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Title of the column.
    pub title: String,
    /// Unit of its numbers, empty for none. It stands in the head only, not at each number.
    pub unit: String,
    /// Whether the column holds numbers, which are right-aligned and never wrap.
    is_numeric: bool,
}

impl Column {
    /// A left-aligned column of words.
    pub fn text(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            unit: String::new(),
            is_numeric: false,
        }
    }

    /// A right-aligned column of numbers or intervals in `unit` (empty for none); its cells never wrap.
    pub fn number(title: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            unit: unit.into(),
            is_numeric: true,
        }
    }

    fn head(&self) -> String {
        match self.unit.as_str() {
            "" => self.title.clone(),
            unit => format!("{} [{unit}]", self.title),
        }
    }
}

/// A judgement on a cell: a colour on the page, and everywhere a sign that needs no colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// As it should be, or better than before.
    Good,
    /// Not as it should be, or worse than before.
    Bad,
    /// Judged, and neither.
    Neutral,
}

impl Mark {
    /// The sign in front of the text.
    pub fn sign(self) -> &'static str {
        match self {
            Self::Good => "✓",
            Self::Bad => "✗",
            Self::Neutral => "·",
        }
    }

    pub(super) fn class(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Bad => "bad",
            Self::Neutral => "neutral",
        }
    }
}

/// A formatted cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cell {
    content: String,
    mark: Option<Mark>,
}

impl Cell {
    /// Words. Line breaks become spaces.
    pub fn text(text: impl AsRef<str>) -> Self {
        Self {
            content: text::printable(text.as_ref()),
            mark: None,
        }
    }

    /// A number with this many significant digits; see [`number::significant`].
    pub fn number(value: f64, digits: usize) -> Self {
        Self::formatted(value, Format::Significant(digits))
    }

    /// A fraction of one in percent with one decimal: `0.123` is written `12.3 %`.
    pub fn percent(fraction: f64) -> Self {
        Self::formatted(fraction, Format::Percent(1))
    }

    /// An interval, with as many decimals as show its width with `digits` digits; see [`number::interval`].
    pub fn interval(low: f64, high: f64, digits: usize) -> Self {
        Self::text(number::interval(low, high, digits))
    }

    /// A number in any [`Format`].
    pub fn formatted(value: f64, format: Format) -> Self {
        Self::text(format.write(value))
    }

    /// The same cell with a judgement.
    #[must_use]
    pub fn marked(mut self, mark: Mark) -> Self {
        self.mark = Some(mark);
        self
    }

    /// Whether a page keeps it on one line.
    fn is_short(&self) -> bool {
        self.content.chars().count() <= SHORT_TEXT
    }

    /// The text for both readers, with the sign of the mark.
    pub(super) fn display_text(&self) -> String {
        match self.mark {
            Some(mark) => format!("{} {}", mark.sign(), self.content),
            None => self.content.clone(),
        }
    }
}

/// A table. [`std::fmt::Display`] writes it for the terminal, [`Table::to_html`] for the page.
///
/// A row with fewer cells than columns is filled up with empty cells; surplus cells get columns without a head.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Table {
    /// Heads, from left to right.
    pub columns: Vec<Column>,
    /// Rows, from top to bottom.
    pub rows: Vec<Vec<Cell>>,
    /// Meaning of the marks, below the table; empty where they need no explanation.
    pub legend: String,
}

impl Table {
    /// A table without rows.
    pub fn new(columns: Vec<Column>) -> Self {
        Self {
            columns,
            ..Self::default()
        }
    }

    /// The same table with words below it that say what its marks mean, such as `✓ at the noise`.
    #[must_use]
    pub fn explained(mut self, legend: impl Into<String>) -> Self {
        self.legend = legend.into();
        self
    }

    /// Adds a row at the end.
    pub fn push(&mut self, row: Vec<Cell>) -> &mut Self {
        self.rows.push(row);
        self
    }

    /// The table as an HTML `<table>` element.
    pub fn to_html(&self) -> String {
        let columns = 0..self.width();
        let head = |index: usize| {
            let class = self.class(index, None);
            format!(
                "<th scope=\"col\"{class}>{}</th>",
                text::escape(&self.head(index))
            )
        };
        let heads: String = columns.clone().map(head).collect();
        let row = |row: &Vec<Cell>| {
            let cell = |index: usize| {
                let class = self.class(index, row.get(index));
                let shown = row.get(index).map(Cell::display_text).unwrap_or_default();
                format!("<td{class}>{}</td>", text::escape(&shown))
            };
            let cells: String = columns.clone().map(cell).collect();
            format!("<tr>{cells}</tr>\n")
        };
        let rows: String = self.rows.iter().map(row).collect();
        let legend = match self.legend.as_str() {
            "" => String::new(),
            legend => format!("<p class=\"legend\">{}</p>\n", text::escape(legend)),
        };
        format!(
            "<table>\n<thead><tr>{heads}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table>\n{legend}"
        )
    }

    /// Number of columns that are drawn.
    pub(super) fn width(&self) -> usize {
        let longest_row = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        self.columns.len().max(longest_row)
    }

    /// Head of a column, empty for one of surplus cells.
    pub(super) fn head(&self, column: usize) -> String {
        let column = self.columns.get(column);
        column.map(Column::head).unwrap_or_default()
    }

    pub(super) fn is_numeric(&self, column: usize) -> bool {
        let column = self.columns.get(column);
        column.is_some_and(|column| column.is_numeric)
    }

    /// Class attribute of a cell, or of the head without one.
    fn class(&self, column: usize, cell: Option<&Cell>) -> String {
        let is_numeric = self.is_numeric(column);
        let is_short = !is_numeric && cell.is_some_and(Cell::is_short);
        let classes: Vec<&str> = is_numeric
            .then_some("number")
            .into_iter()
            .chain(is_short.then_some("short"))
            .chain(cell.and_then(|cell| cell.mark).map(Mark::class))
            .collect();
        if classes.is_empty() {
            String::new()
        } else {
            format!(" class=\"{}\"", classes.join(" "))
        }
    }
}
