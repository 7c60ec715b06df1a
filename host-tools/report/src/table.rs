//! One table for both readers: the HTML page and the terminal show the same texts from the same cells.

use super::number::{self, Format};
use super::text;
use comfy_table::{
    CellAlignment, ColumnConstraint, ContentArrangement, LineStyle, TableStyle, Width,
};
use std::fmt::{self, Display, Formatter};
use std::sync::OnceLock;

/// The terminal that tables are written for, if it is one.
static TERMINAL: OnceLock<Terminal> = OnceLock::new();

/// What a terminal can show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terminal {
    /// Characters in a line.
    pub columns: u16,
    /// Whether ✓ and ✗ are coloured.
    pub colours: bool,
}

impl Terminal {
    /// From now on tables that are displayed fit this terminal. Only the first call counts.
    pub fn use_for_tables(self) {
        TERMINAL.get_or_init(|| self);
    }
}

/// Blanks beside the text of a cell on a terminal.
const CELL_PADDING: u16 = 2;
/// Words of up to this many characters are never broken on a terminal.
const SHORTEST_WORD: usize = 10;
/// Words of up to this many characters are not broken on a page.
const SHORT_TEXT: usize = 24;

/// Head of a column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// What the column holds.
    pub title: String,
    /// Unit of its numbers, empty for none. It stands in the head only, not at each number.
    pub unit: String,
    /// Whether it holds numbers, which stand at its right edge and never wrap.
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

    /// What both readers see.
    fn shown(&self) -> String {
        match self.mark {
            Some(mark) => format!("{} {}", mark.sign(), self.content),
            None => self.content.clone(),
        }
    }
}

/// A table. [`Display`] writes it for the terminal, [`Table::to_html`] for the page.
///
/// A row with fewer cells than columns is filled up with empty cells; surplus cells get columns without a head.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Table {
    /// Heads, from left to right.
    pub columns: Vec<Column>,
    /// Rows, from top to bottom.
    pub rows: Vec<Vec<Cell>>,
    /// What its marks mean, below the table; empty where they need no words.
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
                let shown = row.get(index).map(Cell::shown).unwrap_or_default();
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

    /// The table as lines of text, each ended by a line break. On a terminal that is too narrow, words wrap.
    fn lines(&self, on: Option<Terminal>) -> String {
        let mut table = self.drawn();
        if let Some(terminal) = on {
            table.set_content_arrangement(ContentArrangement::Dynamic);
            table.set_width(terminal.columns);
            for (column, least) in table.column_iter_mut().zip(self.least_widths(terminal)) {
                let width = Width::Fixed(least.saturating_add(CELL_PADDING));
                column.set_constraint(ColumnConstraint::LowerBoundary(width));
            }
        }
        let mut lines = format!("{}\n", table.trim_fmt());
        if !self.legend.is_empty() {
            lines.push_str(&format!("\n {}\n", self.legend));
        }
        if on.is_some_and(|terminal| terminal.colours) {
            for (mark, colour) in [(Mark::Good, 32), (Mark::Bad, 31)] {
                let coloured = format!("\x1b[{colour}m{}\x1b[0m", mark.sign());
                lines = lines.replace(mark.sign(), &coloured);
            }
        }
        lines
    }

    /// Characters that each column gets at least: numbers whole, and words as well, of heads too, as far as the terminal
    /// is wide enough. Else the widest columns of words give way.
    fn least_widths(&self, terminal: Terminal) -> Vec<u16> {
        let columns = || 0..self.width();
        let room = usize::from(terminal.columns);
        let needed = |widths: &[usize]| {
            let each = |width: &usize| width + usize::from(CELL_PADDING) + 1;
            widths.iter().map(each).sum::<usize>()
        };
        let mut widths: Vec<usize> = columns().map(|column| self.longest_in(column)).collect();
        let heads = columns().map(|column| widths[column].max(longest_word(&self.head(column))));
        let with_heads: Vec<usize> = heads.collect();
        if needed(&with_heads) <= room {
            widths = with_heads;
        }
        while needed(&widths) > room {
            let words = columns().filter(|column| !self.is_numeric(*column));
            match words.max_by_key(|column| widths[*column]) {
                Some(widest) if widths[widest] > SHORTEST_WORD => widths[widest] -= 1,
                _ => break,
            }
        }
        let widths = widths.into_iter();
        widths
            .map(|width| u16::try_from(width).unwrap_or(u16::MAX))
            .collect()
    }

    /// Characters of the longest number or word in the cells of a column.
    fn longest_in(&self, column: usize) -> usize {
        let cells = self.rows.iter().filter_map(|row| row.get(column));
        let longest = cells.map(|cell| match self.is_numeric(column) {
            true => cell.shown().chars().count(),
            false => longest_word(&cell.shown()),
        });
        longest.max().unwrap_or(1)
    }

    /// Number of columns that are drawn.
    fn width(&self) -> usize {
        let longest_row = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        self.columns.len().max(longest_row)
    }

    /// Head of a column, empty for one of surplus cells.
    fn head(&self, column: usize) -> String {
        let column = self.columns.get(column);
        column.map(Column::head).unwrap_or_default()
    }

    fn is_numeric(&self, column: usize) -> bool {
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

/// Characters of the longest word.
fn longest_word(text: &str) -> usize {
    let words = text.split(' ').map(|word| word.chars().count());
    words.max().unwrap_or(0)
}

impl Display for Table {
    /// Writes the table as lines of text, each ended by a line break: as wide as it likes and without colours, or as
    /// [`Terminal::use_for_tables`] asks.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.lines(TERMINAL.get().copied()))
    }
}

impl Table {
    fn drawn(&self) -> comfy_table::Table {
        let rule = LineStyle::none().fill('─').junction('─');
        let mut terminal = comfy_table::Table::new();
        terminal.load_style(TableStyle::new().header_separator(rule));
        let aligned = |index: usize, shown: String| {
            let alignment = if self.is_numeric(index) {
                CellAlignment::Right
            } else {
                CellAlignment::Left
            };
            comfy_table::Cell::new(shown).set_alignment(alignment)
        };
        let head = |index: usize| aligned(index, text::printable(&self.head(index)));
        terminal.set_header((0..self.width()).map(head).collect::<Vec<_>>());
        for row in &self.rows {
            let cell = |index: usize| {
                let shown = row.get(index).map(Cell::shown).unwrap_or_default();
                aligned(index, shown)
            };
            terminal.add_row((0..self.width()).map(cell).collect::<Vec<_>>());
        }
        terminal
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let mut table = Table::new(vec![
            Column::text("Effect"),
            Column::number("Share of what is left", "%"),
            Column::text("Refused because"),
        ]);
        table.push(vec![
            Cell::text("guide_coulomb").marked(Mark::Good),
            Cell::number(12.5, 3),
            Cell::text("it does not help on data that no fit has seen"),
        ]);
        table.explained("✓ named")
    }

    #[test]
    fn on_a_narrow_terminal_lines_break_between_words() {
        let narrow = Terminal {
            columns: 60,
            colours: false,
        };
        let lines = table().lines(Some(narrow));
        assert!(lines.lines().all(|l| l.chars().count() <= 60), "{lines}");
        assert!(lines.contains("12.5"), "{lines}");
        assert!(lines.contains("guide_coulomb"), "{lines}");
        assert!(lines.ends_with("\n\n ✓ named\n"), "{lines}");
        let free = table().lines(None);
        assert_eq!(free.lines().count(), 5, "{free}");
    }

    #[test]
    fn colours_change_nothing_but_signs() {
        let plain = Terminal {
            columns: 80,
            colours: false,
        };
        let coloured = Terminal {
            colours: true,
            ..plain
        };
        let lines = table().lines(Some(coloured));
        assert!(lines.contains("\x1b[32m✓\x1b[0m guide_coulomb"), "{lines}");
        let stripped = lines.replace("\x1b[32m", "").replace("\x1b[0m", "");
        assert_eq!(stripped, table().lines(Some(plain)));
    }
}
