//! The Python on the pages about recordings does what the pages say.

use softdock_tests::peers::python;
use softdock_tests::process::{self, scratch, softdock_binary, words};
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
    process::done(folder, &words(arguments));
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

/// Python text in a folder with a recorded run, with the wheel's module and the program of the tests: what it says.
fn with_module(name: &str, text: &str) -> String {
    let folder = scratch(name);
    record(&folder);
    fs::copy(folder.join("run.mcap"), folder.join("train.mcap")).unwrap();
    done(&folder, "softdock run scenario.toml --seed 7 -o test.mcap");
    let module = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host-tools/python");
    let binary = softdock_binary();
    let before = format!(
        "import os, sys\nsys.path.insert(0, {module:?})\nos.environ['PATH'] = {:?}\n",
        binary.parent().unwrap()
    );
    python::run(&folder, &(before + text))
}

#[test]
fn the_python_module() {
    let page = include_str!("../../host-tools/python/README.md");
    let after = "
print(f'{len(run)} cycles by {run.index.name}')
try:
    softdock.read('model.toml')
except softdock.SoftdockError as error:
    print('refused:', error)
";
    let said = with_module(
        "recordings_module",
        &(blocks(page, "python").concat() + after),
    );
    for expected in [
        "The model fails in executed_velocity x",
        "'zero_cross_pause'",
        "750 cycles by status_time_s",
        "refused: cannot read the recording `model.toml`",
    ] {
        assert!(said.contains(expected), "`{expected}`: {said}");
    }
}

#[test]
fn the_notebook() {
    let notebook = include_str!("../../examples/notebook.ipynb");
    let notebook: serde_json::Value = serde_json::from_str(notebook).unwrap();
    let cells = notebook["cells"].as_array().unwrap().iter();
    let code = cells.filter(|cell| cell["cell_type"] == "code");
    let lines = code.map(|cell| {
        let lines = cell["source"].as_array().unwrap().iter();
        lines.map(|line| line.as_str().unwrap()).collect::<String>() + "\n"
    });
    let said = with_module("recordings_notebook", &lines.collect::<String>());
    assert!(said.contains("750 cycles, contact from 1.0"), "{said}");
    assert!(
        said.contains("The model fails in executed_velocity x"),
        "{said}"
    );
}
