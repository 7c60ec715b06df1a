//! Reports in a browser.

mod browser;
mod diagnosis;
