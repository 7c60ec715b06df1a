//! The workbench: one page in the browser on the recordings and models of a folder.
//!
//! The server calls the same library functions as the commands and answers with the same JSON. It listens on this computer
//! only, or requires a token, and `guard` refuses requests of other pages in the browser. It never starts, arms or moves a
//! board.
//!
//! - `state` is shared by all handlers, `server` has the routes, `guard` and `access` check every request,
//! - `folder` confines paths, `files` caches what was read,
//! - `recordings`, `models`, `lists` answer at once; `jobs` reports progress, and answers when the work is done,
//! - `live` shows the telemetry of a running board,
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
