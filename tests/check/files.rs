//! Files in, numbers out, and what is refused.

use softdock_app::settings::BoardSettings;
use softdock_experiments::check::{Rig, check, load_board};
use std::path::{Path, PathBuf};

fn scenarios() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../host-tools/scenarios")
}

fn written(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("rig.toml");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn a_scenario_serves_as_both() {
    let path = scenarios().join("spring-rod.toml");
    let board = load_board(&path).unwrap();
    let rig = Rig::load(&path, &board).unwrap();
    assert_eq!(rig.contact.mass_kg, 500.0);
    assert_eq!(rig.approach_speed_m_s, 0.005);
    let answer = check(&board, &rig).unwrap();
    let none = &answer.laws[0];
    assert_eq!((none.law, none.stable), ("none", false));
    assert!(
        (none.expected_restitution.unwrap() - 2.83).abs() < 0.03,
        "{none:?}"
    );
    assert_eq!(answer.critical_delay_s, 0.0);
    assert!((answer.limits.phi - 21.0 * 0.034).abs() < 1e-9);
    // The same rig from the short file.
    let short = Rig::load(&scenarios().join("rig.toml"), &board).unwrap();
    assert_eq!(short, rig);
}

#[test]
fn what_is_left_out_comes_from_the_settings() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path(), "[contact]\nstiffness_n_per_m = 1e5\n");
    let board = load_board(&scenarios().join("board.toml")).unwrap();
    let rig = Rig::load(&path, &board).unwrap();
    assert!((rig.contact.mass_kg - 400.0).abs() < 1e-9);
    assert!((rig.approach_speed_m_s - 0.002).abs() < 1e-12);
    assert_eq!(rig.actuator.delay_s, 0.032);
}

/// Settings spoiled, and what is said about it.
type Spoiled = (fn(&mut BoardSettings), &'static str);

#[test]
fn a_value_out_of_range_is_refused_with_its_range() {
    let folder = tempfile::tempdir().unwrap();
    let board = BoardSettings::default();
    let contact = "approach_speed_m_s = 0.005\n[contact]\nstiffness_n_per_m = 1e5\n";
    let cases = [
        (
            "[actuator]\ndelay_s = 0.4\n",
            "`actuator.delay_s` is 0.4; allowed is 0 to 0.252",
        ),
        (
            "[actuator]\nlag_s = -1\n",
            "`actuator.lag_s` is -1; allowed is 0 to 10",
        ),
        (
            "[actuator]\ndelays = 1\n",
            "unknown key `delays` in [actuator]",
        ),
    ];
    for (text, expected) in cases {
        let path = written(folder.path(), &format!("{contact}{text}"));
        let error = format!("{:#}", Rig::load(&path, &board).unwrap_err());
        assert!(error.contains(expected), "{error}");
    }
    let path = written(
        folder.path(),
        "approach_speed_m_s = 9.0\n[contact]\nstiffness_n_per_m = 0\n",
    );
    let error = format!("{:#}", Rig::load(&path, &board).unwrap_err());
    assert!(
        error.contains("`contact.stiffness_n_per_m` is 0; allowed is 1 to"),
        "{error}"
    );
    let path = written(folder.path(), "[contact]\nstiffness_n_per_m = 1e5\n");
    let error = format!("{:#}", Rig::load(&path, &board).unwrap_err());
    assert!(error.contains("give `approach_speed_m_s`"), "{error}");

    let path = written(folder.path(), contact);
    let rig = Rig::load(&path, &board).unwrap();
    let spoils: [Spoiled; 3] = [
        (
            |b| b.control.delay.actuator.delay_s = 0.3,
            "`delay.actuator.delay_s` is 0.3",
        ),
        (
            |b| b.control.delay.seed.translation.b1 = 1e3,
            "`delay.seed.translation.b1` is 1000",
        ),
        (
            |b| b.control.robot.cycle_s = 1.0,
            "`robot.cycle_s` is 1; allowed is 0.001 to 0.02",
        ),
    ];
    for (spoil, expected) in spoils {
        let mut board = board.clone();
        spoil(&mut board);
        let error = format!("{:#}", check(&board, &rig).unwrap_err());
        assert!(error.contains(expected), "{error}");
    }
}

/// What the settings believe wrongly is told, and what would be better.
#[test]
fn the_advice_names_what_is_wrong() {
    let path = scenarios().join("spring-rod.toml");
    let mut board = load_board(&path).unwrap();
    let mut rig = Rig::load(&path, &board).unwrap();
    let advice = |board: &BoardSettings, rig: &Rig| check(board, rig).unwrap().advice.join("\n");
    assert!(advice(&board, &rig).contains("Law `none` adds energy"));
    rig.actuator.delay_s = 0.048;
    rig.feedback_latency_cycles = 2;
    let text = advice(&board, &rig);
    assert!(text.contains("with this robot it is 50.00 ms"), "{text}");
    assert!(
        text.contains("`delay.actuator.feedback_latency_cycles` = 2"),
        "{text}"
    );
    rig.contact.stiffness_n_per_m = 2e6;
    assert!(advice(&board, &rig).contains("No law can give"));
    board.control.limits.force_n = 10.0;
    assert!(advice(&board, &rig).contains("`limits.force_n` is 10"));
}
