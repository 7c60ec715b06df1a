//! Passes the linker script of the MPS2 boards to the linker when the program is built.

use std::path::PathBuf;
use std::{env, fs};

fn main() {
    if env::var_os("CARGO_FEATURE_BOARD").is_none() {
        return;
    }
    const SCRIPT: &str = "../mps2/mps2.x";
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    if let Err(error) = fs::copy(SCRIPT, out.join("mps2.x")) {
        println!("cargo::error=cannot copy {SCRIPT}: {error}");
    }
    println!("cargo::rerun-if-changed={SCRIPT}");
    println!("cargo::rustc-link-search={}", out.display());
    for argument in ["--nmagic", "-Tmps2.x"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
}
