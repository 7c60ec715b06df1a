//! An axis of which only the drive's current is recorded, scaled by a guess.

use super::joint::{logs, named};
use super::tables::{imported, started, table};
use softdock_analysis::add::add_effects;
use softdock_analysis::diagnose::{Verdict, diagnose};
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use softdock_statistics::RandomStream;
use softdock_tests::one_axis::OneAxis;

/// Mass, kg, and spring, N/m: known.
const KNOWN: (f64, f64) = (20.0, 1500.0);
/// Dry and viscous friction, N and N·s/m.
const FRICTION: (f64, f64) = (6.0, 40.0);
/// The motor gives 16 N/A where the mapping's scale says 25.
const SURPLUS: f64 = 25.0 / 16.0 - 1.0;

const MODEL: &str = r#"
[rig]
active_axes = ["x"]
[tool]
mass_kg = 20.0
dynamic_compensation = true
[sensor]
wrench = "unscaled"
gravity_m_s2 = [0.0, 0.0, 0.0]
[noise]
force_n = 0.5
position_m = 1e-8
[[effect]]
id = "cable_stiffness"
parameters = { stiffness_n_per_m = 1500.0 }
"#;

fn log(seconds: f64, phase: f64, seed: u64) -> Recording {
    let swings = [(0.05, 1.7), (0.02, 4.1), (0.005, 11.0)];
    let noise = (1e-8, 0.5);
    let rig = OneAxis {
        cycle_s: 0.004,
        turns: false,
        swings,
        noise,
        late_s: 0.0,
    };
    rig.record(seconds, phase, seed, |[x, v, a]| {
        let friction = FRICTION.0 * v.signum() + FRICTION.1 * v;
        (1.0 + SURPLUS) * (KNOWN.0 * a + KNOWN.1 * x + friction)
    })
}

/// Friction is what it is in newtons, not what it is on the wrong scale.
#[test]
fn a_guessed_scale_of_the_current_is_found_beside_friction() {
    let model = Model::from_toml(MODEL, "model.toml").unwrap();
    let (train, test) = (log(12.0, 0.0, 1), log(8.0, 2.0, 2));
    let found = diagnose(&model, &[&train], &[&test], &|_, _| {}).unwrap();
    let found = found.diagnosis;
    assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence);
    let mut named = found.effects.clone();
    named.sort();
    let expected = ["guide_coulomb", "guide_viscous", "input_gain"];
    assert_eq!(named, expected, "{}", found.sentence);
    for (effect, parameter, truth) in [
        ("input_gain", "surplus", SURPLUS),
        ("guide_coulomb", "force_n", FRICTION.0),
        ("guide_viscous", "damping_n_s_per_m", FRICTION.1),
    ] {
        let said = &found.parameters[effect][parameter];
        assert!(
            (said.value - truth).abs() < 0.01 * truth,
            "{parameter}: {said:?}"
        );
    }
}

/// What moves along z is a guide as what moves along x is.
#[test]
fn a_vertical_axis_has_the_friction_of_a_level_one() {
    let model = MODEL.replace(r#"active_axes = ["x"]"#, r#"active_axes = ["z"]"#);
    let model = Model::from_toml(&model, "model.toml").unwrap();
    let upright = |mut recording: Recording| {
        for cycle in &mut recording.cycles {
            cycle.trace.pose.swap(0, 2);
            cycle.trace.executed_velocity.swap(0, 2);
            cycle.inputs.sensor.wrench.swap(0, 2);
        }
        recording
    };
    let (train, test) = (upright(log(12.0, 0.0, 1)), upright(log(8.0, 2.0, 2)));
    let found = diagnose(&model, &[&train], &[&test], &|_, _| {}).unwrap();
    let mut named = found.diagnosis.effects.clone();
    named.sort();
    let expected = ["guide_coulomb", "guide_viscous", "input_gain"];
    assert_eq!(named, expected, "{}", found.diagnosis.sentence);
}

/// A damper that softens, at speeds at which it is far from its level: it is a viscous friction, and no dry one that nobody saw.
#[test]
#[ignore = "long: one more machine to diagnose"]
fn a_damper_that_softens_is_no_dry_friction() {
    const LEVEL_N: f64 = 300.0;
    let rig = OneAxis {
        cycle_s: 0.004,
        turns: false,
        swings: [(0.002, 1.1), (0.0005, 2.9), (0.0001, 11.0)],
        noise: (1e-9, 0.2),
        late_s: 0.0,
    };
    let log = |seconds: f64, phase: f64, seed: u64| {
        rig.record(seconds, phase, seed, |[x, v, a]| {
            KNOWN.0 * a + KNOWN.1 * x + LEVEL_N * (v / 0.005).tanh()
        })
    };
    let model = MODEL.replace("\"unscaled\"", "\"measured\"");
    let model = Model::from_toml(&model.replace("0.5", "0.2"), "model.toml").unwrap();
    let (train, test) = (log(9.0, 0.0, 1), log(7.0, 2.0, 2));
    let found = diagnose(&model, &[&train], &[&test], &|_, _| {}).unwrap();
    let found = found.diagnosis;
    let named = |id: &str| found.effects.iter().any(|effect| effect == id);
    assert!(named("guide_viscous"), "{}", found.sentence);
    for parameters in found.parameters.values() {
        for (name, said) in parameters {
            let is_level = name == "force_n" && (said.value / LEVEL_N - 1.0).abs() < 0.2;
            assert!(!is_level, "{name}: {said:?}, {}", found.sentence);
        }
    }
}

/// An axis that swings by some centimetres, with a load cell of half a newton.
const SWUNG: OneAxis = OneAxis {
    cycle_s: 0.004,
    turns: false,
    swings: [(0.05, 1.7), (0.02, 4.1), (0.005, 11.0)],
    noise: (1e-8, 0.5),
    late_s: 0.0,
};

/// A magnet pulls the more, the nearer its armature is: no spring, whose stiffness cannot be negative, but it is said what it is like.
#[test]
fn what_pulls_is_like_a_spring_of_the_other_sign() {
    const STIFFNESS: f64 = -800.0;
    let log = |seconds, phase, seed| {
        SWUNG.record(seconds, phase, seed, |[x, v, a]| {
            KNOWN.0 * a + FRICTION.1 * v + STIFFNESS * x
        })
    };
    let text = MODEL.replace("unscaled", "commanded");
    let (text, _) = text.split_once("[[effect]]").unwrap();
    let model = Model::from_toml(text, "model.toml").unwrap();
    let (train, test) = (log(12.0, 0.0, 5), log(8.0, 2.0, 6));
    let found = diagnose(&model, &[&train], &[&test], &|_, _| {}).unwrap();
    let found = found.diagnosis;
    assert_eq!(found.verdict, Verdict::Unexplained, "{}", found.sentence);
    let said = &found.remainder.follows;
    let value = said.split_once("like cable_stiffness with stiffness_n_per_m = ");
    let value = value.and_then(|(_, value)| value.split(' ').next()?.parse::<f64>().ok());
    let stiffness = value.unwrap_or_else(|| panic!("{said}"));
    assert!((stiffness / STIFFNESS - 1.0).abs() < 0.01, "{said}");
}

/// A duty cycle without its sign, of a motor that has little but back-EMF: forward it brakes, and backward it drives. Half of the
/// sum of both slopes is a viscous friction and half of their difference another one, which together are none.
#[test]
#[ignore = "long: one more machine to diagnose"]
fn what_would_drive_in_one_direction_is_no_friction() {
    const BACK_EMF: f64 = 300.0;
    let log = |seconds, phase, seed| {
        SWUNG.record(seconds, phase, seed, |[_, v, a]| {
            KNOWN.0 * a + FRICTION.1 * v + BACK_EMF * v.abs()
        })
    };
    let text = MODEL.replace("unscaled", "measured");
    let (text, _) = text.split_once("[[effect]]").unwrap();
    let model = Model::from_toml(text, "model.toml").unwrap();
    let (train, test) = (log(12.0, 0.0, 7), log(8.0, 2.0, 8));
    let found = diagnose(&model, &[&train], &[&test], &|_, _| {}).unwrap();
    let found = found.diagnosis;
    let is_named = |id: &str| found.effects.iter().any(|effect| effect == id);
    assert!(!is_named("guide_asymmetry"), "{}", found.sentence);
    assert_eq!(found.verdict, Verdict::Unexplained, "{}", found.sentence);
}

/// A torque that was measured behind a filter of 5 ms and is called the command: no command comes after the motion that it causes,
/// which is said, and what to write.
#[test]
fn what_comes_after_the_motion_was_not_told() {
    const LATE_S: f64 = 0.005;
    let late = OneAxis {
        late_s: -LATE_S,
        noise: (1e-8, 0.05),
        ..SWUNG
    };
    let force = |[_, v, a]: [f64; 3]| KNOWN.0 * a + FRICTION.1 * v;
    let text = MODEL.replace("unscaled", "commanded");
    let (text, _) = text.split_once("[[effect]]").unwrap();
    let model = Model::from_toml(text, "model.toml").unwrap();
    let (train, test) = (
        late.record(12.0, 0.0, 9, force),
        late.record(8.0, 2.0, 10, force),
    );
    let found = diagnose(&model, &[&train], &[&test], &|_, _| {}).unwrap();
    let found = found.diagnosis;
    let said = found.notes.iter().find_map(|note| {
        let (late, rest) = note
            .strip_prefix("The recorded load comes some ")?
            .split_once(" ms after")?;
        assert!(rest.contains("wrench = \"measured\""), "{rest}");
        late.parse::<f64>().ok()
    });
    let late_ms = said.unwrap_or_else(|| panic!("{} {:?}", found.sentence, found.notes));
    // A part of it is in the friction that was found.
    assert!(
        (0.5..1.1).contains(&(1e-3 * late_ms / LATE_S)),
        "{late_ms} ms"
    );
}

/// A car of 230 kg on a road that is never level, by a model that nearly knows its mass: what its dry friction explains counts,
/// although it is a constant one way.
#[test]
fn a_model_that_knows_the_mass_is_told_of_the_friction_one_way() {
    /// Size and rate of a swing so slow that the car drives on with 12 m/s.
    const ONWARDS: (f64, f64) = (1.2e5, 1e-4);
    let car = OneAxis {
        cycle_s: 0.02,
        turns: false,
        swings: [ONWARDS, (8.0, 0.3), (0.6, 1.1)],
        noise: (1e-6, 2.0),
        late_s: 0.0,
    };
    let record = |seconds: f64, phase: f64, seed: u64| {
        let (mut random, mut slope) = (RandomStream::new(seed, 7), 0.0);
        car.record(seconds, phase, seed, |[_, v, a]| {
            slope += 0.02 * (-slope + 400.0 * random.normal());
            230.0 * a + 164.0 * v.signum() + slope
        })
    };
    let (train, test) = (record(60.0, 0.0, 1), record(40.0, 9.0, 2));
    for known_kg in ["20.0", "200.0"] {
        let text = MODEL
            .replace("mass_kg = 20.0", &format!("mass_kg = {known_kg}"))
            .replace("unscaled", "commanded");
        let text = text.split("[[effect]]").next().unwrap();
        let model = Model::from_toml(text, "model.toml").unwrap();
        let found = diagnose(&model, &[&train], &[&test], &|_, _| {}).unwrap();
        let found = found.diagnosis;
        assert_eq!(
            found.verdict,
            Verdict::Named,
            "{known_kg}: {}",
            found.sentence
        );
        // One way a friction is a constant.
        let mut same = ["guide_coulomb", "guide_offset"].into_iter();
        let dry = same
            .find_map(|id| found.parameters.get(id)?.get("force_n"))
            .unwrap();
        let size = dry.value.abs() / 164.0;
        assert!((0.8..1.2).contains(&size), "{known_kg}: {dry:?}");
    }
}

/// A table of a quarter of a ton; and one so heavy that it is another unit, of which several effects that were asked for say why they
/// are not added.
#[test]
fn a_heavy_axis_has_its_mass_and_an_absurd_one_its_reason() {
    let text = MODEL
        .replace("mass_kg = 20.0", "mass_kg = 0.0")
        .replace("unscaled", "commanded");
    let text = text.split("[[effect]]").next().unwrap();
    let model = Model::from_toml(text, "model.toml").unwrap();
    let added = |mass_kg: f64| {
        let record = |seconds, phase, seed| {
            SWUNG.record(seconds, phase, seed, |[_, v, a]| {
                mass_kg * a + FRICTION.1 * v
            })
        };
        let logs = logs(record(12.0, 0.0, 1), record(8.0, 2.0, 2));
        let ids = ["tool_mass_error", "guide_viscous"].map(str::to_owned);
        add_effects(&model, &ids, &logs, false)
    };
    let (report, _) = added(250.0).unwrap();
    let mass = &report.diagnosis.parameters["tool_mass_error"]["mass_error_kg"];
    assert!((mass.low..mass.high).contains(&250.0), "{mass:?}");
    let refused = added(25_000.0).unwrap_err().to_string();
    assert!(
        refused.contains("is not plausible (-10000 to 10000 kg)"),
        "{refused}"
    );
}

/// A shaking table behind a delay of its drive: what is found first is held while the rest is found beside it, and has the amounts of
/// all together in the end.
#[test]
fn amounts_of_several_rounds_are_those_of_all_together() {
    const VISCOUS: f64 = 427.0;
    let text = MODEL
        .replace("mass_kg = 20.0", "mass_kg = 0.0")
        .replace("force_n = 0.5", "force_n = 0.03");
    let text = text.split("[[effect]]").next().unwrap();
    let model = Model::from_toml(text, "model.toml").unwrap();
    let rig = OneAxis {
        cycle_s: 0.005,
        turns: false,
        swings: [(0.005, 12.6), (0.0, 1.0), (0.0, 1.0)],
        noise: (2e-6, 3.0),
        late_s: 0.054,
    };
    let faster = OneAxis {
        swings: [(0.004, 18.8), (0.001, 56.0), (0.0, 1.0)],
        ..rig
    };
    let force = |[_, v, a]: [f64; 3]| 42.8 * (v / 0.005).tanh() + VISCOUS * v + 3.2 + 8.0 * a;
    let logs = logs(
        rig.record(20.0, 0.0, 1, force),
        faster.record(20.0, 0.0, 2, force),
    );
    let ids = [
        "guide_coulomb",
        "guide_viscous",
        "guide_offset",
        "actuation_delay",
    ];
    let (report, _) = add_effects(&model, &ids.map(str::to_owned), &logs, false).unwrap();
    let viscous = &report.diagnosis.parameters["guide_viscous"]["damping_n_s_per_m"];
    assert!(
        0.9 * VISCOUS < viscous.low && viscous.high < 1.1 * VISCOUS,
        "{viscous:?}"
    );
    assert!(
        (viscous.value / VISCOUS - 1.0).abs() < 0.2,
        "{viscous:?} {:?}",
        report.diagnosis.notes
    );
}

/// An offset that is worth less than its price in the likelihood, beside a friction: who asks for both gets both, as unseen data is
/// foretold better, and nobody one that is not there.
#[test]
fn what_foretells_unseen_data_better_is_added_to_those_who_ask_for_it() {
    let text = MODEL.split("[[effect]]").next().unwrap();
    let text = text.replace("unscaled", "commanded");
    let model = Model::from_toml(&text, "model.toml").unwrap();
    let ids = ["guide_viscous", "guide_offset"].map(str::to_owned);
    let added = |offset: f64| {
        let record = |seconds, phase, seed| {
            SWUNG.record(seconds, phase, seed, |[_, v, a]| {
                KNOWN.0 * a + FRICTION.1 * v + offset
            })
        };
        let logs = logs(record(4.0, 0.0, 1), record(3.0, 2.0, 2));
        add_effects(&model, &ids, &logs, false)
    };
    let (report, _) = added(0.14).unwrap();
    let diagnosis = &report.diagnosis;
    let by = "`guide_viscous` and `guide_offset` are fitted by least squares";
    assert!(diagnosis.sentence.starts_with(by), "{}", diagnosis.sentence);
    let offset = &diagnosis.parameters["guide_offset"]["force_n"];
    assert!((offset.low..offset.high).contains(&-0.14), "{offset:?}");
    let errors = diagnosis.steps.iter().map(|step| step.test_error.unwrap());
    assert!(errors.is_sorted_by(|before, after| before > after));
    let refused = added(0.0).unwrap_err().to_string();
    let says = "do not pay for the parameters of `guide_offset`";
    assert!(refused.contains(says), "{refused}");
}

/// A hose: what it holds builds up over more than the centimetre that a search takes. Who asks for it gets it.
#[test]
fn a_friction_that_builds_up_over_centimetres_is_fitted_beyond_the_search() {
    const OVER_M: f64 = 0.016;
    let text = MODEL.split("[[effect]]").next().unwrap();
    let text = text.replace("unscaled", "commanded");
    let model = Model::from_toml(&text, "model.toml").unwrap();
    let record = |seconds, phase, seed| {
        let (mut held, mut before) = (0.0, None);
        SWUNG.record(seconds, phase, seed, |[x, v, a]| {
            let moved = x - before.replace(x).unwrap_or(x);
            held += (moved - moved.abs() * held) / OVER_M;
            KNOWN.0 * a + FRICTION.1 * v + 30.0 * held
        })
    };
    let logs = logs(record(12.0, 0.0, 3), record(8.0, 2.0, 4));
    let ids = ["guide_viscous", "guide_hysteresis"].map(str::to_owned);
    let (report, _) = add_effects(&model, &ids, &logs, false).unwrap();
    let over = &report.diagnosis.parameters["guide_hysteresis"]["displacement_m"];
    assert!((over.low..over.high).contains(&OVER_M), "{over:?}");
    assert!(over.value > 0.0105, "{over:?}");
}

/// A motor of 0.004 kg·m² and 0.07 N·m·s/rad starts under torques that never change in their logs; the speed is a mean over 50 ms. When
/// such a torque was told nobody knows: a delay would be worth the start of each log, which it leaves unpredicted.
#[test]
fn a_command_that_never_changes_shows_no_delay() {
    let speed = |torque: f64, t: f64| {
        let (final_speed, time_constant_s) = (torque / 0.07, 0.004 / 0.07);
        let angle = |t: f64| {
            let t = t.max(0.0);
            final_speed * (t - time_constant_s * (1.0 - (-t / time_constant_s).exp()))
        };
        (angle(t) - angle(t - 0.05)) / 0.05
    };
    let step = |torque: f64, seed: u64| {
        let mut random = RandomStream::new(seed, 0);
        let noise: Vec<f64> = (0..150).map(|_| 0.02 * random.normal()).collect();
        table("t,w,u", 150, |n| {
            let t = 0.013 + n / 150.0;
            let speed = speed(torque, t) + noise[n as usize];
            format!("{t},{speed},{torque}")
        })
    };
    let torques = [1.0, -0.6, 0.2, 0.8, -0.4];
    let names = ["a.csv", "b.csv", "c.csv", "d.csv", "e.csv"];
    let files: Vec<(&str, String)> = names
        .into_iter()
        .zip(torques.map(|torque| step(torque, 7)))
        .collect();
    let mapping = r#"
        files = { train = [["a.csv"], ["b.csv"], ["c.csv"]], test = [["d.csv"], ["e.csv"]] }
        starter = { wrench = "commanded", gravity_m_s2 = [0.0, 0.0, 0.0] }
        time = { column = "t" }
        executed_velocity = { rx = { column = "w", unit = "rad/s" } }
        wrench = { tx = { column = "u", unit = "N·m", scale = -1.0 } }
        filter = { cutoff_hz = 15.0, order = 4 }
    "#;
    let logs = imported("steps_of_torque", mapping, &files).unwrap();
    let model = started(&logs);
    let [train, test]: [Vec<&Recording>; 2] =
        [&logs.train, &logs.test].map(|logs| logs.iter().collect());
    let found = diagnose(&model, &train, &test, &|_, _| {})
        .unwrap()
        .diagnosis;
    assert_eq!(
        named(&found),
        ["bearing_inertia", "guide_viscous"],
        "{}",
        found.sentence
    );
    let said = "When the load was told is not tested";
    assert!(
        found.notes.iter().any(|note| note.contains(said)),
        "{:?}",
        found.notes
    );
}
