//! The workbench: one page in the browser on the recordings and models of a folder.
//!
//! The server asks the same library functions as the commands and answers with the same JSON. It
//! listens on this computer alone, or asks for a token, and `guard` refuses what other pages in the browser might send.
//! It starts, arms and moves no board.
//!
//! - `state` is what all handlers share, `server` connects addresses with them, `guard` and `access` stand before all of them,
//! - `folder` confines paths, `files` keeps what was read,
//! - `recordings`, `models`, `lists` answer at once; `jobs` says how far it is, and answers when it is done,
//! - `live` shows what a running board sends,
//! - `change` is the only one that writes a model file; a job of kind `run` makes a new recording.

mod access;
mod assets;
mod before;
mod change;
mod connections;
mod files;
mod folder;
mod guard;
mod jobs;
mod lists;
mod live;
mod live_requests;
mod models;
mod problem;
mod recordings;
mod server;
mod state;

pub use access::{AccessToken, Reach};
pub use jobs::simulation::{Simulation, Simulator};
pub use server::Server;
