//! Model files that commands change keep everything that their author wrote.

use proptest::prelude::*;
use softdock_physics::model::edit::{ModelFile, rounded};
use softdock_physics::model::{EffectModel, HistoryStep, Model};
use softdock_tests::process::scratch;
use std::fs;
use std::path::PathBuf;

/// A file with everything that is easily lost: comments everywhere, odd spacing, an order of its
/// own, inline tables, arrays over several lines, and no newline at its end.
const BEFORE: &str = "\
# Our rig.   Do not touch!
[tool]   # the dummy
mass_kg=12.0# weighed on Monday
com_m = [
  0.1,   # from CAD
  0.0,
  0.0,
]

[actuator]
lag_s = 4e-3 # servo
transport_delay_s = 0.008

[[contact.walls]]
point_m = [0.4, 0, 0]
normal  = [-1, 0, 0]
stiffness_n_per_m = 2.0e4   # ± 50

[[effect]] # found in spring
id = 'guide_coulomb'
parameters = { force_n = 1.5 } # dry
interval_95 = { force_n = [1.4, 1.6] }

[noise]
force_n = 0.5

# Notes for the next shift:
# the cable is new";

fn file(test: &str, text: &str) -> (PathBuf, ModelFile) {
    let path = scratch(test).join("model.toml");
    fs::write(&path, text).unwrap();
    let file = ModelFile::open(&path).unwrap();
    (path, file)
}

fn effect(id: &str, name: &str, value: f64) -> EffectModel {
    EffectModel {
        id: id.to_owned(),
        parameters: [(name.to_owned(), value)].into(),
        interval_95: [(name.to_owned(), [0.5 * value, 2.0 * value])].into(),
        fitted_on: Some("train.mcap".to_owned()),
        ..EffectModel::default()
    }
}

fn step(effect: &str, train_error: f64) -> HistoryStep {
    HistoryStep {
        effect: effect.to_owned(),
        train: "train.mcap".to_owned(),
        train_error,
        test: Some("test.mcap".to_owned()),
        test_error: Some(2.0 * train_error),
    }
}

#[test]
fn only_what_changed_is_changed() {
    let (path, file) = file("edit_golden", BEFORE);
    let mut after = file.model().clone();
    after.tool.mass_kg = 12.01;
    after.tool.com_m[1] = -2.5e-5;
    after.contact.walls[0].stiffness_n_per_m = 20_010.5;
    after.effects[0]
        .parameters
        .insert("force_n".to_owned(), 1.512);
    after.effects[0]
        .interval_95
        .insert("force_n".to_owned(), [1.5, 1.525]);
    after
        .effects
        .push(effect("ft_latency", "latency_s", 0.0012));
    after.sensor.bias[0] = 0.25;
    after.history.push(step("nominal", 9.0));
    after.history.push(step("ft_latency", 1.25));
    let edited = file.edited(&after).unwrap();
    let expected = "\
# Our rig.   Do not touch!
[tool]   # the dummy
mass_kg=12.01# weighed on Monday
com_m = [
  0.1,   # from CAD
  -2.5e-5,
  0.0,
]

[actuator]
lag_s = 4e-3 # servo
transport_delay_s = 0.008

[[contact.walls]]
point_m = [0.4, 0, 0]
normal  = [-1, 0, 0]
stiffness_n_per_m = 20010.5   # ± 50

[[effect]] # found in spring
id = 'guide_coulomb'
parameters = { force_n = 1.512 } # dry
interval_95 = { force_n = [1.5, 1.525] }

[[effect]]
id = \"ft_latency\"
parameters = { latency_s = 0.0012 }
interval_95 = { latency_s = [0.0006, 0.0024] }
fitted_on = \"train.mcap\"

[noise]
force_n = 0.5

# Notes for the next shift:
# the cable is new

[sensor]
bias = [0.25, 0.0, 0.0, 0.0, 0.0, 0.0]

[[history]]
effect = \"nominal\"
train = \"train.mcap\"
train_error = 9.0
test = \"test.mcap\"
test_error = 18.0

[[history]]
effect = \"ft_latency\"
train = \"train.mcap\"
train_error = 1.25
test = \"test.mcap\"
test_error = 2.5
";
    assert_eq!(edited.text(), expected);
    assert!(edited.difference().contains("\n-mass_kg=12.0# weighed"));
    assert_eq!(fs::read_to_string(&path).unwrap(), BEFORE, "not yet saved");
    edited.save().unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), expected);
    assert_eq!(Model::load(&path).unwrap(), after);
    let names: Vec<_> = fs::read_dir(path.parent().unwrap()).unwrap().collect();
    assert_eq!(names.len(), 1, "no other file is left behind");
}

#[test]
fn a_second_step_follows_the_first() {
    let (path, file) = file("edit_twice", Model::default_toml());
    let mut once = file.model().clone();
    once.effects.push(effect("backlash", "width_m", 1e-4));
    once.history.push(step("nominal", 3.0));
    file.edited(&once).unwrap().save().unwrap();
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.starts_with(Model::default_toml()), "{text}");
    let file = ModelFile::open(&path).unwrap();
    let mut twice = once.clone();
    twice.effects.push(effect("ft_latency", "latency_s", 1e-3));
    twice.history.push(step("ft_latency", 2.0));
    let edited = file.edited(&twice).unwrap();
    let place = |part: &str| edited.text().rfind(part).unwrap();
    assert!(place("\"backlash\"") < place("id = \"ft_latency\""));
    assert!(place("id = \"ft_latency\"") < place("\"nominal\""));
    assert!(place("\"nominal\"") < place("effect = \"ft_latency\""));
}

#[test]
fn unusual_forms_stay_as_they_are() {
    let text = "effect = [ { id = \"backlash\", parameters.width_m = 1e-4 } ]\r\n\
                tool.mass_kg = 3 # kg\r\n";
    let (_, file) = file("edit_inline", text);
    let mut after = file.model().clone();
    after.tool.mass_kg = 3.5;
    after.effects[0]
        .parameters
        .insert("width_m".to_owned(), 2e-4);
    after
        .effects
        .push(effect("ft_latency", "latency_s", 0.5e-3));
    let edited = file.edited(&after).unwrap();
    assert_eq!(
        edited.text(),
        "effect = [ { id = \"backlash\", parameters.width_m = 0.0002 } , { id = \"ft_latency\", \
         parameters = { latency_s = 0.0005 }, interval_95 = { latency_s = [0.00025, 0.001] }, \
         fitted_on = \"train.mcap\" }]\r\ntool.mass_kg = 3.5 # kg\r\n"
    );
}

#[test]
fn nothing_is_written_that_could_not_be_read() {
    let (path, file) = file("edit_refused", BEFORE);
    let mut after = file.model().clone();
    after
        .effects
        .push(effect("guide_viscous", "damping_n_s_per_m", -3.0));
    let error = format!("{:#}", file.edited(&after).unwrap_err());
    assert!(error.contains("`damping_n_s_per_m` is -3"), "{error}");
    let edited = file.edited(file.model()).unwrap();
    assert_eq!(edited.text(), BEFORE, "no change, no other text");
    // Somebody saves the file in an editor while the fit runs.
    fs::write(&path, "[tool]\nmass_kg = 1.0\n").unwrap();
    let error = edited.save().unwrap_err().to_string();
    assert!(error.contains("changed by another program"), "{error}");
    assert_eq!(
        fs::read_to_string(&path).unwrap(),
        "[tool]\nmass_kg = 1.0\n"
    );
}

proptest! {
    /// Whatever a fit finds, the file says it, and every comment is still there.
    #[test]
    fn any_fit_is_carried_over(
        force in 0.0..100.0_f64,
        mass in 0.1..500.0_f64,
        com in prop::array::uniform3(-1.0..1.0_f64),
        error in 1e-3..1e6_f64,
    ) {
        let path = scratch("edit_any").join("model.toml");
        fs::write(&path, BEFORE).unwrap();
        let file = ModelFile::open(&path).unwrap();
        let mut after = file.model().clone();
        after.effects[0].parameters.insert("force_n".to_owned(), rounded(force));
        after.tool.mass_kg = rounded(mass);
        after.tool.com_m = com.map(rounded);
        after.history.push(step("refit", rounded(error)));
        let edited = file.edited(&after).unwrap();
        prop_assert_eq!(Model::from_toml(edited.text(), "edited").unwrap(), after);
        for comment in BEFORE.lines().filter_map(|line| Some(line.split_once('#')?.1)) {
            prop_assert!(edited.text().contains(comment), "{}", comment);
        }
    }
}

/// An effect is taken out again, and every other line of the file stays.
#[test]
fn an_effect_is_removed_and_nothing_else() {
    let more = "\n\n# found on Monday\n[[effect]]\nid = \"guide_viscous\"\n\
                parameters = { damping_n_s_per_m = 3.0 }\n";
    let (_, file) = file("model_edit_remove", &format!("{BEFORE}{more}"));
    let edited = file.without_effect("guide_viscous").unwrap();
    assert!(
        !edited.text().contains("guide_viscous"),
        "{}",
        edited.text()
    );
    assert!(edited.text().contains("found in spring") && edited.text().contains("cable is new"));
    let unknown = file
        .without_effect("guide_stribeck")
        .unwrap_err()
        .to_string();
    assert!(
        unknown.contains("guide_coulomb, guide_viscous"),
        "{unknown}"
    );
}
