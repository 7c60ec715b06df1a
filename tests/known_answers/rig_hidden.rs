//! Every effect of the catalogue, hidden in the simulated rig: the diagnosis scenario stays bounded, its recording shows
//! the effect in the channel in which it acts, and the diagnosis names those on motion, clock and spacecraft in the sizes
//! of the demonstration, or says with what they are tied.

use softdock_analysis::compare::compare;
use softdock_analysis::diagnose::{Diagnosis, Verdict, diagnose};
use softdock_control::modes::Mode;
use softdock_experiments::diagnosis::{self, Part};
use softdock_experiments::run::record;
use softdock_experiments::scenario::Scenario;
use softdock_io::recording::Recording;
use softdock_physics::effects::{CATALOGUE, Effect, Group};
use softdock_physics::model::Channel;
use softdock_rig::rig::{Hidden, hidden::suggest};

/// Largest error of a channel over its axes, in units of the noise; 1 is noise alone.
fn error(recording: &Recording, channel: Channel) -> f64 {
    let comparison = compare(&diagnosis::model().unwrap(), recording).unwrap();
    let axes = comparison.channels.iter().filter(|c| c.name == channel);
    axes.map(|c| c.rms_sigma).fold(0.0, f64::max)
}

fn run(part: Part, hidden: &[Hidden], seed: u64) -> Recording {
    recorded(&diagnosis::scenario(part, hidden, seed).unwrap())
}

fn recorded(scenario: &Scenario) -> Recording {
    let hidden = &scenario.rig.hidden;
    let (recording, _) = record(scenario).unwrap();
    let last = &recording.cycles.last().unwrap().trace;
    assert_eq!(last.mode, Mode::Running, "{hidden:?}: {:?}", last.fault);
    assert_eq!(recording.cycles.len(), scenario.cycles(), "{hidden:?}");
    recording
}

/// Where an effect shows first.
fn channel(effect: &Effect) -> Channel {
    match (effect.group, effect.id) {
        (Group::Actuator, _) | (_, "clock_jitter" | "clock_rate") => Channel::ExecutedVelocity,
        (_, "manipulator_resistance" | "sc_mass_error" | "sc_inertia_error") => {
            Channel::ModelVelocity
        }
        _ => Channel::Wrench,
    }
}

/// Nothing is hidden: what remains is noise of the data sheet's size.
#[test]
fn without_a_hidden_effect_the_model_is_right() {
    for part in [Part::Train, Part::Test] {
        let recording = run(part, &[], 7);
        for channel in [Channel::ExecutedVelocity, Channel::Wrench] {
            let z = error(&recording, channel);
            assert!((0.95..1.1).contains(&z), "{part:?} {channel:?}: {z}");
        }
        assert!(error(&recording, Channel::ModelVelocity) < 1.1, "{part:?}");
    }
}

/// The effects show with these seeds in both parts of the scenario.
fn show<'a>(effects: impl Iterator<Item = &'a Effect> + Clone, seeds: &[u64]) {
    for seed in seeds.iter().copied() {
        for part in [Part::Train, Part::Test] {
            let nominal = run(part, &[], seed);
            for effect in effects.clone() {
                let hidden = suggest(effect.id, seed).unwrap();
                let recording = run(part, std::slice::from_ref(&hidden), seed);
                let (before, after) = (
                    error(&nominal, channel(effect)),
                    error(&recording, channel(effect)),
                );
                println!(
                    "{:24} {part:?} {seed} {:?}: {before:.2} -> {after:.2}",
                    effect.id,
                    channel(effect),
                );
                assert!(
                    after > 1.2 * before.max(1.0),
                    "{hidden:?} {part:?} {seed}: {before} -> {after}"
                );
            }
        }
    }
}

fn hideable() -> impl Iterator<Item = &'static Effect> + Clone {
    let all = CATALOGUE.iter().copied();
    all.filter(|effect| !effect.is_of_a_bearing() && !effect.is_of_a_docking())
}

#[test]
fn a_sample_of_the_effects_shows() {
    show(hideable().step_by(9), &[1]);
}

#[test]
#[ignore = "long: every effect with three seeds"]
fn each_effect_shows_in_its_channel() {
    show(
        hideable().filter(|effect| !effect.is_of_a_drive()),
        &[1, 2, 3],
    );
}

/// Enough for two contacts on either side.
const DURATION_S: f64 = 6.0;

fn diagnosed(hidden: &[Hidden], seed: u64) -> Diagnosis {
    let [train, test] = [Part::Train, Part::Test].map(|part| {
        let mut scenario = diagnosis::scenario(part, hidden, seed).unwrap();
        scenario.duration_s = DURATION_S;
        recorded(&scenario)
    });
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
