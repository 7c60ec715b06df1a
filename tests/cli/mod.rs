//! The program's commands as a user calls them.

mod commission;
mod demo_story;
mod effects;
mod files;
mod files_page;
mod firmware;
mod help;
mod init;
mod input_errors;
mod model_edit;
mod pieces;
mod robot_config;
mod rough_places;
mod series;
mod streams;
