//! Chooses the chip by the target, and passes its linker script to the linker.

use std::path::PathBuf;
use std::{env, fs};

include!("../../git_state.rs");

/// The Cortex-M7 has a stack as large as that of the real board, the NUCLEO's DTCM. Fixed point on the Cortex-M3 makes larger
/// frames.
fn stack_bytes(chip: &str) -> u32 {
    match chip {
        "an500" => 128 << 10,
        _ => 512 << 10,
    }
}

fn main() {
    let target = env::var("TARGET").unwrap_or_default();
    let chip = match target.as_str() {
        "thumbv7em-none-eabihf" => "an500",
        "thumbv7m-none-eabi" => "an385",
        _ => {
            println!(
                "cargo::error=softdock-mps2 is for QEMU's boards; build it with --target thumbv7em-none-eabihf (mps2-an500) or thumbv7m-none-eabi (mps2-an385), not for {target}"
            );
            return;
        }
    };
    println!("cargo::rustc-cfg=chip=\"{chip}\"");
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    const SCRIPT: &str = "mps2.x";
    if let Err(error) = fs::copy(SCRIPT, out.join(SCRIPT)) {
        println!("cargo::error=cannot copy {SCRIPT}: {error}");
    }
    println!("cargo::rerun-if-changed={SCRIPT}");
    println!("cargo::rustc-link-search={}", out.display());
    // Without --nmagic the linker would align sections for pages, which the board does not have.
    let stack = format!("--defsym=_stack_size={}", stack_bytes(chip));
    // The script uses symbols that are defined before it.
    for argument in ["--nmagic", &stack, "-Tmps2.x", "-Tdefmt.x"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
    set_git_state("../../..");
}
