//! Writes the git state of the build into the program, for boot messages and recordings.

include!("../../firmware/git_state.rs");

fn main() {
    set_git_state("../..");
}
