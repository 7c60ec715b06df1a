//! Docking mechanisms as nominal model and as hypotheses, on recordings of the simulated rig.

use softdock_analysis::compare::compare;
use softdock_analysis::diagnose::{Verdict, diagnose};
use softdock_analysis::fit::refit;
use softdock_experiments::run::record;
use softdock_experiments::scenario::Scenario;
use softdock_io::input;
use softdock_io::recording::Recording;
use softdock_physics::effects::by_id;
use softdock_physics::model::{Channel, Model};
use softdock_rig::rig::Hidden;

const PROBE: &str = include_str!("../../host-tools/scenarios/probe-drogue.toml");
const PROBE_MODEL: &str = include_str!("../../host-tools/scenarios/probe-drogue.model.toml");
const RING: &str = include_str!("../../host-tools/scenarios/soft-capture.toml");
const RING_MODEL: &str = include_str!("../../host-tools/scenarios/soft-capture.model.toml");

fn scenario(text: &str) -> Scenario {
    input::parse(text, "scenario").unwrap()
}

fn model(text: &str) -> Model {
    Model::from_toml(text, "model").unwrap()
}

/// Largest error of the wrench over its axes, in units of the data sheet's noise.
fn error(model: &Model, recording: &Recording) -> f64 {
    let comparison = compare(model, recording).unwrap();
    let wrench = comparison
        .channels
        .iter()
        .filter(|c| c.name == Channel::Wrench);
    wrench.map(|c| c.rms_sigma).fold(0.0, f64::max)
}

/// The mechanism's memory follows the recorded way: what is left is noise, up to the instant of the capture.
#[test]
fn probe_and_ring_are_predicted_to_their_noise() {
    for (scenario_text, model_text, limit) in [(PROBE, PROBE_MODEL, 1.2), (RING, RING_MODEL, 1.3)] {
        let (recording, _) = record(&scenario(scenario_text)).unwrap();
        let right = model(model_text);
        let left = error(&right, &recording);
        assert!((0.7..limit).contains(&left), "{left}");
        let mut without = right.clone();
        without.contact.docking.clear();
        let left = error(&without, &recording);
        assert!(left > 10.0, "{left}");
    }
}

/// The scenario, maybe with another friction, and an unseen run of another approach.
fn runs(friction_error: Option<f64>) -> [Recording; 2] {
    let hidden = friction_error.map(|error| Hidden {
        id: "docking_friction".to_owned(),
        parameters: [("friction_error".to_owned(), error)].into(),
    });
    [([0.06, 0.0, 0.0], 1), ([0.05, 0.0, 0.01], 2)].map(|(velocity_m_s, seed)| {
        let mut scenario = scenario(PROBE);
        // Two contacts.
        scenario.duration_s = 5.0;
        scenario.seed = seed;
        scenario.board.control.body_k.velocity_m_s = velocity_m_s;
        scenario.rig.hidden.extend(hidden.clone());
        record(&scenario).unwrap().0
    })
}

#[test]
#[ignore = "long: one more machine to diagnose"]
fn a_rough_cone_is_named_and_measured() {
    let [train, test] = runs(Some(0.1));
    let found = diagnose(&model(PROBE_MODEL), &[&train], &[&test], &|_, _| {})
        .unwrap()
        .diagnosis;
    assert_eq!(found.verdict, Verdict::Named);
    assert_eq!(found.effects[0], "docking_friction");
    let friction = &found.parameters["docking_friction"]["friction_error"];
    assert!((friction.value - 0.1).abs() < 0.005, "{}", friction.value);
    assert!(found.residual_rms_sigma.after.wrench < 1.1);
}

/// Numbers of the mechanism are nominal parameters: a fit moves them within their tolerance.
#[test]
fn a_fit_moves_the_numbers_of_the_mechanism() {
    let [mut train, _] = runs(None);
    // The first contact.
    train.cycles.truncate(800);
    let mut soft = model(PROBE_MODEL);
    let text = PROBE_MODEL.replace("stiffness_n_per_m = 20000.0", "stiffness_n_per_m = 20300.0");
    soft.contact = model(&text).contact;
    let fitted = refit(&soft, &[&train], &|_, _| {}).unwrap();
    let name = "contact.docking[0].kind.probe_cone.surface.stiffness_n_per_m";
    let stiffness = fitted.parameters.iter().find(|p| p.name == name).unwrap();
    assert!((stiffness.value - 20_000.0).abs() < 60.0, "{stiffness:?}");
}

#[test]
fn a_hidden_effect_needs_the_mechanism_that_it_changes() {
    let mut ring = scenario(PROBE);
    ring.rig.hidden.push(Hidden {
        id: "docking_leg".to_owned(),
        parameters: [("stiffness_share".to_owned(), -0.5)].into(),
    });
    let said = format!("{:#}", ring.validate().unwrap_err());
    assert!(
        said.contains("it needs a [[rig.mechanism.docking]] that has it"),
        "{said}"
    );
    assert!(by_id("docking_leg").unwrap().is_of_a_docking());
}
