//! Who made a recording: name, version, git hash, changed or not.

/// Name, version and git state of this build.
pub fn text() -> String {
    format!(
        "softdock {} ({})",
        env!("CARGO_PKG_VERSION"),
        env!("SOFTDOCK_GIT")
    )
}
