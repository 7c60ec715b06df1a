//! The workbench: what it answers to programs, whom it refuses, and the whole story by clicks in a browser.

mod hostile;
mod http;
mod live;
mod long;
mod refusals;
mod server;
mod story;
