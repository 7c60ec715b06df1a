//! The `softdock` command.

use clap::Parser;
use softdock::cli::{Cli, print_json_error};
use std::process::ExitCode;

fn main() -> ExitCode {
    softdock_io::identity::built_from(env!("SOFTDOCK_GIT"));
    let json = std::env::args_os().any(|argument| argument == "--json");
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            if json && error.use_stderr() {
                let text = error.to_string();
                print_json_error(text.trim_start_matches("error: ").trim_end());
            }
            error.exit()
        }
    };
    match cli.execute() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let error = format!("{error:#}");
            if json {
                print_json_error(&error);
            }
            softdock_io::say!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
