//! `softdock init`: its files, and the commands that it prints.

use softdock_tests::process::{done, scratch, softdock, words};

#[test]
fn the_commands_that_it_prints_work_on_its_files() {
    let folder = scratch("cli_init");
    let init = done(&folder, &["init", "laboratory"]);
    let laboratory = folder.join("laboratory");
    for name in ["scenario.toml", "board.toml", "rig.toml", "model.toml"] {
        assert!(laboratory.join(name).is_file(), "{name}");
    }
    let mut commands = 0;
    for line in init.lines() {
        let Some(command) = line.trim().strip_prefix("softdock ") else {
            continue;
        };
        let arguments: Vec<&str> = command.split(' ').collect();
        let run = softdock(&laboratory, &arguments);
        assert_eq!(run.code, Some(0), "{command}: {}{}", run.stdout, run.stderr);
        commands += 1;
    }
    assert_eq!(commands, 3, "{}", init);

    // The board's own file does what the scenario's does.
    let run = words("run scenario.toml --settings board.toml -o own.mcap");
    done(&laboratory, &run);
    let cycles = |name: &str| {
        softdock_io::recording::Recording::open(&laboratory.join(name))
            .unwrap()
            .cycles
    };
    assert_eq!(cycles("run.mcap"), cycles("own.mcap"));
}

#[test]
fn nothing_is_overwritten() {
    let folder = scratch("cli_init_twice");
    std::fs::write(folder.join("model.toml"), "mine").unwrap();
    let init = softdock(&folder, &["init"]);
    assert_eq!(init.code, Some(1));
    assert!(
        init.stderr.contains("model.toml exists already"),
        "{}",
        init.stderr
    );
    assert_eq!(
        std::fs::read_to_string(folder.join("model.toml")).unwrap(),
        "mine"
    );
    assert!(!folder.join("scenario.toml").exists());
}
