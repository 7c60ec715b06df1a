use super::*;
use softdock_app::parameters;
use softdock_app::settings::BoardSettings;

/// The settings of a board as this program gets to see them.
fn listed(settings: &BoardSettings) -> Vec<Setting> {
    (0..parameters::count())
        .map(|index| parameters::with_entry(settings, index, |entry| Setting::from(entry)).unwrap())
        .collect()
}

fn example() -> BoardSettings {
    let mut settings = BoardSettings::default();
    settings.control.sensor.tool_mass_kg = 1.0 / 3.0;
    settings.control.body_q.inertia_kg_m2[2][2] = 1234.5;
    settings.control.limits.stop_on_overload = false;
    settings.rsi.robot_ip = softdock_app::settings::Text::try_from("192.168.1.10").unwrap();
    settings
}

fn error(text: &str) -> String {
    let settings = listed(&BoardSettings::default());
    parse(text, "board.toml", &settings)
        .unwrap_err()
        .to_string()
}

#[test]
fn a_dump_is_a_settings_file_and_reads_back_the_same() {
    let settings = listed(&example());
    let text = write(&settings, "a board");
    let again: BoardSettings = softdock_io::input::parse(&text, "dump").unwrap();
    assert_eq!(again, example());
    let wanted = parse(&text, "dump", &settings).unwrap();
    assert_eq!(wanted.len(), settings.len());
    for (name, value) in wanted {
        let setting = settings.iter().find(|s| s.name == name).unwrap();
        assert_eq!(setting.value, value, "{name}");
    }
    assert!(text.contains(
        "# Mass of everything beyond the sensor, kg.\n# unit kg; 0 to 2000; default 0.0\ntool_mass_kg = 0.3333333333333333\n"
    ), "{text}");
}

#[test]
fn what_the_board_does_not_have_is_named_with_line_and_suggestion() {
    let unknown = error("[control.sensor]\ntool_mas_kg = 1.0\n");
    assert!(unknown.starts_with("board.toml:2: the board has no setting `control.sensor.tool_mas_kg`; did you mean `control.sensor.tool_mass_kg`?"), "{unknown}");
    let section = error("[control.sensro]\nbias = []\n");
    assert!(
        section.contains("board.toml:1") && section.contains("[control.sensor]"),
        "{section}"
    );
    let word = error("[can]\nsensor = \"atj\"\n");
    assert!(
        word.contains("does not know `atj`; did you mean `ati`?"),
        "{word}"
    );
    for (text, says) in [
        (
            "[can]\nbase_id = 1.5\n",
            "takes a whole number, 0 to 127; found 1.5",
        ),
        (
            "[control.sensor]\nbias = [1]\n",
            "takes a list of 6 numbers; found [1]",
        ),
        ("[control]\nsensor = 3\n", "no setting `control.sensor`"),
        ("[can.sensor]\nx = 1\n", "is a setting, not a section"),
        ("[can\n", "not valid TOML"),
    ] {
        assert!(error(text).contains(says), "{}", error(text));
    }
}

#[test]
fn what_a_file_leaves_out_has_its_default_or_stays() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("board.toml");
    std::fs::write(&path, "[can]\nbase_id = 3\n").unwrap();
    let settings = listed(&example());
    let names = |wanted: &[(String, OwnedValue)]| -> Vec<String> {
        let found = super::super::differences(&settings, wanted).unwrap();
        found.into_iter().map(|d| d.name).collect()
    };
    let kept = read(&path, &settings, false).unwrap();
    assert_eq!(names(&kept), ["can.base_id"]);
    let all = read(&path, &settings, true).unwrap();
    assert_eq!(
        names(&all),
        [
            "can.base_id",
            "control.sensor.tool_mass_kg",
            "control.body_q.inertia_kg_m2",
            "control.limits.stop_on_overload",
            "rsi.robot_ip"
        ]
    );
}
