//! The commands that make and read recordings: exit codes, JSON, and what happens to files that
//! are there already, cut off, or of another version.

use serde_json::Value;
use softdock_tests::process::{done, json, scratch, softdock, words};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The scenario that comes with the program: one impact at 5 mm/s, 750 cycles.
const SCENARIO: &str = include_str!("../../host-tools/scenarios/spring-rod.toml");

/// A recording of the scenario, and what `run --json` said about it.
fn recorded() -> &'static (Vec<u8>, Value) {
    static RUN: OnceLock<(Vec<u8>, Value)> = OnceLock::new();
    RUN.get_or_init(|| {
        let folder = scratch("cli_run");
        fs::write(folder.join("scenario.toml"), SCENARIO).unwrap();
        let told = json(&folder, &words("run scenario.toml -o run.mcap"));
        (fs::read(folder.join("run.mcap")).unwrap(), told)
    })
}

/// A folder with the recording in it.
fn with_recording(test: &str) -> PathBuf {
    let folder = scratch(test);
    fs::write(folder.join("run.mcap"), &recorded().0).unwrap();
    folder
}

#[test]
fn run_reports_its_impacts() {
    let (_, summary) = recorded();
    for speed in ["real_time_factor", "cycles_per_processor_second"] {
        assert!(summary[speed].as_f64().unwrap() > 0.0, "{summary}");
    }
    let impacts = summary["impacts"].as_array().unwrap();
    assert_eq!(impacts.len(), 1, "{summary}");
    for key in [
        "speed_in_mm_s",
        "speed_out_mm_s",
        "restitution",
        "energy_error",
        "peak_force_error",
        "contact_time_error",
    ] {
        assert!(impacts[0][key].is_f64(), "{key} in {}", impacts[0]);
    }
    let speed = impacts[0]["speed_in_mm_s"].as_f64().unwrap();
    assert!((speed - 5.0).abs() < 0.05, "{speed} mm/s");
}

/// The recording is whole, and a script goes no further.
#[test]
fn a_run_that_ends_in_a_fault_is_no_success() {
    let folder = scratch("cli_run_fault");
    let weak = "[board.control.limits]\nforce_n = 50.0\n\n[board.control.delay]";
    let scenario = SCENARIO.replace("[board.control.delay]", weak);
    fs::write(folder.join("scenario.toml"), scenario).unwrap();
    let run = softdock(&folder, &words("run scenario.toml -o run.mcap --json"));
    assert_eq!(run.code, Some(1));
    let says = "the run ended in a latched fault: ";
    assert!(run.stderr.contains(says), "{}", run.stderr);
    assert_eq!(run.json()["final_mode"], "Fault");
    assert!(folder.join("run.mcap").exists());
}

#[test]
fn run_obeys_its_options_and_names_mistakes() {
    let folder = scratch("cli_run_options");
    fs::write(folder.join("scenario.toml"), SCENARIO).unwrap();
    let run = "run scenario.toml -o run.mcap --speed-mm-s 8";
    let run = json(&folder, &words(run));
    let speed = run["impacts"][0]["speed_in_mm_s"].as_f64().unwrap();
    assert!((speed - 8.0).abs() < 0.08, "{speed} mm/s");

    let wrong = SCENARIO.replace("stiffness_n_per_m", "stiffness_n_per_mm");
    fs::write(folder.join("wrong.toml"), wrong).unwrap();
    for (name, says) in [
        ("wrong.toml", "did you mean `stiffness_n_per_m`?"),
        ("scenari.toml", "scenario.toml"),
    ] {
        softdock(&folder, &["run", name, "-o", "other.mcap"]).refused(&[says]);
    }
    assert!(
        !folder.join("other.mcap").exists(),
        "a refused run leaves no recording"
    );
    let run = softdock(&folder, &words("run scenario.toml -o no/folder/run.mcap"));
    run.refused(&["no/folder/run.mcap"]);
}

#[test]
fn a_replay_is_identical() {
    let folder = with_recording("cli_replay");
    let report = json(&folder, &["replay", "run.mcap"]);
    assert_eq!(report["identical"], true);
    assert!(report.as_object().unwrap()["first_difference"].is_null());
    let text = done(&folder, &["replay", "run.mcap"]);
    assert!(text.contains("identical"), "{text}");
    softdock(&folder, &["replay", "rnu.mcap"]).refused(&["rnu.mcap"]);
}

#[test]
fn a_recording_survives_export_and_import_and_a_changed_cell_is_found() {
    let folder = with_recording("cli_csv");
    done(&folder, &["export", "run.mcap", "-o", "run.csv"]);
    done(&folder, &["import", "run.csv", "-o", "back"]);
    done(&folder, &["replay", "back/run.mcap"]);

    // The correction of one cycle, one unit of its last digit off.
    let table = fs::read_to_string(folder.join("run.csv")).unwrap();
    let mut rows: Vec<Vec<String>> = table
        .lines()
        .map(|l| l.split(',').map(Into::into).collect())
        .collect();
    let column = rows[0]
        .iter()
        .position(|name| name.starts_with("output_correction"))
        .unwrap();
    let (row, name) = (200, rows[0][column].clone());
    let counts: i64 = rows[row][column].parse().unwrap();
    rows[row][column] = (counts + 1).to_string();
    let changed: Vec<String> = rows.iter().map(|row| row.join(",")).collect();
    fs::write(folder.join("run.csv"), changed.join("\n") + "\n").unwrap();
    done(&folder, &["import", "run.csv", "-o", "changed"]);
    let replay = softdock(&folder, &["replay", "changed/run.mcap", "--json"]);
    assert_eq!(replay.code, Some(1), "{}", replay.stderr);
    let report = replay.json();
    assert_eq!(report["identical"], false);
    let first = &report["first_difference"];
    assert_eq!(
        (first["cycle"].as_u64(), first["quantity"].as_str()),
        (Some(row as u64 - 1), Some(name.as_str()))
    );
}

/// Why nothing is written.
const KEPT: &str = "exists already and is not overwritten";

/// Runs a command that writes `files` again: refused and nothing changed; with `--force` it works.
fn check_not_overwritten(folder: &Path, arguments: &[&str], files: &[&str]) {
    for file in files {
        let path = folder.join(file);
        for other in files {
            let _ = fs::remove_file(folder.join(other));
        }
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, "precious").unwrap();
        softdock(folder, arguments).refused(&[KEPT]);
        assert_eq!(
            fs::read_to_string(&path).unwrap(),
            "precious",
            "{arguments:?} wrote {file}"
        );
        done(folder, &[arguments, &["--force"]].concat());
        assert_ne!(
            fs::read(&path).unwrap(),
            b"precious",
            "{arguments:?} did not write {file}"
        );
    }
}

#[test]
fn nothing_is_overwritten_without_force() {
    let folder = with_recording("cli_overwrite");
    fs::write(folder.join("scenario.toml"), SCENARIO).unwrap();
    done(&folder, &["export", "run.mcap", "-o", "given.csv"]);
    check_not_overwritten(
        &folder,
        &["run", "scenario.toml", "-o", "out.mcap"],
        &["out.mcap"],
    );
    check_not_overwritten(
        &folder,
        &["export", "run.mcap", "-o", "out.csv"],
        &["out.csv", "out.json"],
    );
    check_not_overwritten(
        &folder,
        &["import", "given.csv", "-o", "imported"],
        &["imported/given.mcap"],
    );
    let config = [
        "robot-config",
        "--board",
        "192.168.1.20:49152",
        "-o",
        "rsi.xml",
    ];
    check_not_overwritten(&folder, &config, &["rsi.xml"]);

    // A board does not start, so `--force` is not tried.
    let any = "127.0.0.1:0";
    fs::write(folder.join("board.toml"), "").unwrap();
    let board = [
        "board",
        "--settings",
        "board.toml",
        "--robot",
        any,
        "--can",
        any,
        "-o",
        "run.mcap",
    ];
    softdock(&folder, &board).refused(&["run.mcap", KEPT]);
    assert_eq!(fs::read(folder.join("run.mcap")).unwrap(), recorded().0);
}

#[test]
fn a_recording_that_was_cut_off_opens_up_to_its_last_whole_part() {
    let folder = with_recording("cli_cut");
    let whole = &recorded().0;
    fs::write(folder.join("cut.mcap"), &whole[..whole.len() * 2 / 3]).unwrap();
    let replay = softdock(&folder, &["replay", "cut.mcap", "--json"]).succeeded();
    let report = replay.json();
    let cycles = report["cycles"].as_u64().unwrap();
    assert!(
        report["identical"] == true && cycles > 100 && cycles < 750,
        "{report}"
    );
    assert!(
        replay.stderr.starts_with("note: "),
        "it says that something is missing: {}",
        replay.stderr
    );

    done(&folder, &["export", "cut.mcap", "-o", "cut.csv"]);
    let rows = fs::read_to_string(folder.join("cut.csv"))
        .unwrap()
        .lines()
        .count() as u64;
    assert_eq!(
        rows,
        cycles + 1,
        "the header and one row for each whole cycle"
    );
}

#[test]
fn other_files_are_refused() {
    let folder = scratch("cli_other_files");
    fs::write(folder.join("text.mcap"), "time,force\n0,1\n").unwrap();
    fs::write(folder.join("text.csv"), "time,force\n0,1\n").unwrap();
    softdock(&folder, &["export", "text.mcap", "-o", "out.csv"]).refused(&["not an MCAP file"]);
    softdock(&folder, &["import", "text.csv", "-o", "out"]).refused(&["text.json"]);
    assert!(
        !folder.join("out.csv").exists() && !folder.join("out").exists(),
        "nothing is left behind"
    );
}
