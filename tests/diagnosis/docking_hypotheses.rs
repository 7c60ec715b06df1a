//! Latches and legs of a docking mechanism that are not what the model says, hidden in the rig and named.
//!
//! What latches do shows from the instant at which they hold: the logs begin in the socket, because the place at which
//! they catch a moving head lies between two rows of a log.

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
        }
    }

    /// The head in the socket; latches so soft and damped that the loop may stay closed.
    fn latched() -> Self {
        let replaced = [
            ("[2.45, 0.04, 0.9]", "[2.303, 0.1, 0.9]"),
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
            velocities_m_s: [[-0.03, 0.0, 0.01], [-0.01, 0.04, 0.01]],
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
            scenario.rig.mechanism.runs_on_after_capture = true;
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

#[test]
fn latches_that_slip_are_named_with_their_force() {
    let report = Bench::latched().diagnose("docking_latch_slip", &[("force_n", 20.0)]);
    let force_n = named(&report, "docking_latch_slip", "force_n");
    assert!((force_n - 20.0).abs() < 0.1, "{force_n}");
    assert!(report.diagnosis.residual_rms_sigma.after.wrench < 1.1);
}

/// The fit of a play stops a few per cent before the truth, where its error is no longer smooth.
#[test]
fn a_play_of_the_latches_is_named() {
    let report = Bench::latched().diagnose("docking_latch_play", &[("play_m", 0.002)]);
    let play_m = named(&report, "docking_latch_play", "play_m");
    assert!((play_m - 0.002).abs() < 2e-4, "{play_m}");
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
