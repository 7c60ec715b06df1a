//! An effect stands in one place: no other file of the program says its id. What is of one effect alone (a fit of the clock, the
//! columns of a mass) refers to it by path, which the compiler follows.

use softdock_physics::effects::CATALOGUE;
use std::path::{Path, PathBuf};

/// Files that state how several effects are related, which no file of a single one could; and the one
/// that translates the judge's names of parameters, which the judge shares with nobody.
const RELATIONS: [&str; 3] = [
    "diagnose/answer/equivalent.rs",
    "diagnose/stages/accepted.rs",
    "bench/diagnose/truth.rs",
];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => sources(&path, found),
            false if path.extension().is_some_and(|e| e == "rs") => found.push(path),
            false => {}
        }
    }
}

#[test]
fn no_other_file_names_an_effect() {
    let host_tools = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host-tools");
    let mut files = Vec::new();
    for part in [
        "physics/src",
        "analysis/src",
        "rig/src",
        "experiments/src",
        "cli/src",
    ] {
        sources(&host_tools.join(part), &mut files);
    }
    let elsewhere = |path: &&PathBuf| {
        // The path of this test's own crate says "tests", too.
        let name = path.strip_prefix(&host_tools).unwrap_or(path);
        let name = name.display().to_string();
        let related = RELATIONS.iter().any(|r| name.ends_with(r));
        !name.contains("physics/src/effects/") && !name.contains("tests") && !related
    };
    let others: Vec<&PathBuf> = files.iter().filter(elsewhere).collect();
    assert!(others.len() > 100, "{} files are looked at", others.len());
    for path in others {
        let text = std::fs::read_to_string(path).unwrap();
        let program = text.split("#[cfg(test)]").next().unwrap_or_default();
        let code = program
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"));
        let code: Vec<&str> = code.collect();
        for effect in CATALOGUE {
            let named = format!("\"{}\"", effect.id);
            let there = code.iter().any(|line| line.contains(&named));
            assert!(!there, "{} names {}", path.display(), effect.id);
        }
    }
}
