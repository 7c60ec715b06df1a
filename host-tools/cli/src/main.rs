//! The `softdock` command.

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    match softdock::cli::Cli::parse().execute() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
