//! docs/files.md has every key of the files that it describes, and the template of a mapping all of a mapping.

use softdock_tests::process::{done, scratch};
use std::path::Path;

const PAGE: &str = include_str!("../../docs/files.md");

/// Fields of the structs of a file of which a misspelt key is an error. The line that declares one begins with `declared`.
fn keys(path: &str, declared: &str) -> Vec<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../host-tools")
        .join(path);
    let source = std::fs::read_to_string(path).unwrap();
    let structs = source.split("(deny_unknown_fields").skip(1);
    let lines = structs.flat_map(|rest| rest.split("\n}").next().unwrap().lines());
    let fields = lines.filter_map(|line| line.strip_prefix(declared)?.split_once(": "));
    let is_name = |key: &&str| key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    let names = fields.map(|(key, _)| key).filter(is_name);
    names.map(str::to_owned).collect()
}

#[test]
fn each_key_is_on_the_page() {
    let part_of_a_word = |c: char| c.is_alphanumeric() || c == '_';
    // What stands between backticks, not in prose.
    let quoted = PAGE
        .lines()
        .flat_map(|line| line.split('`').skip(1).step_by(2));
    let words: Vec<&str> = quoted
        .flat_map(|text| text.split(|c| !part_of_a_word(c)))
        .collect();
    let public = [
        "experiments/src/scenario.rs",
        "rig/src/rig/settings.rs",
        "mechanism/src/docking.rs",
        "mechanism/src/contact.rs",
        "mechanism/src/eddy_current.rs",
        "mechanism/src/hexapod.rs",
        "mechanism/src/hunt_crossley.rs",
        "mechanism/src/loads.rs",
        "mechanism/src/petals.rs",
        "mechanism/src/probe_cone.rs",
        "mechanism/src/socket.rs",
        "mechanism/src/soft_capture.rs",
        "mechanism/src/two_stage.rs",
    ];
    let mut all: Vec<String> = public
        .iter()
        .flat_map(|path| keys(path, "    pub "))
        .collect();
    all.extend(keys("experiments/src/check/rig_file.rs", "    "));
    assert!(all.len() > 100, "{}", all.len());
    for key in all {
        assert!(words.contains(&key.as_str()), "{key}");
    }
}

#[test]
fn the_template_of_a_mapping_has_each_of_its_keys() {
    let folder = scratch("mapping_template");
    let template = done(&folder, &["import", "--template"]);
    let document: toml_edit::DocumentMut = template.parse().unwrap();
    assert!(document.contains_key("time"));
    let part_of_a_word = |c: char| c.is_alphanumeric() || c == '_';
    let words: Vec<&str> = template.split(|c| !part_of_a_word(c)).collect();
    let mapping = "analysis/src/import/mapping";
    let file = keys(&format!("{mapping}/file.rs"), "    pub(super) ");
    let column = keys(&format!("{mapping}/column.rs"), "    ");
    let told = keys("analysis/src/import/starter.rs", "    pub ");
    let all: Vec<String> = [file, column, told].concat();
    assert!(all.len() > 40, "{}", all.len());
    for key in all {
        assert!(words.contains(&key.as_str()), "{key}");
    }
}
