//! Reports in a browser.

mod browser;
mod diagnosis;
mod terminal;
