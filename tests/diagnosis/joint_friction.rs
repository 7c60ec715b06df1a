//! How the dry friction of a joint turns round.

use super::joint::{FRICTION, INERTIA, JOINT, MODEL, diagnosed, gear, log};
use softdock_analysis::diagnose::{Diagnosis, Verdict};
use softdock_physics::model::Model;
use softdock_tests::one_axis::OneAxis;

/// The size of a form that was chosen, as a note says it.
fn chosen(found: &Diagnosis, name: &str) -> f64 {
    let size = found.notes.iter().find_map(|note| {
        let (_, value) = note.split_once(&format!("{name} = "))?;
        let value: String = value
            .chars()
            .take_while(|c| c.is_ascii_digit() || *c == '.')
            .collect();
        value.trim_end_matches('.').parse::<f64>().ok()
    });
    size.unwrap_or_else(|| panic!("{name} of {:?}", found.notes))
}

/// A bearing with a film: the friction has its level from some speed on. The likelihood, which has the ripple of the gear to fit to,
/// does not see it.
#[test]
#[ignore = "long: one more machine to diagnose"]
fn the_friction_of_a_joint_turns_round_over_a_speed() {
    const SPEED: f64 = 0.2;
    let film = |q: f64, v: f64| FRICTION.0 * (v / v.hypot(SPEED) - v.signum()) + 0.2 * gear(q, v);
    let model = Model::from_toml(MODEL, "model.toml").unwrap();
    let (train, test) = (log(12.0, 0.0, 3, film), log(8.0, 2.0, 4, film));
    let found = diagnosed(&model, &train, &test);
    assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence);
    let speed = chosen(&found, "smoothing_speed_rad_s");
    assert!((0.5 * SPEED..2.0 * SPEED).contains(&speed), "{speed}");
}

/// Dry friction that builds up over an angle, rad, after each reversal, instead of at once: dz = (dq - z |dq|)/angle (Dahl).
fn builds_up(angle: f64) -> impl FnMut(f64, f64) -> f64 {
    let (mut share, mut last) = (0.0, None);
    move |q, v| {
        let path = q - last.replace(q).unwrap_or(q);
        let towards = path.signum();
        share = towards + (share - towards) * (-path.abs() / angle).exp();
        FRICTION.0 * (share - v.signum())
    }
}

/// A belt: 5 mrad after each reversal before the joint slides.
#[test]
#[ignore = "long: one more machine to diagnose"]
fn the_friction_of_a_joint_builds_up_over_an_angle() {
    let model = Model::from_toml(MODEL, "model.toml").unwrap();
    let train = log(12.0, 0.0, 5, builds_up(0.005));
    let test = log(8.0, 2.0, 6, builds_up(0.005));
    let found = diagnosed(&model, &train, &test);
    assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence);
    let friction = found.parameters.get("guide_coulomb");
    let friction = friction.unwrap_or_else(|| panic!("{} {:?}", found.sentence, found.parameters));
    let dry = &friction["torque_n_m"];
    assert!((dry.low..dry.high).contains(&FRICTION.0), "{dry:?}");
    let angle = chosen(&found, "presliding_rad");
    assert!((angle / 0.005 - 1.0).abs() < 0.05, "{angle}");
}

/// A hose: what is left looks like a curve that fits many mechanisms; which is said, and how to add it.
#[test]
#[ignore = "long: a hose on a joint"]
fn what_looks_like_a_hysteresis_is_said_to() {
    let model = Model::from_toml(MODEL, "model.toml").unwrap();
    let train = log(12.0, 0.0, 7, builds_up(0.04));
    let test = log(8.0, 2.0, 8, builds_up(0.04));
    let found = diagnosed(&model, &train, &test);
    let hysteresis = |id: &String| id == "guide_hysteresis";
    assert!(!found.effects.iter().any(hysteresis), "{}", found.sentence);
    // Late friction is no late command.
    let delay = |id: &String| id == "actuation_delay";
    assert!(!found.effects.iter().any(delay), "{}", found.sentence);
    assert!(
        found.looks_like.iter().any(hysteresis),
        "{}",
        found.sentence
    );
    let said = |note: &String| note.contains("add MODEL guide_hysteresis");
    assert!(found.notes.iter().any(said), "{:?}", found.notes);
}

/// A sensor that is 42 ms late reads each reversal after the joint has turned round, which a friction that builds up over an angle
/// nearly does: that alone is found at first, and beside it the sensor does not look late.
#[test]
fn a_late_sensor_is_found_where_the_reversal_that_it_moves_looks_round() {
    const LATE_S: f64 = 0.042;
    let rig = OneAxis {
        noise: (1e-7, 0.01),
        late_s: -LATE_S,
        swings: [(0.3, 3.0), (0.3 / 27.0, 9.0), (0.3 / 125.0, 15.0)],
        ..JOINT
    };
    let text = MODEL
        .replace("commanded", "measured")
        .replace("0.35", "0.0")
        .replace("torque_n_m = 0.05", "torque_n_m = 0.01");
    let model = Model::from_toml(&text, "model.toml").unwrap();
    let dry = |[_, v, _]: [f64; 3]| FRICTION.0 * v.signum();
    let train = rig.record(12.0, 0.0, 9, dry);
    let test = rig.record(8.0, 2.0, 10, dry);
    let found = diagnosed(&model, &train, &test);
    assert_eq!(
        found.effects,
        ["guide_coulomb", "ft_latency"],
        "{}",
        found.sentence
    );
    for (effect, parameter, truth) in [
        ("ft_latency", "latency_s", LATE_S),
        ("guide_coulomb", "torque_n_m", FRICTION.0),
    ] {
        let said = &found.parameters[effect][parameter];
        assert!(
            (said.low..said.high).contains(&truth),
            "{parameter}: {said:?}"
        );
    }
}

/// A band brake under a sine: its friction builds up over a good part of the travel. Behind the low-pass of a sensor a sharp friction
/// looks nearly so, and laws without a low-pass do as well as with it; the curve leaves far less than both.
#[test]
#[ignore = "long: one more machine to diagnose"]
fn a_brake_that_builds_up_is_no_low_pass_of_the_sensor() {
    const SLIDES_AT_M: f64 = 0.006;
    let rig = OneAxis {
        cycle_s: 0.008,
        turns: false,
        swings: [(0.0127, 3.0), (0.0, 1.0), (0.0, 1.0)],
        noise: (1e-6, 100.0),
        late_s: 0.0,
    };
    let brake = || {
        let (mut share, mut last) = (0.0, None);
        move |[x, _, _]: [f64; 3]| {
            let path: f64 = x - last.replace(x).unwrap_or(x);
            share = path.signum() + (share - path.signum()) * (-path.abs() / SLIDES_AT_M).exp();
            13e3 * share
        }
    };
    let text = MODEL
        .replace("commanded", "measured")
        .replace(
            "inertia_kg_m2 = [[0.35, 0, 0], [0, 0, 0], [0, 0, 0]]",
            "mass_kg = 0.0",
        )
        .replace("\"rx\"", "\"x\"")
        .replace("torque_n_m = 0.05", "force_n = 100.0")
        .replace("angle_rad = 1e-7", "position_m = 1e-6");
    let model = Model::from_toml(&text, "model.toml").unwrap();
    // At another speed its lag is another time, which is no disagreement of two clocks.
    for rate in [3.3, 6.0] {
        let other = OneAxis {
            swings: [(0.0127, rate), (0.0, 1.0), (0.0, 1.0)],
            ..rig
        };
        let train = rig.record(20.0, 0.0, 11, brake());
        let test = other.record(10.0, 0.0, 12, brake());
        let found = diagnosed(&model, &train, &test);
        let curve = |id: &String| id == "guide_hysteresis";
        assert!(found.looks_like.iter().any(curve), "{}", found.sentence);
        assert_ne!(found.verdict, Verdict::LogsDisagree, "{}", found.sentence);
        let mut all = found.effects.iter().chain(&found.looks_like);
        let of_time = all.any(|id| id.starts_with("ft_") || id.starts_with("clock_"));
        assert!(!of_time, "{}", found.sentence);
    }
}

/// The clocks of one log are apart and those of the other are not, which the inertia that the model knows shows: no curve has both
/// in common.
#[test]
fn clocks_that_are_apart_in_one_log_are_a_disagreement() {
    let text = MODEL.replace("commanded", "measured");
    let model = Model::from_toml(&text, "model.toml").unwrap();
    let inertia = |[_, _, a]: [f64; 3]| 0.35 * a;
    let apart = OneAxis {
        late_s: 0.03,
        ..JOINT
    };
    let (train, test) = (
        JOINT.record(12.0, 0.0, 13, inertia),
        apart.record(8.0, 2.0, 14, inertia),
    );
    let found = diagnosed(&model, &train, &test);
    assert_eq!(found.verdict, Verdict::LogsDisagree, "{}", found.sentence);
    let about: Vec<&str> = found.disagreeing.iter().map(String::as_str).collect();
    assert_eq!(about, ["clock_offset"], "{}", found.sentence);
}

/// A dry friction and a constant are a friction of two sizes, of as many parameters; a latency beside them is neither.
#[test]
#[ignore = "long: one more machine to diagnose"]
fn an_answer_with_fewer_effects_than_the_search_had_has_its_own_ties() {
    let model = MODEL.replace("wrench = \"commanded\"", "wrench = \"measured\"");
    let model = Model::from_toml(&model.replace("0.35", "0.4"), "model.toml").unwrap();
    let late = OneAxis {
        late_s: -0.008,
        ..JOINT
    };
    let of = |seconds, phase, seed| {
        let dry = |[_, v, a]: [f64; 3]| INERTIA * a + FRICTION.0 * v.signum() + 0.2;
        late.record(seconds, phase, seed, dry)
    };
    let found = diagnosed(&model, &of(12.0, 0.0, 3), &of(8.0, 2.0, 4));
    let ties = found.runner_up.iter().chain(&found.further_ties);
    let of_latency: Vec<&String> = ties
        .filter(|tie| tie.of == "ft_latency")
        .map(|tie| &tie.effect)
        .collect();
    assert!(
        !of_latency.iter().any(|id| id.contains("guide_")),
        "{of_latency:?}"
    );
}
