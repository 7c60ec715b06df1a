//! The table of docs/modes.md.

use crate::event::Event;
use crate::rig::Row;

const PAGE: &str = include_str!("../../../../docs/modes.md");

/// Columns of the table, in order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Column {
    Hold,
    Arm,
    Start,
    Stop,
    Reset,
    Zero,
    Jog,
    Quiet,
    NewRun,
    Robot,
    Sensor,
    Contact,
    Else,
}

const COLUMNS: usize = 13;

/// Rows in the order of [`Row::ALL`].
pub(crate) struct Table([[Row; COLUMNS]; 8]);

impl Table {
    /// Reads the table from the page.
    pub(crate) fn read() -> Self {
        Self(Row::ALL.map(|row| {
            let head = format!("| {row:?} |");
            let line = PAGE.lines().find(|line| line.starts_with(&head));
            let line = line.unwrap_or_else(|| panic!("docs/modes.md has no row {row:?}"));
            let cells: Vec<Row> = line
                .split('|')
                .skip(2)
                .take(COLUMNS)
                .map(|cell| named(cell.trim(), row))
                .collect();
            cells
                .try_into()
                .unwrap_or_else(|_| panic!("{row:?} does not have {COLUMNS} cells"))
        }))
    }

    /// The row that follows an event.
    pub(crate) fn next(&self, row: Row, event: Event) -> Row {
        self.0[row as usize][event.column() as usize]
    }
}

fn named(cell: &str, stays: Row) -> Row {
    match cell {
        "–" => stays,
        name => Row::ALL
            .into_iter()
            .find(|row| format!("{row:?}") == name)
            .unwrap_or_else(|| panic!("docs/modes.md: `{name}` is no row")),
    }
}
