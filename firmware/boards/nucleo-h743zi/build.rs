//! Hands the linker the memory layout at the top of the repository.

use std::path::PathBuf;
use std::{env, fs};

include!("../../git_state.rs");

/// The repository, seen from here.
const ROOT: &str = "../../..";

fn main() {
    let target = env::var("TARGET").unwrap_or_default();
    if target != "thumbv7em-none-eabihf" {
        println!(
            "cargo::error=softdock-nucleo-h743zi is for a Cortex-M7; build it with --target thumbv7em-none-eabihf, not for {target}"
        );
        return;
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    let layout = format!("{ROOT}/memory.x");
    if let Err(error) = fs::copy(&layout, out.join("memory.x")) {
        println!("cargo::error=cannot copy {layout}: {error}");
    }
    println!("cargo::rerun-if-changed={layout}");
    println!("cargo::rustc-link-search={}", out.display());
    // Without --nmagic the linker would align sections for pages, which the board does not have.
    for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
    set_git_state(ROOT);
}
