//! Golden error texts.

use softdock_io::input::{load, parse, refuse_overwrite};
use softdock_rig::rig::RigSettings;

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Scenario {
    rig: RigSettings,
}

/// The error of a scenario, as a person sees it.
fn error(text: &str) -> String {
    format!(
        "{:#}",
        parse::<Scenario>(text, "scenario.toml").unwrap_err()
    )
}

const WALL: &str = "[[rig.mechanism.walls]]\npoint_m = [0, 0, 0]\nnormal = [1, 0, 0]\n";

#[test]
fn a_right_scenario_is_read() {
    let text = format!(
        "{WALL}stiffness_n_per_m = 3e4\n[rig.robot]\nactuator.delay_s = 0\ncorrection = 'absolute'\n"
    );
    let rig = parse::<Scenario>(&text, "scenario.toml").unwrap().rig;
    assert_eq!(rig.mechanism.walls[0].stiffness_n_per_m, 3e4);
    assert_eq!(rig.robot.actuator.delay_s, 0.0);
    rig.validate().unwrap();
}

#[test]
fn a_wrong_unit_is_told_with_the_right_name() {
    assert_eq!(
        error(&format!("# a spring\n\n{WALL}stiffness_n_per_mm = 30.0 # stiff\n")),
        "scenario.toml:6: unknown key `stiffness_n_per_mm` in [[rig.mechanism.walls]]; did you mean `stiffness_n_per_m`?
  6 | stiffness_n_per_mm = 30.0 # stiff
The unit is part of the name: convert the value too."
    );
    // by spelling `lag_s` and `delay_s` are as near, by stem only one is
    assert_eq!(
        error("[rig.robot]\nactuator = { lag_ms = 3 }\n"),
        "scenario.toml:2: unknown key `lag_ms` in [rig.robot.actuator]; did you mean `lag_s`?
  2 | actuator = { lag_ms = 3 }
The unit is part of the name: convert the value too."
    );
}

#[test]
fn a_wrong_key_or_section_is_told_with_what_is_known() {
    assert_eq!(
        error("[rig.robto]\nhold_on = true\n"),
        "scenario.toml:1: unknown key `robto` in [rig]; did you mean `robot`?\n  1 | [rig.robto]"
    );
    assert_eq!(
        error("[rig]\ncolour = 'red'\n"),
        "scenario.toml:2: unknown key `colour` in [rig]; known are: cycle_us, substep_us, gravity_m_s2, robot, mechanism, sensor, hidden\n  2 | colour = 'red'"
    );
    assert_eq!(
        error("seeed = 3\n[rig]\n"),
        "scenario.toml:1: unknown key `seeed` at the top level; known are: rig\n  1 | seeed = 3"
    );
    assert_eq!(
        error("[rig]\nrobot.correction = 'relativ'\n"),
        "scenario.toml:2: `correction` in [rig.robot]: unknown value `relativ`; did you mean `relative`?\n  2 | robot.correction = 'relativ'"
    );
}

#[test]
fn a_missing_key_is_told_with_its_section() {
    assert_eq!(
        error(&format!("{WALL}[rig.robot]\n")),
        "scenario.toml:1: missing key `stiffness_n_per_m` in [[rig.mechanism.walls]]\n  1 | [[rig.mechanism.walls]]"
    );
    assert_eq!(
        error("[rig.mechanism]\nwalls = [\n  { point_m = [0, 0, 0], normal = [1, 0, 0] },\n]\n"),
        "scenario.toml:3: missing key `stiffness_n_per_m` in [[rig.mechanism.walls]]\n  3 |   { point_m = [0, 0, 0], normal = [1, 0, 0] },"
    );
    assert_eq!(
        error(""),
        "scenario.toml:1: missing key `rig` at the top level"
    );
}

#[test]
fn a_wrong_type_is_told_with_what_was_expected() {
    for (text, expected) in [
        (
            "[rig.robot.actuator]\ndelay_s = '32 ms'",
            "`delay_s` in [rig.robot.actuator]: expected a number, found string \"32 ms\"",
        ),
        (
            "[rig]\ncycle_us = 4e3",
            "`cycle_us` in [rig]: expected a whole number, 0 or more, found number `4000.0`",
        ),
        (
            "[rig]\ncycle_us = -4",
            "`cycle_us` in [rig]: expected a whole number, 0 or more, found number `-4`",
        ),
        (
            "[rig.robot]\nhold_on = 1",
            "`hold_on` in [rig.robot]: expected true or false, found number `1`",
        ),
        (
            "[rig]\nsensor = 3",
            "`sensor` in [rig]: expected a section or { key = value }, found number `3`",
        ),
        (
            "[rig]\ngravity_m_s2 = [0, 0]",
            "`gravity_m_s2` in [rig]: invalid length 2, expected an array of length 3",
        ),
    ] {
        let line = text.lines().nth(1).unwrap();
        assert_eq!(
            error(text),
            format!("scenario.toml:2: {expected}\n  2 | {line}")
        );
    }
}

#[test]
fn a_syntax_error_is_told_with_its_line() {
    assert_eq!(
        error("[rig]\ncycle_us 4000\n"),
        "scenario.toml:2: not valid TOML: key with no value, expected `=`\n  2 | cycle_us 4000"
    );
    assert_eq!(
        error("[rig]\n\ncycle_us = 1\ncycle_us = 2\n"),
        "scenario.toml:4: not valid TOML: duplicate key\n  4 | cycle_us = 2"
    );
}

#[test]
fn files_are_missed_with_advice_and_never_overwritten_unasked() {
    let folder = std::env::temp_dir().join(format!("softdock-input-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let (file, typo) = (folder.join("scenario.toml"), folder.join("scenraio.toml"));
    refuse_overwrite(&folder, false).unwrap();
    refuse_overwrite(&file, false).unwrap();
    let advice = load::<Scenario>(&file).unwrap_err().to_string();
    assert_eq!(
        advice,
        format!(
            "{}: no such file; give the path of an existing TOML file",
            file.display()
        )
    );
    std::fs::write(&file, "[rig]\n").unwrap();
    load::<Scenario>(&file).unwrap();
    let advice = load::<Scenario>(&typo).unwrap_err().to_string();
    assert_eq!(
        advice,
        format!(
            "{}: no such file; did you mean {}?",
            typo.display(),
            file.display()
        )
    );
    for path in [&file, &folder] {
        let refusal = refuse_overwrite(path, false).unwrap_err().to_string();
        let expected = "exists already and is not overwritten: choose another name, or say --force";
        assert_eq!(refusal, format!("{} {expected}", path.display()));
        refuse_overwrite(path, true).unwrap();
    }
    std::fs::write(&file, [0xff, 0xfe]).unwrap();
    let advice = load::<Scenario>(&file).unwrap_err().to_string();
    assert_eq!(
        advice,
        format!(
            "{}: not a text file (expected TOML in UTF-8)",
            file.display()
        )
    );
    let nowhere = load::<Scenario>(&folder.join("no/where.toml"))
        .unwrap_err()
        .to_string();
    assert!(nowhere.contains("there is no folder"), "{nowhere}");
    std::fs::remove_dir_all(&folder).unwrap();
}
