//! `softdock effects`: the list, the lesson of one effect, and its picture in a file.

use softdock_physics::effects::CATALOGUE;
use softdock_tests::process::{done, json, scratch, softdock};
use std::fs;

#[test]
fn the_list_has_every_effect_with_its_parameters() {
    let folder = scratch("cli_effects_list");
    let text = done(&folder, &["effects"]);
    let document = json(&folder, &["effects"]);
    let listed = document["effects"].as_array().unwrap();
    assert_eq!(listed.len(), CATALOGUE.len());
    for (effect, listed) in CATALOGUE.iter().zip(listed) {
        assert!(text.contains(effect.id), "{}", effect.id);
        assert_eq!(listed["id"], effect.id);
        assert_eq!(listed["parameters"][0]["name"], effect.parameters[0].name);
    }
    assert_eq!(listed[0]["group"], "actuator");
    assert_eq!(listed[0]["naming"], "cause");
}

#[test]
fn an_effect_is_taught_and_drawn() {
    let folder = scratch("cli_effects_show");
    let shown = softdock(&folder, &["effects", "show", "zero_cross_pause"]);
    assert!(shown.success, "{}", shown.stderr);
    for part in [
        "Pause at a zero crossing",
        "pause_s",
        "backlash (Backlash)",
        "⠉",
    ] {
        assert!(shown.stdout.contains(part), "{part} in\n{}", shown.stdout);
    }
    for (name, start) in [("pause.svg", "<svg"), ("pause.html", "<!DOCTYPE html>")] {
        let show = ["effects", "show", "zero_cross_pause", "--picture", name];
        assert!(softdock(&folder, &show).success);
        assert!(
            fs::read_to_string(folder.join(name))
                .unwrap()
                .starts_with(start)
        );
        let again = softdock(&folder, &show);
        assert_eq!((again.code, again.stdout.as_str()), (Some(1), ""));
        assert!(again.stderr.contains("--force"), "{}", again.stderr);
        assert!(softdock(&folder, &[&show[..], &["--force"]].concat()).success);
    }
}

#[test]
fn mistakes_get_a_suggestion() {
    let folder = scratch("cli_effects_mistakes");
    let mistyped = softdock(&folder, &["effects", "show", "guide_colomb"]);
    assert_eq!((mistyped.code, mistyped.stdout.as_str()), (Some(1), ""));
    let expected = "there is no effect `guide_colomb`; did you mean `guide_coulomb`?";
    assert!(mistyped.stderr.contains(expected), "{}", mistyped.stderr);

    for (word, expected) in [
        ("guide_colomb", expected),
        (
            "guide_coulomb",
            "`softdock effects show guide_coulomb` explains it",
        ),
    ] {
        let alone = softdock(&folder, &["effects", word]);
        assert_eq!((alone.code, alone.stdout.as_str()), (Some(1), ""));
        assert!(alone.stderr.contains(expected), "{}", alone.stderr);
    }

    let unknown = softdock(&folder, &["effects", "show", "warp"]);
    assert_eq!(unknown.code, Some(1));
    assert!(
        unknown.stderr.contains("`softdock effects` lists them"),
        "{}",
        unknown.stderr
    );

    let other = ["effects", "show", "backlash", "--picture", "backlash.pdf"];
    let refused = softdock(&folder, &other);
    assert_eq!((refused.code, refused.stdout.as_str()), (Some(1), ""));
    assert!(refused.stderr.contains(".svg"), "{}", refused.stderr);
    assert!(!folder.join("backlash.pdf").exists());
}
