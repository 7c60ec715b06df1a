//! Reports: tables, plots and the one-file HTML page that a command writes for a colleague.
//!
//! Every page is complete in itself: no script, no font, no image and no address outside the file, so it opens on
//! an offline rig computer and from a mail attachment. Plots are inline SVG whose colours follow the reader's light
//! or dark setting. A [`Table`] is rendered from one source for the page and for the terminal, so the two cannot
//! disagree.
//!
//! ```
//! use softdock_report::{Cell, Column, Page, Plot, Series, Table};
//!
//! let mut table = Table::new(vec![Column::text("Channel"), Column::number("RMS error", "N")]);
//! table.push(vec![Cell::text("wrench z"), Cell::number(0.1234, 3)]);
//! print!("{table}");
//!
//! let mut plot = Plot::new("Contact force", "time [s]", "force [N]");
//! plot.series.push(Series::line("measured", vec![(0.0, 0.0), (0.1, 12.0), (0.2, 0.0)]));
//!
//! let mut page = Page::new("Docking test 7");
//! page.headline("The force agrees with the model within 0.12 N.");
//! page.section("Where they differ").table(&table).plot(&plot)?;
//! page.identity("softdock 0.1.0");
//! assert!(page.to_html().contains("<svg"));
//! # Ok::<(), anyhow::Error>(())
//! ```

mod axis;
mod canvas;
mod charts;
mod curve;
mod frame;
mod legend;
pub mod number;
mod page;
mod plot;
mod table;
mod terminal;
mod text;
mod theme;

#[cfg(test)]
mod tests;

pub use charts::{Bar, BarChart, Interval};
pub use curve::{Series, Style};
pub use number::Format;
pub use page::Page;
pub use plot::{Band, Plot};
pub use table::{Cell, Column, Mark, Table};
pub use terminal::Terminal;
pub use theme::Hue;
