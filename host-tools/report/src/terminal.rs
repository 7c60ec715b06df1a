//! A table on a terminal, at most as wide as that. Words wrap. A table whose numbers need more width is continued below, with
//! its first column repeated.

use super::table::{Cell, Mark, Table};
use super::text;
use comfy_table::{
    CellAlignment, ColumnConstraint, ContentArrangement, LineStyle, TableStyle, Width,
};
use std::fmt::{self, Display, Formatter};
use std::sync::OnceLock;

/// The terminal for which tables are laid out; unset if there is none.
static TERMINAL: OnceLock<Terminal> = OnceLock::new();

/// Properties of a terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terminal {
    /// Characters in a line.
    pub columns: u16,
    /// Whether ✓ and ✗ are coloured.
    pub colours: bool,
}

impl Terminal {
    /// Lays out all tables that are displayed from now on for this terminal. Only the first call has an effect.
    pub fn use_for_tables(self) {
        TERMINAL.get_or_init(|| self);
    }
}

/// Blanks beside the text of a cell.
const CELL_PADDING: u16 = 2;
/// Words of up to this many characters are never broken.
const SHORTEST_WORD: usize = 10;

impl Table {
    /// The table as lines of text, each ended by a line break.
    fn lines(&self, on: Option<Terminal>) -> String {
        let mut lines = match on {
            Some(terminal) => {
                let parts = self.parts(terminal);
                let parts: Vec<String> = parts.iter().map(|part| part.fitted(terminal)).collect();
                parts.join("\n")
            }
            None => format!("{}\n", self.drawn().trim_fmt()),
        };
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

    /// Splits the table into tables that fit the terminal, each with the first column. One table if that fits.
    fn parts(&self, terminal: Terminal) -> Vec<Table> {
        let room = usize::from(terminal.columns);
        let (key, further) = (0..1, 1..self.width());
        let narrowest = |column: usize| match self.is_numeric(column) {
            true => self.longest_in(column),
            false => self.longest_in(column).min(SHORTEST_WORD),
        };
        let all: Vec<usize> = (0..self.width()).map(narrowest).collect();
        if needed(&all) <= room {
            return vec![self.clone()];
        }
        let whole = |column: usize| narrowest(column).max(longest_word(&self.head(column)));
        let first = self.longest_in(0).min(room / 3);
        let mut parts: Vec<Vec<usize>> = Vec::new();
        let mut widths = Vec::new();
        for column in further {
            widths.push(whole(column));
            match parts.last_mut() {
                Some(part) if needed(&[&[first], &widths[..]].concat()) <= room => {
                    part.push(column)
                }
                _ => {
                    widths = vec![whole(column)];
                    parts.push(key.clone().chain([column]).collect());
                }
            }
        }
        parts.iter().map(|columns| self.only(columns)).collect()
    }

    /// The table with only these columns.
    fn only(&self, columns: &[usize]) -> Table {
        let cells = |row: &Vec<_>| {
            columns
                .iter()
                .filter_map(|at| row.get(*at))
                .cloned()
                .collect()
        };
        Table {
            columns: columns
                .iter()
                .filter_map(|at| self.columns.get(*at))
                .cloned()
                .collect(),
            rows: self.rows.iter().map(cells).collect(),
            legend: String::new(),
        }
    }

    /// The table as lines that are no longer than those of the terminal, if its numbers allow it.
    fn fitted(&self, terminal: Terminal) -> String {
        let mut table = self.drawn();
        table.set_content_arrangement(ContentArrangement::Dynamic);
        table.set_width(terminal.columns);
        for (column, least) in table.column_iter_mut().zip(self.least_widths(terminal)) {
            let width = Width::Fixed(least.saturating_add(CELL_PADDING));
            column.set_constraint(ColumnConstraint::LowerBoundary(width));
        }
        format!("{}\n", table.trim_fmt())
    }

    /// Smallest width of each column, characters: enough for whole numbers and unbroken words, in heads too. Where the
    /// terminal is too narrow, first the widest columns of words are narrowed, then the heads.
    fn least_widths(&self, terminal: Terminal) -> Vec<u16> {
        let columns = || 0..self.width();
        let room = usize::from(terminal.columns);
        let of_cells: Vec<usize> = columns().map(|column| self.longest_in(column)).collect();
        let of_heads = columns().map(|column| longest_word(&self.head(column)));
        let whole = of_cells.iter().zip(of_heads);
        let whole = whole.map(|(cell, head)| (*cell).max(head)).collect();
        let with_heads = self.narrowed(whole, room);
        let widths = match needed(&with_heads) <= room {
            true => with_heads,
            false => self.narrowed(of_cells, room),
        };
        widths
            .into_iter()
            .map(|width| u16::try_from(width).unwrap_or(u16::MAX))
            .collect()
    }

    /// Narrows the widest columns of words until the table fits, or none can be narrowed further.
    fn narrowed(&self, mut widths: Vec<usize>, room: usize) -> Vec<usize> {
        while needed(&widths) > room {
            let words = (0..widths.len()).filter(|column| !self.is_numeric(*column));
            match words.max_by_key(|column| widths[*column]) {
                Some(widest) if widths[widest] > SHORTEST_WORD => widths[widest] -= 1,
                _ => break,
            }
        }
        widths
    }

    /// Characters of the longest number or word in the cells of a column.
    fn longest_in(&self, column: usize) -> usize {
        let cells = self.rows.iter().filter_map(|row| row.get(column));
        let longest = cells.map(|cell| match self.is_numeric(column) {
            true => cell.display_text().chars().count(),
            false => longest_word(&cell.display_text()),
        });
        longest.max().unwrap_or(1)
    }

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
                let shown = row.get(index).map(Cell::display_text).unwrap_or_default();
                aligned(index, shown)
            };
            terminal.add_row((0..self.width()).map(cell).collect::<Vec<_>>());
        }
        terminal
    }
}

/// Characters of a line whose columns hold texts of these widths.
fn needed(widths: &[usize]) -> usize {
    let each = |width: &usize| width + usize::from(CELL_PADDING) + 1;
    widths.iter().map(each).sum()
}

/// Characters of the longest word.
fn longest_word(text: &str) -> usize {
    let words = text.split(' ').map(|word| word.chars().count());
    words.max().unwrap_or(0)
}

impl Display for Table {
    /// Writes the table as lines of text, each ended by a line break: without a limit of width and without colours, or as set
    /// by [`Terminal::use_for_tables`].
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.lines(TERMINAL.get().copied()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::Column;

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

    #[test]
    fn a_table_of_too_many_numbers_is_continued_below() {
        let laws = (0..8).map(|law| Column::number(format!("law{law}"), ""));
        let mut table = Table::new([Column::text("case")].into_iter().chain(laws).collect());
        let numbers = |case: i32| (0..8).map(move |law| Cell::text(format!("number-{case}{law}")));
        for case in 0..2 {
            let name = Cell::text(format!("a_long_name_of_case_{case}"));
            table.push([name].into_iter().chain(numbers(case)).collect());
        }
        let narrow = Terminal {
            columns: 60,
            colours: false,
        };
        let lines = table.explained("✓ good").lines(Some(narrow));
        assert!(lines.lines().all(|l| l.chars().count() <= 60), "{lines}");
        for case in 0..2 {
            let name = format!("a_long_name_of_case_{case}");
            assert!(lines.matches(&name).count() > 1, "{lines}");
            for law in 0..8 {
                assert_eq!(lines.matches(&format!("number-{case}{law}")).count(), 1);
            }
        }
        assert_eq!(lines.matches("✓ good").count(), 1, "{lines}");
    }
}
