//! What a `model.toml` may hold and how it is refused.

use super::*;

#[test]
fn the_commented_file_is_the_default() {
    assert_eq!(
        Model::from_toml(Model::default_toml(), "model.toml").unwrap(),
        Model::default()
    );
}

/// With all commented parts, the file has every key that a model file may have.
#[test]
fn the_commented_parts_are_valid_too() {
    let text: String = Model::default_toml()
        .lines()
        .map(|line| match line.strip_prefix("# ") {
            Some(code) if code.starts_with('[') || code.contains(" = ") => format!("{code}\n"),
            _ => format!("{line}\n"),
        })
        .collect();
    let model = Model::from_toml(&text, "model.toml").unwrap();
    assert_eq!(model.contact.walls.len(), 1);
    assert!(model.contact.guide.is_some());
    assert_eq!(model.bodies.q.fixed, Some(true));
    assert_eq!(model.effects.len(), 2);
    assert_eq!(model.hypotheses.len(), 1);
    // Docking mechanisms have their own page; one of the two effects acts on all axes.
    let said = format!("{model:?}").replace("limits: None", "");
    let said = said.replacen("axes: []", "", 1);
    let last = said.replacen("interval_95: {}, fitted_on: None", "", 1);
    assert!(!last.contains("None") && !last.contains("[]"), "{last}");
}

#[test]
fn what_is_written_is_read_back() {
    let model = Model {
        contact: ContactModel {
            walls: vec![WallModel {
                point_m: [0.1, 0.0, 0.0],
                normal: [-1.0, 0.0, 0.0],
                stiffness_n_per_m: 1e4,
                damping_n_s_per_m: 1.0,
                damping_depth_m: 0.0,
                tip_m: [0.0; 3],
            }],
            ..ContactModel::default()
        },
        bodies: TwoBodyModel {
            k: BodyModel {
                mass_kg: Some(800.0),
                ..BodyModel::default()
            },
            ..TwoBodyModel::default()
        },
        ..Model::default()
    };
    assert_eq!(
        Model::from_toml(&model.to_toml(), "model.toml").unwrap(),
        model
    );
}

#[test]
fn errors_name_field_value_and_range() {
    let wall = "[[contact.walls]]\npoint_m = [0, 0, 0]\nnormal = [1, 0, 0]\n";
    let cases = [
        (
            "[actuator]\nlag_s = -0.1",
            "`actuator.lag_s` is -0.1; allowed is 0 to 1",
        ),
        (
            "[noise]\nforce_n = 0",
            "`noise.force_n` is 0; allowed is 0.000000000001 to 10000",
        ),
        (
            &format!("{wall}stiffness_n_per_m = nan"),
            "`contact.walls[0].stiffness_n_per_m` is NaN",
        ),
        (
            &format!("{wall}stifness_n_per_m = 1.0"),
            "did you mean `stiffness_n_per_m`",
        ),
        (
            "[contact.guide]\naxis = [0, 0, 0]\nstiffness_n_per_m = 1",
            "`contact.guide.axis`",
        ),
        (
            "[tool]\nmass_kg = 1e9",
            "`tool.mass_kg` is 1000000000; allowed is 0 to 2000",
        ),
        (
            "[bodies.k]\nmass_kg = 0",
            "`bodies.k.mass_kg` is 0; allowed is 0.1 to 1000000",
        ),
        ("[actuator]\nlag = 1", "did you mean `lag_s`"),
        ("[actuator", "not valid TOML"),
    ];
    for (text, expected) in cases {
        let error = Model::from_toml(text, "model.toml")
            .unwrap_err()
            .to_string();
        assert!(error.contains(expected), "{text}\n -> {error}");
    }
}

/// A joint of 0.4 kg·m² and 2 kg at 0.3 m, 0.58 kg·m² in all: an error must leave a part of it.
#[test]
fn an_error_leaves_something_of_what_it_is_an_error_of() {
    let joint = Model::from_toml(
        "[rig]\nactive_axes = [\"rz\"]\n[tool]\nmass_kg = 2.0\ncom_m = [0.3, 0.0, 0.1]\n\
         inertia_kg_m2 = [[0, 0, 0], [0, 0, 0], [0, 0, 0.4]]\n",
        "model.toml",
    )
    .unwrap();
    let refused = |id: &str, parameter: &str, value: f64| {
        let effect = load::effects::LoadEffect::find(&joint, id).unwrap();
        effect.is_implausible(&joint, parameter, value)
    };
    let inertia = |value| refused("bearing_inertia", "inertia_error_kg_m2", value);
    assert_eq!([-0.58, -0.57, 3.0].map(inertia), [true, false, false]);
    let mass = |value| refused("tool_mass_error", "mass_error_kg", value);
    assert_eq!([-16.4, -1.9, 5.0].map(mass), [true, false, false]);
}
