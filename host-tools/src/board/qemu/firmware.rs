//! Builds the firmware's image with cargo.

use super::chip::Chip;
use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The package.
const PACKAGE: &str = "softdock-mps2";
/// Its profile: that of all boards.
const PROFILE: &str = "firmware";

/// Builds the image; its path.
///
/// # Errors
/// The sources, cargo or the target are missing, or it does not build.
pub(super) fn build(chip: Chip) -> Result<PathBuf> {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    ensure!(
        sources.join("firmware/boards/mps2").is_dir(),
        "the firmware's sources are not in {} any more; run `cargo qemu` in the repository, which builds this program there as well",
        sources.display()
    );
    need_target(chip)?;
    let arguments = [
        "build",
        "--profile",
        PROFILE,
        "--package",
        PACKAGE,
        "--target",
        chip.target(),
    ];
    eprintln!(
        "qemu: firmware for {}: cargo {}",
        chip.machine(),
        arguments.join(" ")
    );
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .current_dir(&sources)
        .args(arguments)
        .arg("--message-format=json-render-diagnostics")
        .stdin(Stdio::null())
        .stderr(Stdio::inherit())
        .output()
        .context(
            "cannot run cargo, which builds the firmware; install Rust from https://rustup.rs",
        )?;
    ensure!(
        output.status.success(),
        "the firmware does not build; cargo's messages stand above"
    );
    let messages = String::from_utf8_lossy(&output.stdout);
    match messages.lines().find_map(executable) {
        Some(elf) => Ok(elf),
        None => bail!("cargo built {PACKAGE}, but names no executable"),
    }
}

/// The executable in one of cargo's messages.
fn executable(message: &str) -> Option<PathBuf> {
    let message: Value = serde_json::from_str(message).ok()?;
    let ours = message["target"]["name"] == PACKAGE;
    ours.then(|| message["executable"].as_str().map(PathBuf::from))?
}

/// Without the target's libraries, cargo only says that it cannot find `core`.
fn need_target(chip: Chip) -> Result<()> {
    let target = chip.target();
    let output = Command::new("rustc")
        .args(["--print", "target-libdir", "--target", target])
        .output()
        .context(
            "cannot run rustc, which builds the firmware; install Rust from https://rustup.rs",
        )?;
    let libraries = String::from_utf8_lossy(&output.stdout);
    ensure!(
        output.status.success() && Path::new(libraries.trim()).is_dir(),
        "Rust's libraries for {} are missing; install them: rustup target add {target}",
        chip.machine()
    );
    Ok(())
}
