//! The Python on the pages about recordings does what the pages say.

use softdock_tests::peers::python;
use softdock_tests::process::{scratch, softdock};
use std::fs;
use std::path::Path;

const SCENARIO: &str = include_str!("../../host-tools/scenarios/spring-rod.toml");
const MODEL: &str = include_str!("../../host-tools/scenarios/spring-rod.model.toml");

/// What stands in a page between fences of a language.
fn blocks(page: &str, language: &str) -> Vec<String> {
    let fence = format!("```{language}\n");
    let blocks = page.split(&fence).skip(1);
    blocks
        .filter_map(|rest| Some(rest.split_once("```")?.0.to_owned()))
        .collect()
}

/// A run, recorded as `run.mcap`, and its model.
fn record(folder: &Path) {
    fs::write(folder.join("scenario.toml"), SCENARIO).unwrap();
    fs::write(folder.join("model.toml"), MODEL).unwrap();
    done(folder, "softdock run scenario.toml -o run.mcap");
}

fn done(folder: &Path, command: &str) {
    let arguments = command.strip_prefix("softdock ").unwrap();
    let run = softdock(folder, &arguments.split(' ').collect::<Vec<_>>());
    assert_eq!(run.code, Some(0), "{command}: {}", run.stderr);
}

/// Does what the page says to a recorded run: first its commands, then its Python, whose words come back.
fn follow(page: &str, folder: &Path) -> String {
    record(folder);
    let commands = blocks(page, "sh").concat();
    commands.lines().for_each(|command| done(folder, command));
    python::run(folder, &blocks(page, "python").concat())
}

#[test]
fn read_with_python() {
    let page = include_str!("../../docs/read-with-python.md");
    let said = follow(page, &scratch("recordings_pandas"));
    assert!(said.contains("750 cycles, contact from 1.0"), "{said}");
    assert!(said.contains("the worst error is "), "{said}");
}

#[test]
fn viewers() {
    let page = include_str!("../../docs/viewers.md");
    let said = follow(page, &scratch("recordings_viewers"));
    assert!(said.contains("contact at 1.0"), "{said}");
}
