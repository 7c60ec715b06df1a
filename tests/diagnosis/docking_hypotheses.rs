//! Latches and legs of a docking mechanism that are not what the model says, hidden in the rig and named.
//!
//! What latches do shows from the instant at which they hold: the logs begin in the socket, or end in it. A log in which
//! nothing is caught says nothing of latches.

use softdock_analysis::diagnose::{Report, Verdict, diagnose};
use softdock_experiments::run::record;
use softdock_experiments::scenario::Scenario;
use softdock_io::input;
use softdock_physics::model::Model;
use softdock_rig::rig::Hidden;

const PROBE: &str = include_str!("../../host-tools/scenarios/probe-drogue.toml");
const PROBE_MODEL: &str = include_str!("../../host-tools/scenarios/probe-drogue.model.toml");
const RING: &str = include_str!("../../host-tools/scenarios/soft-capture.toml");
const RING_MODEL: &str = include_str!("../../host-tools/scenarios/soft-capture.model.toml");

/// A test that is not the scenario's own.
struct Bench {
    scenario: String,
    model: String,
    duration_s: f64,
    /// Velocities of the vehicle for the fit and for unseen data, m/s.
    velocities_m_s: [[f64; 3]; 2],
    /// The loop stays closed on the latches; else the board stops at capture.
    runs_on: bool,
}

impl Bench {
    /// Scenario and model with the same replacements.
    fn new(texts: [&str; 2], replaced: &[(&str, &str)]) -> Self {
        let [scenario, model] = texts.map(|text| {
            let replace = |text: String, (from, to): &(&str, &str)| text.replace(from, to);
            replaced.iter().fold(text.to_owned(), replace)
        });
        Self {
            scenario,
            model,
            duration_s: 1.6,
            velocities_m_s: [[0.10, 0.0, 0.04], [0.09, 0.01, 0.02]],
            runs_on: true,
        }
    }

    /// An approach that ends in the socket.
    fn captured() -> Self {
        Self {
            velocities_m_s: [[0.06, 0.0, 0.0], [0.064, 0.002, 0.001]],
            runs_on: false,
            ..Self::softly("[2.45, 0.04, 0.9]")
        }
    }

    /// The head in the socket from the start.
    fn latched() -> Self {
        Self {
            velocities_m_s: [[-0.03, 0.0, 0.01], [-0.01, 0.04, 0.01]],
            ..Self::softly("[2.303, 0.1, 0.9]")
        }
    }

    /// Latches so soft and damped that the loop may stay closed, with the drogue at a place.
    fn softly(drogue: &str) -> Self {
        let replaced = [
            ("[2.45, 0.04, 0.9]", drogue),
            (
                "latch_stiffness_n_per_m = 50000.0",
                "latch_stiffness_n_per_m = 2000.0",
            ),
            (
                "latch_damping_n_s_per_m = 500.0",
                "latch_damping_n_s_per_m = 250.0",
            ),
            ("law = \"none\"", "law = \"lead\""),
        ];
        Self {
            duration_s: 6.0,
            ..Self::new([PROBE, PROBE_MODEL], &replaced)
        }
    }

    /// Diagnoses runs in which an effect is hidden.
    fn diagnose(&self, id: &str, parameters: &[(&str, f64)]) -> Report {
        let hidden = Hidden {
            id: id.to_owned(),
            parameters: parameters
                .iter()
                .map(|(name, value)| ((*name).to_owned(), *value))
                .collect(),
        };
        let [train, test] = [0, 1].map(|run: usize| {
            let mut scenario: Scenario = input::parse(&self.scenario, "scenario").unwrap();
            scenario.duration_s = self.duration_s;
            scenario.seed = run as u64 + 1;
            scenario.board.control.body_k.velocity_m_s = self.velocities_m_s[run];
            scenario.rig.mechanism.runs_on_after_capture = self.runs_on;
            scenario.rig.hidden.push(hidden.clone());
            record(&scenario).unwrap().0
        });
        let model = Model::from_toml(&self.model, "model").unwrap();
        diagnose(&model, &[&train], &[&test], &|_, _| {}).unwrap()
    }
}

/// The effect is the first that is named; the value of its parameter.
fn named(report: &Report, id: &str, parameter: &str) -> f64 {
    let found = &report.diagnosis;
    assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence);
    assert_eq!(found.effects[0], id, "{}", found.sentence);
    found.parameters[id][parameter].value
}

/// Latches that hold from the start. χ² has steps as the end of the play passes rows: no value on a step is better than
/// another, and the interval says so.
fn a_play_is_named(play_m: f64) {
    let report = Bench::latched().diagnose("docking_latch_play", &[("play_m", play_m)]);
    let found = named(&report, "docking_latch_play", "play_m");
    assert!((found / play_m - 1.0).abs() < 0.01, "{found}");
    let said = &report.diagnosis.parameters["docking_latch_play"]["play_m"];
    assert!(said.low < play_m && play_m < said.high, "{said:?}");
}

/// The place where they caught is between two rows: 15 µm of it, and it is no matter on latches as soft as these.
fn an_approach_names(id: &str, parameter: &str, hidden: f64, share: f64) {
    let report = Bench::captured().diagnose(id, &[(parameter, hidden)]);
    let value = named(&report, id, parameter);
    assert!((value / hidden - 1.0).abs() < share, "{id}: {value}");
    let said = &report.diagnosis.parameters[id][parameter];
    assert!(said.low < hidden && hidden < said.high, "{id}: {said:?}");
}

#[test]
#[ignore = "long: a play of latches that hold from the start"]
fn a_play_of_the_latches_is_named() {
    a_play_is_named(0.001);
}

#[test]
fn an_approach_that_ends_in_the_socket_names_them_too() {
    an_approach_names("docking_latch_slip", "force_n", 8.0, 0.01);
}

#[test]
#[ignore = "long: three more diagnoses of latches"]
fn latches_are_named_from_either_beginning() {
    a_play_is_named(0.002);
    an_approach_names("docking_latch_play", "play_m", 0.002, 0.02);
    let report = Bench::latched().diagnose("docking_latch_slip", &[("force_n", 20.0)]);
    let force_n = named(&report, "docking_latch_slip", "force_n");
    assert!((force_n - 20.0).abs() < 0.1, "{force_n}");
    assert!(report.diagnosis.residual_rms_sigma.after.wrench < 1.1);
}

#[test]
#[ignore = "long: a ring without mass has many steps, for minutes"]
fn a_soft_leg_is_named_by_its_number() {
    // Nearer, so that the petals meet the ring at once.
    let bench = Bench::new([RING, RING_MODEL], &[("[3.4451,", "[3.2951,")]);
    let report = bench.diagnose("docking_leg", &[("stiffness_share", -0.5), ("leg", 3.0)]);
    let share = named(&report, "docking_leg", "stiffness_share");
    assert!((share + 0.5).abs() < 0.01, "{share}");
    let notes = &report.diagnosis.notes;
    let said = "Of `docking_leg` these logs choose leg = 3.";
    assert!(notes.iter().any(|note| note == said), "{notes:?}");
}
