//! Recordings through their public functions: files, text, replay.

mod csv;
mod damage;
mod file;
mod golden;
mod replay;
mod sample;
mod table;
