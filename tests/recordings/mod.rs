//! Recordings through their public functions: files, text, replay; and tables for other programs.

mod csv;
mod damage;
mod data_table;
mod file;
mod golden;
mod pages;
mod replay;
mod ros2;
mod sample;
mod simulated;
mod table;
