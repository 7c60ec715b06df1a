//! docs/messages.md quotes what the program prints.

use std::path::Path;

const PAGE: &str = include_str!("../../docs/messages.md");

/// The text of all sources below a folder, their strings in one line.
fn sources(folder: &Path, text: &mut String) {
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            sources(&path, text);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let source = std::fs::read_to_string(&path)
                .unwrap()
                .replace("\\\"", "\"");
            let mut parts = source.split("\\\n");
            text.extend(parts.next());
            parts.for_each(|part| text.push_str(part.trim_start()));
        }
    }
}

/// Each quoted beginning stands in the sources, piece by piece between what is filled in.
#[test]
fn each_message_of_the_page_is_printed() {
    let mut all = String::new();
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host-tools");
    for part in ["analysis/src", "cli/src/cli", "physics/src"] {
        sources(&crates.join(part), &mut all);
    }
    let rows = PAGE.lines().filter_map(|line| line.strip_prefix("| `"));
    let quoted = rows.filter_map(|row| row.split(" | ").next());
    let messages: Vec<&str> = quoted.flat_map(|cell| cell.split('`').step_by(2)).collect();
    assert!(messages.len() > 30, "{}", messages.len());
    for piece in messages.iter().flat_map(|message| message.split('…')) {
        assert!(all.contains(piece.trim()), "{piece}");
    }
}
