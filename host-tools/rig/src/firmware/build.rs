//! Building an image: cargo does it, in the repository.

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;
use softdock_io::say;
use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What is built for a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoardImage {
    /// Package of the workspace, with one program of the same name.
    pub package: &'static str,
    /// Target triple.
    pub target: &'static str,
    /// Features of the package.
    pub features: &'static [&'static str],
}

/// Cargo's profile for images that are flashed or measured.
pub const RELEASED: &str = "firmware";
/// The environment variable that names another profile for boards in QEMU: `dev` shares macros
/// and build scripts with the programs of the host.
const PROFILE: &str = "SOFTDOCK_FIRMWARE_PROFILE";

/// The profile of boards in QEMU.
pub fn emulated_profile() -> String {
    std::env::var(PROFILE).unwrap_or_else(|_| RELEASED.to_owned())
}

/// A line of cargo's messages, as far as it matters here.
#[derive(Deserialize)]
struct Message {
    executable: Option<PathBuf>,
}

impl BoardImage {
    /// File name of its own beside cargo's: programs with other features would overwrite each other.
    fn file(&self) -> String {
        let mut parts = vec![self.package];
        parts.extend(self.features);
        format!("{}.elf", parts.join("-"))
    }
}

/// Builds an image with a profile. Returns the program (ELF). Cargo's own messages go to standard error.
pub fn build(board: &BoardImage, profile: &str) -> Result<PathBuf> {
    let root = repository()?;
    ensure_target(board.target)?;
    say!("building {} for {}", board.package, board.target);
    // Until the program has its own name, nobody else may build the package with other features.
    let lock = root.join("target/images.lock");
    let _locked = lock_file(&lock).with_context(|| lock.display().to_string())?;
    let program = compile(&root, board, profile)?;
    let named = program.with_file_name(board.file());
    let new = tempfile::NamedTempFile::new_in(program.parent().unwrap_or(&root))
        .and_then(|new| fs::copy(&program, new.path()).map(|_| new))
        .with_context(|| format!("cannot copy {}", program.display()))?;
    // Atomically: an emulator that starts meanwhile reads either the old file or the new one as a whole.
    new.persist(&named)?;
    Ok(named)
}

/// Waits until nobody else holds the file's lock; it is released when the file is dropped.
fn lock_file(path: &Path) -> std::io::Result<File> {
    fs::create_dir_all(path.parent().unwrap_or(Path::new(".")))?;
    let file = File::create(path)?;
    file.lock()?;
    Ok(file)
}

fn compile(root: &Path, board: &BoardImage, profile: &str) -> Result<PathBuf> {
    let mut cargo = Command::new(cargo())
        .current_dir(root)
        .args(["build", "--quiet", "--profile", profile])
        .args(["--package", board.package, "--target", board.target])
        .arg(format!("--features={}", board.features.join(",")))
        .arg("--message-format=json-render-diagnostics")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .context("cannot start cargo, which builds the image; install Rust: https://rustup.rs")?;
    let mut program = None;
    if let Some(messages) = cargo.stdout.take() {
        for line in BufReader::new(messages).lines() {
            // Lines that are no messages come from a build script or a wrapper.
            let Ok(message) = serde_json::from_str::<Message>(&line?) else {
                continue;
            };
            program = message.executable.or(program);
        }
    }
    ensure!(
        cargo.wait()?.success(),
        "{} was not built; the messages above say why",
        board.package
    );
    program.with_context(|| format!("cargo built no program of {}", board.package))
}

/// The cargo that runs this program, so that both use one tool chain.
fn cargo() -> std::ffi::OsString {
    std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

/// The repository: that from which this program was built, or the one around the present folder.
pub fn repository() -> Result<PathBuf> {
    let built_from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let here = std::env::current_dir()?;
    for folder in std::iter::once(built_from.as_path()).chain(here.ancestors()) {
        if folder.join("memory.x").is_file() && folder.join("firmware/boards").is_dir() {
            return Ok(folder.canonicalize()?);
        }
    }
    bail!(
        "the firmware's source is not found: it was at {} when softdock was built; call this from inside of the repository",
        built_from.display()
    )
}

/// An error that says how to install a target, before cargo would fail in the middle of a build.
fn ensure_target(target: &str) -> Result<()> {
    let found = Command::new("rustc")
        .args(["--print", "target-libdir", "--target", target])
        .output()
        .context("cannot start rustc; install Rust: https://rustup.rs")?;
    let folder = PathBuf::from(String::from_utf8_lossy(&found.stdout).trim());
    ensure!(
        folder.is_dir(),
        "the Rust target {target} is not installed; install it: rustup target add {target}"
    );
    Ok(())
}
