//! Who made a recording: name, version, git hash, changed or not.

use std::sync::OnceLock;

/// Git state of the program's build. The program says it and not this crate, which would be compiled
/// anew, with all that stands on it, at each commit.
static GIT: OnceLock<&'static str> = OnceLock::new();

/// Says from which git state the program was built; the first word counts.
pub fn built_from(git: &'static str) {
    GIT.get_or_init(|| git);
}

/// Name, version and git state of the program.
pub fn text() -> String {
    let git = GIT.get().copied().unwrap_or("as a library");
    format!("softdock {} ({git})", env!("CARGO_PKG_VERSION"))
}
