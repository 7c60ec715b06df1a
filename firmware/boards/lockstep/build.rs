//! Hands the linker the memory layout of the MPS2 boards when the program is built.

use std::path::PathBuf;
use std::{env, fs};

fn main() {
    if env::var_os("CARGO_FEATURE_BOARD").is_none() {
        return;
    }
    const LAYOUT: &str = "../mps2/memory.x";
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    if let Err(error) = fs::copy(LAYOUT, out.join("memory.x")) {
        println!("cargo::error=cannot copy {LAYOUT}: {error}");
    }
    println!("cargo::rerun-if-changed={LAYOUT}");
    println!("cargo::rustc-link-search={}", out.display());
    for argument in ["--nmagic", "-Tlink.x"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
}
