//! The image of the NUCLEO board: what it takes of the chip, and how it is flashed. There is no
//! board here: a program in place of probe-rs writes down what it was told.

use softdock_app::image::{Slot, newest};
use softdock_tests::peers::serve;
use softdock_tests::process::{json, scratch, softdock_binary};
use std::ffi::OsString;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs `softdock` with these folders for programs.
fn with_path(folder: &Path, arguments: &[&str], path: OsString) -> Output {
    let mut command = Command::new(softdock_binary());
    command
        .current_dir(folder)
        .args(arguments)
        .env("PATH", path);
    command.output().unwrap()
}

fn stderr(run: &Output) -> String {
    String::from_utf8_lossy(&run.stderr).into_owned()
}

/// The folders for programs, with one before them.
fn path_with(first: &Path) -> OsString {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::iter::once(first.to_owned()).chain(std::env::split_paths(&path));
    std::env::join_paths(folders).unwrap()
}

/// A folder with a `probe-rs` that notes its arguments and keeps a file that it was given; it fails while there is
/// a line in the file `failures`.
fn recorded_probe_rs(folder: &Path) -> PathBuf {
    let programs = folder.join("programs");
    fs::create_dir_all(&programs).unwrap();
    let program = programs.join("probe-rs");
    let kept = folder.display();
    let script = format!(
        "#!/bin/sh\necho \"$@\" >> {kept}/calls\nfor last; do :; done\ncase $1 in download) cp \"$last\" {kept}/written;; \
         --version) exit;; esac\nif [ -s {kept}/failures ]; then sed -i 1d {kept}/failures; exit 1; fi\n"
    );
    fs::write(&program, script).unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    programs
}

#[test]
#[ignore = "long: an image with full optimisation"]
fn the_image_fits_and_its_tasks_are_named() {
    let folder = scratch("cli_firmware");
    let built = json(&folder, &["firmware"]);
    let regions = built["regions"].as_array().unwrap();
    for region in regions {
        let (used, length) = (&region["used"], &region["length"]);
        assert!(used.as_u64() <= length.as_u64(), "{region}");
    }
    let used = |name: &str| {
        let region = regions.iter().find(|region| region["name"] == name);
        region.unwrap()["used"].as_u64().unwrap()
    };
    assert!(used("FLASH") > 50_000 && used("RAM") > 50_000);
    assert_eq!(used("SETTINGS"), 0, "the place of the settings");
    // The command itself refuses what is above its budget.
    let stack = &built["stack"];
    let [boot, nested] = [&stack["boot"]["bytes"], &stack["nested"]].map(|n| n.as_u64().unwrap());
    assert!(boot.min(nested) > 20_000, "{stack}");
    let tasks = built["tasks"].as_array().unwrap();
    for (name, flash) in [
        ("robot_task", 50_000),
        ("sensor_task", 5_000),
        ("network_task", 1_000),
        ("watchdog::feed", 100),
    ] {
        let named = |task: &&serde_json::Value| task["name"].as_str().unwrap().ends_with(name);
        let task = tasks.iter().find(named).unwrap();
        assert!(task["ram"].as_u64().unwrap() > 50, "{task}");
        assert!(task["flash"].as_u64().unwrap() > flash, "{task}");
    }
}

#[test]
#[ignore = "long: an image with full optimisation"]
fn settings_and_image_go_to_the_board() {
    let folder = scratch("cli_flash");
    let programs = recorded_probe_rs(&folder);
    fs::write(
        folder.join("board.toml"),
        "[network]\naddress = \"10.0.0.7\"\n",
    )
    .unwrap();
    let arguments = ["flash", "--settings", "board.toml"];
    let run = with_path(&folder, &arguments, path_with(&programs));
    assert!(run.status.success(), "{}", stderr(&run));
    let calls = fs::read_to_string(folder.join("calls")).unwrap();
    let calls: Vec<&str> = calls.lines().collect();
    let [_version, download, start] = calls[..] else {
        panic!("{calls:?}");
    };
    let to_settings = "download --chip STM32H743ZITx --binary-format bin --base-address 0x81c0000";
    assert!(download.starts_with(to_settings), "{download}");
    assert!(start.starts_with("run --chip STM32H743ZITx "), "{start}");
    assert!(start.ends_with("softdock-nucleo-h743zi.elf"), "{start}");

    // What was written is what the board reads: the newer of two slots of 128 KiB.
    let written = fs::read(folder.join("written")).unwrap();
    let (a, b) = written.split_at(128 * 1024);
    let (image, slot) = newest(a, b).unwrap();
    assert_eq!(slot, Slot::A);
    assert_eq!(image.settings.network.address.as_str(), "10.0.0.7");
}

/// The header of an ELF file for an ARM processor (System V ABI, 4), whose program begins in the chip's flash.
fn empty_image() -> Vec<u8> {
    let mut bytes = b"\x7fELF\x01\x01\x01".to_vec();
    bytes.resize(52, 0);
    for (at, value) in [(16, 2), (18, 40), (20, 1), (40, 52), (42, 32), (46, 40)] {
        bytes[at] = value;
    }
    bytes[24..28].copy_from_slice(&0x0800_0001_u32.to_le_bytes());
    bytes
}

#[test]
fn a_probe_that_fails_is_asked_once_more_and_then_the_cures_are_named() {
    let folder = scratch("cli_flash_again");
    let programs = recorded_probe_rs(&folder);
    fs::write(folder.join("image.elf"), empty_image()).unwrap();
    let run = |failures: &str| {
        fs::write(folder.join("failures"), failures).unwrap();
        fs::write(folder.join("calls"), "").unwrap();
        let run = with_path(
            &folder,
            &["flash", "--image", "image.elf"],
            path_with(&programs),
        );
        let calls = fs::read_to_string(folder.join("calls")).unwrap();
        let runs = calls.lines().filter(|call| call.starts_with("run "));
        (run.status.code(), runs.count(), stderr(&run))
    };
    assert_eq!(run("").1, 1);
    let (code, runs, said) = run("once\n");
    assert_eq!((code, runs), (Some(0), 2), "{said}");
    let (code, runs, said) = run("once\ntwice\n");
    assert_eq!((code, runs), (Some(1), 2), "{said}");
    for cure in [
        "plug it in again",
        "PROBE_RS_CONNECT_UNDER_RESET",
        "BOOT0",
        "CN1",
    ] {
        assert!(said.contains(cure), "{cure} in: {said}");
    }
}

/// The board is one of this computer: what it can show is tested, what it has not is a warning.
#[test]
fn a_board_that_was_flashed_shows_what_it_can_do() {
    let folder = scratch("cli_flash_self_test");
    let programs = recorded_probe_rs(&folder);
    fs::write(folder.join("image.elf"), empty_image()).unwrap();
    let board = serve("cli_flash_self_test_board", "", &[]);
    let arguments = ["flash", "--image", "image.elf", "--self-test", "--port"];
    let run = with_path(
        &folder,
        &[&arguments[..], &[&board.port]].concat(),
        path_with(&programs),
    );
    let calls = fs::read_to_string(folder.join("calls")).unwrap();
    let words: Vec<_> = calls
        .lines()
        .map(|call| call.split(' ').next().unwrap())
        .collect();
    assert_eq!(words, ["--version", "download", "reset"]);
    let table = String::from_utf8_lossy(&run.stdout).into_owned();
    let line = |name: &str| table.lines().find(|line| line.contains(name)).unwrap();
    assert!(line("flash and reset").contains("good"), "{table}");
    for name in ["CAN controller", "LEDs", "watchdog", "reason of the reset"] {
        assert!(line(name).contains("warning"), "{table}");
    }
    assert!(table.contains("has no chip that tells"), "{table}");
}

#[test]
fn what_cannot_be_flashed_says_what_to_do() {
    let folder = scratch("cli_flash_wrong");
    let programs = recorded_probe_rs(&folder);
    let fails = |arguments: &[&str], expected: &[&str]| {
        let run = with_path(&folder, arguments, path_with(&programs));
        assert_eq!(run.status.code(), Some(1));
        for part in expected {
            assert!(stderr(&run).contains(part), "`{part}` in: {}", stderr(&run));
        }
    };
    fs::write(folder.join("board.toml"), "[netwrok]\n").unwrap();
    fails(
        &["flash", "--settings", "board.toml"],
        &["netwrok", "network"],
    );
    fs::write(folder.join("notes.txt"), "not a program").unwrap();
    fails(&["flash", "--image", "notes.txt"], &["notes.txt", "ELF"]);
    let host = std::env::current_exe().unwrap();
    fails(&["flash", "--image", &host.display().to_string()], &["ARM"]);
    let calls = fs::read_to_string(folder.join("calls")).unwrap_or_default();
    assert!(
        !calls.contains("run") && !calls.contains("download"),
        "{calls}"
    );

    let empty = folder.join("empty");
    fs::create_dir_all(&empty).unwrap();
    let run = with_path(&folder, &["flash"], empty.into_os_string());
    assert_eq!(run.status.code(), Some(1));
    assert!(
        stderr(&run).contains("cargo install probe-rs-tools"),
        "{}",
        stderr(&run)
    );
}
