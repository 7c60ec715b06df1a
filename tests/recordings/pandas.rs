//! The Python on the page about pandas does what the page says.

use softdock_tests::peers::python;
use softdock_tests::process::{scratch, softdock};
use std::fs;

const PAGE: &str = include_str!("../../docs/read-with-python.md");
const SCENARIO: &str = include_str!("../../host-tools/scenarios/spring-rod.toml");
const MODEL: &str = include_str!("../../host-tools/scenarios/spring-rod.model.toml");

/// What stands in the page between fences of a language.
fn blocks(language: &str) -> Vec<String> {
    let fence = format!("```{language}\n");
    let blocks = PAGE.split(&fence).skip(1);
    blocks
        .filter_map(|rest| Some(rest.split_once("```")?.0.to_owned()))
        .collect()
}

#[test]
fn the_code_on_the_page_runs() {
    let folder = scratch("recordings_pandas");
    fs::write(folder.join("scenario.toml"), SCENARIO).unwrap();
    fs::write(folder.join("model.toml"), MODEL).unwrap();
    let commands = blocks("sh");
    let run = "softdock run scenario.toml -o run.mcap".to_owned();
    for command in std::iter::once(&run).chain(&commands) {
        let arguments = command.trim().strip_prefix("softdock ").unwrap();
        let run = softdock(&folder, &arguments.split(' ').collect::<Vec<_>>());
        assert_eq!(run.code, Some(0), "{command}: {}", run.stderr);
    }
    let code = blocks("python");
    assert_eq!((commands.len(), code.len()), (2, 2));
    let said = python::run(&folder, &code.concat());
    assert!(said.contains("750 cycles, contact from 1.0"), "{said}");
    assert!(said.contains("the worst error is "), "{said}");
}
