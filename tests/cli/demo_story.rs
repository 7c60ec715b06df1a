//! `softdock demo`: what it finds, what it writes, and that it says the same again.

use softdock_physics::model::Model;
use softdock_tests::process::{demonstration, done, json, scratch, softdock, words};

/// An effect of a size that the seed draws is named, its value found and its error gone.
#[test]
fn a_hidden_effect_is_found_added_and_removed() {
    let folder = scratch("demo_found");
    let arguments = words("demo --effect guide_viscous --seed 1 -o a");
    let told = json(&folder, &arguments);
    assert_eq!(told["found"], true, "{told:#}");
    assert_eq!(told["hidden"][0]["id"], "guide_viscous");
    assert_eq!(told["diagnosis"]["verdict"], "named");
    let answer = &told["answers"][0];
    let [hidden, found] =
        [&answer["hidden"], &answer["found"]["value"]].map(|v| v.as_f64().unwrap());
    assert!((found / hidden - 1.0).abs() < 0.1, "{answer}");
    let before = Model::load(&folder.join("a/model-before.toml")).unwrap();
    let after = Model::load(&folder.join("a/model.toml")).unwrap();
    assert!(before.effects.is_empty() && before.history.is_empty());
    assert_eq!(after.effects[0].id, "guide_viscous");
    let [first, last] = [&after.history[0], &after.history[1]];
    assert!(
        last.test_error.unwrap() < 0.9 * first.test_error.unwrap(),
        "{:?}",
        after.history
    );
    for file in ["diagnose.html", "compare.html", "train.mcap", "test.mcap"] {
        assert!(folder.join("a").join(file).exists(), "{file}");
    }
    assert_eq!(told["report"], "a/diagnose.html");
    // The same seed tells the same story.
    let again = json(&folder, &[&arguments[..5], &["-o", "b"]].concat());
    assert_eq!(told["answers"], again["answers"]);
    let model = |name: &str| std::fs::read_to_string(folder.join(name).join("model.toml")).unwrap();
    assert_eq!(model("a"), model("b"));
}

/// The late robot that it hides of itself: named, and with what was found the board makes up for it.
#[test]
fn the_default_is_a_late_robot_that_pauses() {
    let (folder, told) = demonstration();
    assert_eq!(told.code, Some(0), "{}", told.stderr);
    let told = told.json();
    assert_eq!(told["found"], true, "{told:#}");
    let restitution = |step: usize| {
        told["steps"][step]["impact"]["restitution"]
            .as_f64()
            .unwrap()
    };
    assert!(restitution(0) > 2.5 && restitution(1) < 0.5 * restitution(0));
    // Told of the delay and the pause that were found, the board gives the bounce back as it is.
    assert_eq!(told["steps"][2]["law"], "predictor");
    assert!((restitution(2) - 1.0).abs() < 0.01, "{}", restitution(2));
    let board = std::fs::read_to_string(folder.join("demo/board.toml")).unwrap();
    assert!(board.contains("law = \"predictor\""), "{board}");
}

#[test]
fn the_story_tells_its_steps_and_refuses_what_it_cannot_do() {
    let folder = scratch("demo_told");
    let arguments = ["demo", "--effect", "ft_bias", "-o", "a"];
    let run = done(&folder, &arguments);
    for expected in [
        "3. Run",
        "4. Compare",
        "5. Diagnose",
        "6. ",
        "What the rig had hidden",
        "Try next",
    ] {
        assert!(run.contains(expected), "{expected} in {}", run);
    }
    softdock(&folder, &arguments).refused(&["--force"]);
    let unknown = softdock(&folder, &["demo", "--effect", "ft_bais", "-o", "c"]);
    unknown.refused(&["did you mean `ft_bias`?"]);
    assert!(
        !folder.join("c").exists(),
        "nothing is written before the effect is known"
    );
}
