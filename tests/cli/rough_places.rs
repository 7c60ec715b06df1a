//! What a new user mistypes or mixes up: each says what it is and what to do.

use softdock_tests::process::{Finished, done, scratch, softdock, words};
use std::fs;
use std::path::{Path, PathBuf};

const SCENARIO: &str = include_str!("../../host-tools/scenarios/spring-rod.toml");
const MODEL: &str = include_str!("../../host-tools/scenarios/spring-rod.model.toml");
const BOARD: &str = include_str!("../../host-tools/scenarios/board.toml");

/// A folder with a scenario, its model, a board and a short recording.
fn folder(test: &str) -> PathBuf {
    let folder = scratch(test);
    for (name, text) in [
        ("scenario.toml", SCENARIO),
        ("model.toml", MODEL),
        ("board.toml", BOARD),
    ] {
        fs::write(folder.join(name), text).unwrap();
    }
    let run = words("run scenario.toml -o run.mcap --duration-s 0.5");
    done(&folder, &run);
    folder
}

/// It fails, and says so; nothing is on standard output.
fn refused(folder: &Path, command: &str, says: &[&str]) -> Finished {
    let arguments: Vec<&str> = command.split(' ').collect();
    let run = softdock(folder, &arguments);
    assert!(run.code.is_some_and(|code| code != 0), "{command}");
    for says in says {
        assert!(
            run.stderr.contains(says),
            "{command}: expected `{says}` in {}",
            run.stderr
        );
    }
    run
}

#[test]
fn a_file_of_another_kind_is_recognised() {
    let folder = folder("rough_kinds");
    let swapped = "were two files swapped?";
    for (command, says) in [
        (
            "compare run.mcap model.toml",
            "this is a recording (MCAP), expected is a TOML file",
        ),
        (
            "compare model.toml scenario.toml",
            "it is a text: were two files swapped?",
        ),
        (
            "compare scenario.toml run.mcap",
            "This looks like a scenario",
        ),
        (
            "compare board.toml run.mcap",
            "This looks like the settings of a board",
        ),
        ("run model.toml -o x.mcap", "This looks like a model"),
        (
            "run board.toml -o x.mcap",
            "This looks like the settings of a board",
        ),
        ("replay scenario.toml", "it is a text"),
        (
            "board --settings scenario.toml --robot 127.0.0.1:0 --can 127.0.0.1:0",
            "This looks like a scenario",
        ),
    ] {
        let run = refused(&folder, command, &[says]);
        assert!(run.stderr.contains("swapped"), "{swapped}: {}", run.stderr);
    }
    // What is only misspelt is no other kind.
    fs::write(
        folder.join("typo.toml"),
        SCENARIO.replace("[rig.robot.actuator]", "[colour]"),
    )
    .unwrap();
    let run = refused(
        &folder,
        "run typo.toml -o x.mcap",
        &["unknown key `colour`"],
    );
    assert!(!run.stderr.contains("looks like"), "{}", run.stderr);
}

#[test]
fn an_ending_that_promises_another_format_is_refused() {
    let folder = folder("rough_endings");
    refused(
        &folder,
        "compare model.toml run.mcap --series r.xlsx",
        &["written as .csv, .parquet or .mcap"],
    );
    refused(
        &folder,
        "run scenario.toml -o run.csv",
        &["name it run.mcap", "softdock export"],
    );
    let says = ["exported as .csv (a table) or .mcap (for viewers)"];
    refused(&folder, "export run.mcap -o r.pdf", &says);
    assert!(!folder.join("r.pdf").exists() && !folder.join("run.csv").exists());
}

#[test]
fn a_table_that_is_not_there_is_named() {
    let folder = folder("rough_missing");
    let says = [
        "none.csv: no such file or folder",
        "`softdock export`",
        "--mapping",
    ];
    refused(&folder, "import none.csv -o out", &says);
    refused(
        &folder,
        "import none.csv --mapping model.toml -o out",
        &says,
    );
}

#[test]
fn a_table_of_another_program_needs_a_mapping() {
    let folder = scratch("rough_no_mapping");
    fs::write(folder.join("kin.csv"), "time,fx\n0,1\n").unwrap();
    let error = softdock(&folder, &words("import kin.csv -o out")).stderr;
    assert!(
        error.contains("kin.csv: say with --mapping FILE.toml") && !error.contains("cannot read"),
        "{error}"
    );
}

/// One number has one name, and a law that fails has its reason.
#[test]
fn a_check_gives_reasons() {
    let folder = scratch("rough_reasons");
    done(&folder, &["init", "."]);
    let run = softdock(&folder, &["check", "board.toml", "rig.toml"]);
    for says in [
        "loop delay, ms",
        "believe in a loop delay of 34.00 ms; with this robot it is 20.00 ms, of which 18.00 ms are the robot's",
        "With law `predictor` the test ends in a fault: misfit of the robot's motion to `delay.actuator`",
    ] {
        assert!(
            run.stdout.contains(says),
            "expected `{says}` in {}",
            run.stdout
        );
    }
}

#[test]
fn a_port_needs_no_scheme() {
    let folder = scratch("rough_ports");
    for port in ["127.0.0.1:1", "localhost:1", "tcp:127.0.0.1:1"] {
        refused(
            &folder,
            &format!("params status --port {port}"),
            &["does the board run with --service"],
        );
    }
}

#[test]
fn commands_without_input_say_what_they_can_take() {
    let folder = scratch("rough_nothing");
    refused(
        &folder,
        "doctor",
        &["--port /dev/ttyACM0", "RUN.mcap", "--settings BOARD.toml"],
    );
    refused(
        &folder,
        "calibrate sensor",
        &["--port", "--recording", "--plan"],
    );
    refused(
        &folder,
        "identify actuator",
        &["--port", "--recording", "--rehearse"],
    );
}

#[test]
fn an_error_is_json_where_json_was_asked_for() {
    let folder = folder("rough_json");
    let error = |arguments: &[&str]| -> String {
        let run = softdock(&folder, arguments);
        assert!(run.code.is_some_and(|code| code != 0));
        run.json()["error"].as_str().unwrap().to_owned()
    };
    assert!(
        error(&["compare", "nope.toml", "run.mcap", "--json"]).contains("nope.toml: no such file")
    );
    let missing = error(&["compare", "--json"]);
    assert!(
        missing.contains("<MODEL>") && !missing.starts_with("error:"),
        "{missing}"
    );
    // A result that is there is the one document.
    let bad = softdock(&folder, &words("check scenario.toml scenario.toml --json"));
    assert_eq!(bad.code, Some(1));
    assert_eq!(bad.json()["chosen_law"], "none");
    assert!(
        bad.stderr.contains("not stable on this contact"),
        "{}",
        bad.stderr
    );
}

#[test]
fn a_stable_loop_passes_the_check() {
    let folder = folder("rough_check");
    let stable = SCENARIO.replace("law = \"none\"", "law = \"predictor\"");
    fs::write(folder.join("stable.toml"), stable).unwrap();
    done(&folder, &["check", "stable.toml", "stable.toml"]);
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_named_with_the_file() {
    let folder = folder("rough_full");
    let says = ["cannot write /dev/full: the disk is full"];
    refused(&folder, "run scenario.toml -o /dev/full --force", &says);
}

#[test]
fn a_pose_at_rest_has_no_table_of_impacts() {
    let folder = folder("rough_hold");
    let hold = [
        "run",
        "scenario.toml",
        "-o",
        "hold.mcap",
        "--hold",
        "--duration-s",
        "0.2",
    ];
    let run = softdock(&folder, &hold);
    assert!(run.stdout.starts_with("50 cycles"), "{}", run.stdout);
}

#[test]
fn a_word_of_an_effects_title_is_enough_to_be_told_its_id() {
    let folder = folder("rough_words");
    for (command, says) in [
        (
            "add model.toml friction --fit run.mcap",
            "no effect `friction`",
        ),
        (
            "run scenario.toml -o x.mcap --effect friction",
            "the word is in",
        ),
    ] {
        refused(&folder, command, &[says, "`guide_coulomb`"]);
    }
}

#[test]
fn an_input_is_never_overwritten() {
    let folder = folder("rough_inputs");
    let whole = |name: &str| fs::read(folder.join(name)).unwrap();
    let before = ["run.mcap", "model.toml", "scenario.toml"].map(whole);
    for command in [
        "export run.mcap -o run.mcap --force",
        "compare model.toml run.mcap --report model.toml --force",
        "compare model.toml run.mcap --series run.mcap --force",
        "run scenario.toml -o ./scenario.toml --force",
        "diagnose model.toml run.mcap --report run.mcap --force",
        "history model.toml --report model.toml --force",
    ] {
        let run = softdock(&folder, &command.split(' ').collect::<Vec<_>>());
        assert!(run.code.is_some_and(|code| code != 0), "{command}");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("run.mcap", folder.join("link.mcap")).unwrap();
        let says = ["is read by this command", "not even with --force"];
        refused(&folder, "export run.mcap -o link.mcap --force", &says);
    }
    assert_eq!(
        before,
        ["run.mcap", "model.toml", "scenario.toml"].map(whole)
    );
}

#[test]
fn a_table_with_decimal_commas_says_which_words_the_mapping_needs() {
    let folder = scratch("rough_comma");
    fs::write(folder.join("log.csv"), "time;fx\n0,000;1,5\n0,004;1,6\n").unwrap();
    let mapping = "[time]\ncolumn = \"time\"\n[wrench]\nfx = { column = \"fx\", unit = \"N\" }\n";
    fs::write(folder.join("m.toml"), mapping).unwrap();
    let command = "import log.csv --mapping m.toml -o out";
    refused(
        &folder,
        command,
        &["delimiter = \";\"", "decimal_comma = true"],
    );
    let table = "[table]\ndelimiter = \";\"\n";
    fs::write(folder.join("m.toml"), format!("{table}{mapping}")).unwrap();
    refused(&folder, command, &["decimal_comma = true"]);
}

#[test]
fn a_recording_of_another_rig_is_said_to_be_one() {
    let folder = folder("rough_other_rig");
    let heavy = SCENARIO.replace("mass_kg = 500.0\n", "mass_kg = 900.0\n");
    fs::write(folder.join("heavy.toml"), heavy).unwrap();
    for (scenario, recording) in [("scenario.toml", "train.mcap"), ("heavy.toml", "test.mcap")] {
        let arguments = ["run", scenario, "-o", recording, "--duration-s", "1.5"];
        done(&folder, &arguments);
    }
    let run = softdock(
        &folder,
        &words("diagnose model.toml train.mcap --test test.mcap"),
    );
    let says = "test.mcap is of another rig or spacecraft than train.mcap: `control.body_k.mass_kg` is 900.0";
    assert!(run.stderr.contains(says), "{}", run.stderr);
    let leads = "The test log was recorded with mass of spacecraft K 900 kg, the training log with mass of spacecraft K 500 kg";
    assert!(run.stdout.starts_with(leads), "{}", run.stdout);
}
