//! The motion of one axis, simulated forward from its force: what is made by an equation moves by it.

use softdock_analysis::compare::{FreeSimulation, compare};
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use softdock_tests::one_axis::OneAxis;

/// An axis that swings with this size (m or rad) and rate (rad/s), driven by `force`.
fn log(turns: bool, swing: (f64, f64), force: impl FnMut([f64; 3]) -> f64) -> Recording {
    let axis = OneAxis {
        cycle_s: 0.002,
        turns,
        swings: [swing, (0.0, 0.0), (0.0, 0.0)],
        noise: (0.0, 0.0),
        late_s: 0.0,
    };
    axis.record(4.0, 0.0, 1, force)
}

/// The model of an axis that carries this and has these effects with their parameters.
fn model(axis: &str, tool: &str, effects: &[(&str, &str)]) -> Model {
    let effects = effects.iter().map(|(id, parameters)| {
        format!("[[effect]]\nid = \"{id}\"\nparameters = {{ {parameters} }}\n")
    });
    let text = format!(
        "[rig]\nactive_axes = [\"{axis}\"]\n[tool]\ndynamic_compensation = true\n{tool}\n\
         [sensor]\nwrench = \"commanded\"\ngravity_m_s2 = [0.0, 0.0, 0.0]\n{}",
        effects.collect::<String>()
    );
    Model::from_toml(&text, "model.toml").unwrap()
}

const TOOL: &str = "mass_kg = 2.0\ninertia_kg_m2 = [[0.5, 0, 0], [0, 0.5, 0], [0, 0, 0.5]]";

fn simulated(model: &Model, log: &Recording) -> FreeSimulation {
    compare(model, log).unwrap().free_simulation.unwrap()
}

/// A swing is put in, the force follows from the equation; forward the swing comes out again.
#[test]
fn a_hardening_spring_with_friction_swings_as_it_was_made() {
    let effects = [
        ("guide_viscous", "damping_n_s_per_m = 5.0"),
        ("guide_coulomb", "force_n = 0.8"),
        (
            "cable_stiffness",
            "stiffness_n_per_m = 300.0, hardening_n_per_m3 = 2e5",
        ),
    ];
    let log = log(false, (0.03, 9.0), |[x, v, a]| {
        2.0 * a + 5.0 * v + 0.8 * v.signum() + 300.0 * x + 2e5 * x.powi(3)
    });
    let free = simulated(&model("x", TOOL, &effects), &log);
    assert!(free.relative < 0.02, "{free:?}");
    assert!(free.words().contains("% of its motion"), "{}", free.words());
}

/// A pendulum about a bearing, driven through its balance point.
#[test]
fn a_pendulum_turns_as_it_was_made() {
    let effects = [
        ("guide_viscous", "damping_n_m_s_per_rad = 0.3"),
        ("bearing_gravity", "sine_n_m = 6.0"),
    ];
    let log = log(true, (1.2, 4.0), |[q, v, a]| {
        0.5 * a + 0.3 * v + 6.0 * q.sin()
    });
    let free = simulated(&model("rx", TOOL, &effects), &log);
    assert!(free.relative < 0.01, "{free:?}");
}

/// What moves, known by an effect alone, of a bearing and of a guide, moves as if the model had it.
#[test]
fn an_inertia_may_be_an_effect() {
    let driven = |[q, v, a]: [f64; 3]| 0.7 * a + 0.9 * v + 6.0 * q;
    let slides = [
        ("tool_mass_error", "mass_error_kg = 0.7"),
        ("guide_viscous", "damping_n_s_per_m = 0.9"),
        ("cable_stiffness", "stiffness_n_per_m = 6.0"),
    ];
    let turns = [
        ("bearing_inertia", "inertia_error_kg_m2 = 0.7"),
        ("guide_viscous", "damping_n_m_s_per_rad = 0.9"),
        ("cable_stiffness", "stiffness_n_m_per_rad = 6.0"),
    ];
    for (axis, effects) in [("x", slides), ("rx", turns)] {
        let log = log(axis == "rx", (0.3, 4.0), driven);
        let free = simulated(&model(axis, "", &effects), &log);
        assert!(free.relative < 0.01, "{axis}: {free:?}");
    }
}

/// A small constant force adds up where nothing pulls back, and swings around where a spring does.
#[test]
fn without_a_spring_a_simulation_drifts() {
    let off = |[_, v, a]: [f64; 3]| 2.0 * a + 0.1 * v + 0.3;
    let free = simulated(
        &model("x", TOOL, &[("guide_viscous", "damping_n_s_per_m = 0.1")]),
        &log(false, (0.03, 9.0), off),
    );
    assert!(free.drifts && free.relative > 1.0, "{free:?}");
    assert!(free.words().contains("It drifts"), "{}", free.words());
    let spring = ("cable_stiffness", "stiffness_n_per_m = 300.0");
    let held = log(false, (0.03, 9.0), |[x, v, a]| off([x, v, a]) + 300.0 * x);
    let free = simulated(&model("x", TOOL, &[spring]), &held);
    assert!(!free.words().contains("It drifts"), "{}", free.words());
}

/// Less than the dry friction does not move what rests, and more does.
#[test]
fn what_sticks_stays() {
    let stuck = model("x", TOOL, &[("guide_coulomb", "force_n = 3.0")]);
    let pushed = |force: f64| compare(&stuck, &log(false, (1e-9, 1.0), |_| force)).unwrap();
    assert!(pushed(2.9).free_simulation.unwrap().rms < 1e-6);
    let moved = pushed(3.5);
    assert_eq!(moved.free_simulation, None);
    let says = "the motion runs away";
    assert!(
        moved.notes.iter().any(|note| note.contains(says)),
        "{:?}",
        moved.notes
    );
}

#[test]
fn what_acts_on_the_reading_hinders_it() {
    let scaled = model("x", TOOL, &[("ft_scale", "fx = 0.1")]);
    let comparison = compare(&scaled, &log(false, (1.0, 1.0), |_| 0.0)).unwrap();
    assert_eq!(comparison.free_simulation, None);
    let notes = &comparison.notes;
    assert!(
        notes.iter().any(|note| note.contains("`ft_scale`")),
        "{notes:?}"
    );
}

/// No effect changes a velocity that the recorded positions contradict: what the model can mend comes first, however small.
#[test]
fn a_motion_that_contradicts_itself_is_told_behind_the_failures_of_the_model() {
    let mut log = log(false, (0.3, 4.0), |[_, _, a]| 2.0 * a + 0.5);
    for cycle in &mut log.cycles {
        cycle.trace.executed_velocity[0] *= 1.05;
    }
    let said = |effects: &[(&str, &str)]| {
        let mut model = model("x", TOOL, effects);
        model.noise.position_m = 1e-6;
        compare(&model, &log).unwrap().sentence
    };
    let (wrench, motion) = (
        "The model fails in wrench x",
        "Position and velocity of the log contradict each other in x",
    );
    let missing = said(&[]);
    assert!(missing.starts_with(wrench), "{missing}");
    assert!(missing.contains("It also fails in pose x"), "{missing}");
    let whole = said(&[
        ("ft_bias", "fx_n = -0.5"),
        ("tool_mass_error", "mass_error_kg = -0.0952"),
    ]);
    assert!(whole.starts_with(motion), "{whole}");
}
