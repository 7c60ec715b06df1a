//! docs/messages.md quotes what the program prints.

use std::path::Path;

const PAGE: &str = include_str!("../../docs/messages.md");

/// The strings of all sources below a folder, without what only tests expect.
fn strings(folder: &Path, found: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.file_stem().is_some_and(|name| name == "tests") {
            continue;
        }
        if path.is_dir() {
            strings(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let source = std::fs::read_to_string(&path).unwrap();
            let code = source.split("#[cfg(test)]\nmod tests {").next().unwrap();
            found.extend(literals(code));
        }
    }
}

/// What stands between quotation marks, each in one line.
fn literals(code: &str) -> Vec<String> {
    const QUOTED: &str = "\u{1}";
    let lines = code
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"));
    let code = lines.collect::<Vec<_>>().join("\n").replace("'\"'", "");
    let code = code.replace("\\\\", "").replace("\\\"", QUOTED);
    let between = code.split('"').skip(1).step_by(2);
    let whole = |text: &str| {
        let lines = text.split("\\\n").map(str::trim_start);
        lines.collect::<String>().replace(QUOTED, "\"")
    };
    between.map(whole).collect()
}

/// Whether a string holds the pieces between which something is filled in, one behind the other.
fn holds(string: &str, message: &str) -> bool {
    let mut rest = Some(string);
    for piece in message.split('…').map(str::trim) {
        rest = rest.and_then(|rest| Some(rest.split_once(piece)?.1));
    }
    rest.is_some()
}

/// Each quoted beginning stands in one string of the sources.
#[test]
fn each_message_of_the_page_is_printed() {
    let mut all = Vec::new();
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host-tools");
    for part in ["analysis/src", "cli/src/cli", "physics/src"] {
        strings(&crates.join(part), &mut all);
    }
    let rows = PAGE.lines().filter_map(|line| line.strip_prefix("| `"));
    let quoted = rows.filter_map(|row| row.split(" | ").next());
    let messages: Vec<&str> = quoted.flat_map(|cell| cell.split('`').step_by(2)).collect();
    assert!(messages.len() > 30, "{}", messages.len());
    for message in messages {
        let longest = message.split('…').map(str::len).max();
        assert!(longest >= Some(8), "{message}: too short to be found by");
        assert!(all.iter().any(|string| holds(string, message)), "{message}");
    }
}
