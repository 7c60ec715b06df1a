//! `--help` of every command, and what a mistyped command gets.

use softdock_tests::process::{done, scratch, softdock};
use std::fs;

/// The commands below `command` ("" for `softdock` itself), from the text of its help.
fn commands_of(help: &str) -> Vec<String> {
    let below = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let names = below.take_while(|line| !line.is_empty());
    // A name stands behind two spaces; continued descriptions stand deeper.
    let names = names.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    names
        .filter_map(|line| line.split_whitespace().next())
        .map(Into::into)
        .collect()
}

/// Checks `softdock COMMAND.. --help` and everything below it; the number of commands.
fn check(command: &[&str]) -> usize {
    let folder = std::env::current_dir().unwrap();
    let asked = softdock(&folder, &[command, &["--help"]].concat());
    assert_eq!(
        (asked.code, asked.stderr.as_str()),
        (Some(0), ""),
        "{command:?}"
    );
    let below = commands_of(&asked.stdout);
    if below.is_empty() {
        let example = format!("Example: softdock {}", command.join(" "));
        assert!(
            asked.stdout.contains(&example),
            "expected `{example}` in\n{}",
            asked.stdout
        );
    }
    let of_the_repository = ["host-tools/", "tests/"];
    assert!(
        !of_the_repository
            .iter()
            .any(|path| asked.stdout.contains(path)),
        "{command:?} names a file that only a clone has:\n{}",
        asked.stdout
    );
    let mut count = 1;
    for name in below.iter().filter(|name| *name != "help") {
        count += check(&[command, &[name.as_str()]].concat());
    }
    count
}

#[test]
fn every_command_explains_itself_with_an_example() {
    let commands = check(&[]) - 1;
    assert!(commands >= 9, "only {commands} commands were found");
}

#[test]
fn the_commands_of_the_story_are_there() {
    let folder = std::env::current_dir().unwrap();
    let help = softdock(&folder, &["--help"]).stdout;
    let known = commands_of(&help);
    for name in [
        "demo",
        "run",
        "board",
        "record",
        "robot-config",
        "compare",
        "reproduce",
        "replay",
        "export",
        "import",
    ] {
        assert!(
            known.iter().any(|k| k == name),
            "{name} is not in {known:?}"
        );
    }
    assert!(
        help.contains("softdock demo"),
        "the first thing to try is named"
    );
}

#[test]
fn what_cannot_be_understood_is_an_error() {
    let folder = scratch("cli_mistakes");
    for arguments in [&["rnu"][..], &["run"], &["replay", "--jsn", "x.mcap"], &[]] {
        let run = softdock(&folder, arguments);
        assert_eq!(
            (run.code, run.stdout.as_str()),
            (Some(2), ""),
            "{arguments:?}"
        );
        assert!(run.stderr.contains("Usage: softdock"), "{}", run.stderr);
    }
    let similar = softdock(&folder, &["rpelay", "x.mcap"]);
    assert!(similar.stderr.contains("'replay'"), "{}", similar.stderr);
}

/// What a shell and `man` are told of them.
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
