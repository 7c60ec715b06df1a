// Part of build scripts (`include!`): writes the git state of the build into the program, for boot
// messages and recordings.

/// Sets `SOFTDOCK_GIT`: the hash, and whether there are changes. `root` is the repository.
fn set_git_state(root: &str) {
    let hash = git(&["rev-parse", "--short=12", "HEAD"]);
    let changed = git(&["status", "--porcelain", "--untracked-files=no"]);
    let state = match (hash, changed) {
        (Some(hash), Some(changes)) if changes.is_empty() => hash,
        (Some(hash), _) => format!("{hash} with changes"),
        (None, _) => "not built from git".to_owned(),
    };
    println!("cargo::rustc-env=SOFTDOCK_GIT={state}");
    println!("cargo::rerun-if-changed={root}/.git/HEAD");
    println!("cargo::rerun-if-changed={root}/.git/index");
    println!("cargo::rerun-if-changed={root}/firmware");
    println!("cargo::rerun-if-changed=src");
}

fn git(arguments: &[&str]) -> Option<String> {
    // A `git status` that writes the index it has refreshed would make this script run again, and programs look older
    // than their sources.
    let output = std::process::Command::new("git")
        .arg("--no-optional-locks")
        .args(arguments)
        .output()
        .ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
