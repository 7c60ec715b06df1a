//! What a shell and `man` are told of the commands.

use softdock_tests::process::{done, scratch, softdock};
use std::fs;

#[test]
fn shells_and_man_know_the_commands() {
    let folder = scratch("cli_man");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let run = softdock(&folder, &["completions", shell]);
        assert!(run.stdout.contains("robot-config"), "{shell}");
    }
    done(&folder, &["man", "-o", "man1"]);
    let page = |name: &str| fs::read_to_string(folder.join("man1").join(name)).unwrap();
    assert!(page("softdock.1").contains("docking"));
    assert!(page("softdock-params-get.1").contains(".TH"));
    assert!(page("softdock-rig.1").contains("\\-\\-hide"));
}
