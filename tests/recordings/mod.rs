//! Recordings through their public functions: files, text, replay.

mod csv;
mod damage;
mod file;
mod replay;
mod sample;
