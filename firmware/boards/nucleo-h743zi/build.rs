//! Links with cortex-m-rt's script and the memory layout at the top of the repository.

use std::env;

include!("../../git_state.rs");

/// The repository, relative to this folder.
const ROOT: &str = "../../..";

fn main() {
    let target = env::var("TARGET").unwrap_or_default();
    if target != "thumbv7em-none-eabihf" {
        println!(
            "cargo::error=softdock-nucleo-h743zi is for a Cortex-M7; build it with --target thumbv7em-none-eabihf, not for {target}"
        );
        return;
    }
    // The linker runs in the repository's top folder, where link.x finds memory.x.
    println!("cargo::rerun-if-changed={ROOT}/memory.x");
    // Without --nmagic the linker would align sections for pages, which the board does not have. `softdock firmware` uses the
    // relocations to find how much flash each task needs.
    for argument in ["--nmagic", "--emit-relocs", "-Tlink.x", "-Tdefmt.x"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
    set_git_state(ROOT);
}
