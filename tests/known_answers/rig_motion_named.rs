//! Effects on motion, clock and spacecraft, hidden in the simulated rig in the sizes of the
//! demonstration: the diagnosis names each of them, or says with what it is tied.

use softdock_analysis::diagnose::{Diagnosis, Verdict, diagnose};
use softdock_experiments::diagnosis::{self, Part};
use softdock_experiments::run::record;
use softdock_io::recording::Recording;
use softdock_physics::effects::{CATALOGUE, Group};
use softdock_rig::rig::{Hidden, hidden::suggest};

/// Enough for two contacts on either side.
const DURATION_S: f64 = 6.0;

fn recorded(part: Part, hidden: &[Hidden], seed: u64) -> Recording {
    let mut scenario = diagnosis::scenario(part, hidden, seed).unwrap();
    scenario.duration_s = DURATION_S;
    record(&scenario).unwrap().0
}

fn diagnosed(hidden: &[Hidden], seed: u64) -> Diagnosis {
    let [train, test] = [Part::Train, Part::Test].map(|part| recorded(part, hidden, seed));
    let model = diagnosis::model().unwrap();
    let report = diagnose(&model, &[&train], &[&test], &|_, _| {}).unwrap();
    report.diagnosis
}

/// Whether the verdict is this effect and nothing else, or a tie with it.
fn says(diagnosis: &Diagnosis, id: &str) -> bool {
    let tied = diagnosis.runner_up.as_ref().is_some_and(|rival| {
        !rival.told_apart && rival.effect == id && diagnosis.effects == [rival.of.clone()]
    });
    diagnosis.verdict == Verdict::Named && (diagnosis.effects == [id] || tied)
}

fn are_named(ids: &[&str]) {
    let mut wrong = Vec::new();
    for id in ids {
        let hidden = suggest(id, 1).unwrap();
        let diagnosis = diagnosed(std::slice::from_ref(&hidden), 1);
        if !says(&diagnosis, id) {
            wrong.push(format!("{hidden:?}: {}", diagnosis.sentence));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn of_group(group: Group) -> Vec<&'static str> {
    let of_group = CATALOGUE.iter().filter(|effect| effect.group == group);
    of_group.map(|effect| effect.id).collect()
}

#[test]
#[ignore = "long: a diagnosis for each effect"]
fn every_effect_on_the_motion_is_named() {
    are_named(&of_group(Group::Actuator));
}

#[test]
#[ignore = "long: a diagnosis for each effect"]
fn every_effect_on_clock_and_spacecraft_is_named() {
    let mut ids = of_group(Group::Body);
    ids.push("manipulator_resistance");
    are_named(&ids);
}

#[test]
fn of_a_rig_that_hides_nothing_nothing_is_missing() {
    let diagnosis = diagnosed(&[], 1);
    assert_eq!(
        diagnosis.verdict,
        Verdict::NothingMissing,
        "{}",
        diagnosis.sentence
    );
}
