//! Readers that go away, and disks that are full.

#![cfg(unix)]

use softdock_tests::process::{done, scratch, softdock_binary};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder with a model and a short recording of it.
fn folder(test: &str) -> PathBuf {
    let folder = scratch(test);
    done(&folder, &["init", "."]);
    let run = "run scenario.toml -o run.mcap --duration-s 0.5";
    let run: Vec<&str> = run.split(' ').collect();
    done(&folder, &run);
    folder
}

/// Runs a line of a shell, in which `$0` is the program.
fn shell(folder: &Path, line: &str) -> Output {
    let mut shell = Command::new("sh");
    let shell = shell.current_dir(folder).args(["-c", line]);
    shell.arg(softdock_binary()).output().unwrap()
}

#[test]
fn a_reader_that_has_gone_away_is_no_error() {
    let folder = folder("streams_gone");
    for (command, code) in [
        ("compare model.toml run.mcap --report a.html", 0),
        ("compare none.toml run.mcap", 1),
    ] {
        // The reader is away before the program begins.
        let gone =
            |stream: &str| format!("(sleep 0.3; \"$0\" {command} {stream}; echo $? >code) | true");
        for stream in ["2>&1 >run.txt", "2>run.txt", "2>&1"] {
            let _ = fs::remove_file(folder.join("code"));
            let _ = fs::remove_file(folder.join("a.html"));
            shell(&folder, &gone(stream));
            let ended = fs::read_to_string(folder.join("code")).unwrap();
            assert_eq!(ended.trim(), code.to_string(), "{command} {stream}");
        }
        assert_eq!(folder.join("a.html").exists(), code == 0);
    }
}

#[test]
fn what_does_not_fit_is_not_begun() {
    let folder = folder("streams_full");
    let before = names(&folder);
    // A limit of 4 or 8 kB for each file stands for a full disk.
    for command in [
        "export run.mcap -o run.csv",
        "export run.mcap -o view.mcap",
        "compare model.toml run.mcap --report r.html",
        "compare model.toml run.mcap --series s.csv",
        "effects show guide_coulomb --picture guide.html",
    ] {
        let ended = shell(
            &folder,
            &format!("trap '' XFSZ; ulimit -f 8; \"$0\" {command}"),
        );
        let said = String::from_utf8_lossy(&ended.stderr).into_owned();
        assert_eq!(ended.status.code(), Some(1), "{command}: {said}");
        assert!(said.contains("error: cannot write"), "{command}: {said}");
        assert_eq!(names(&folder), before, "{command}");
    }
}

fn names(folder: &Path) -> Vec<String> {
    let files = fs::read_dir(folder).unwrap();
    let names = files.map(|file| file.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}
