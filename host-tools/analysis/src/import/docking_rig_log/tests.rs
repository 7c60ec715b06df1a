//! Tests: the model that a `meta.json` becomes, and errors for a broken folder.

use super::*;
use crate::import::model_text;
use proptest::prelude::*;
use serde_json::{Value, json};
use softdock_physics::model::{Axis, Channel, Model, ToleranceModel};

fn meta() -> Value {
    json!({
        "format": FORMAT, "case": "known", "sample_time_s": 0.002, "dof_mask": [1, 0, 0, 0, 1, 0],
        "gravity_m_s2": [0.0, 0.0, -9.81],
        "spacecraft": {"mass_kg": 500.0, "inertia_kg_m2": [[90, 0, 0], [0, 100, 0], [0, 0, 110]]},
        "tool": {"mass_kg": 3.0, "com_m": [0.1, 0.0, 0.0], "dynamic_compensation": true,
                 "inertia_kg_m2": [[0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.3]]},
        "ft_sensor": {"bias": [1, 2, 3, 0.4, 0.5, 0.6], "range_force_N": 5000},
        "geometry": {"r_tip_m": [0.4, 0, 0], "r_sensor_m": [0.08, 0, 0],
                     "sensor_rotation_M_from_S": [[0, -1, 0], [1, 0, 0], [0, 0, 1]]},
        "contact": {"law": "linear", "k_n_N_m": 12000.0, "c_n_Ns_m": 30.0, "k_t_N_m": 1200.0,
                    "c_t_Ns_m": 3.0, "delta_c_m": 0.004, "x_front_m": 0.42, "x_aft_m": 0.38},
        "actuator": {"transport_delay_s": 0.008, "lag_time_constant_s": 0.004},
        "noise_sigma": {"force_N": 0.5, "torque_Nm": 0.03, "velocity_m_s": 5e-5,
                        "rate_rad_s": 1e-4, "position_m": 5e-6, "angle_rad": 1e-5},
    })
}

const HEADER: &str = "t,mode,fx,fy,fz,tx,ty,tz,vcx,vcy,vcz,wcx,wcy,wcz,vex,vey,vez,wex,wey,wez,\
                      px,py,pz,qw,qx,qy,qz,vmx,vmy,vmz,wmx,wmy,wmz";

/// A log in which each column has a number of its own.
fn log(rows: usize) -> String {
    let mut text = format!("{HEADER}\n");
    for n in 0..rows {
        let t = n as f64 * 0.002;
        let cells: Vec<String> = (2..33)
            .map(|column| match column {
                23 => "1".to_owned(),
                20..=26 => "0".to_owned(),
                14 => format!("{}", 14.0 + 0.001 * n as f64),
                column => column.to_string(),
            })
            .collect();
        text += &format!("{t:.3},{},{}\n", u8::from(n >= 40), cells.join(","));
    }
    text
}

fn import(meta: &Value) -> anyhow::Result<ImportedLogs> {
    from_text(&meta.to_string(), &log(100), &log(120))
}

#[test]
fn each_field_has_its_place_in_the_model() {
    let model = import(&meta()).unwrap().model;
    assert_eq!(model.rig.active_axes, [Axis::X, Axis::Ry]);
    assert_eq!(
        (model.actuator.transport_delay_s, model.actuator.lag_s),
        (0.008, 0.004)
    );
    let [front, aft] = model.contact.walls.as_slice() else {
        panic!("two walls: {:?}", model.contact);
    };
    assert_eq!(
        (front.point_m, front.normal),
        ([0.42, 0.0, 0.0], [-1.0, 0.0, 0.0])
    );
    assert_eq!(
        (aft.point_m, aft.normal),
        ([0.38, 0.0, 0.0], [1.0, 0.0, 0.0])
    );
    assert_eq!(
        (front.tip_m, front.damping_depth_m),
        ([0.4, 0.0, 0.0], 0.004)
    );
    let guide = model.contact.guide.as_ref().unwrap();
    assert_eq!(
        (guide.stiffness_n_per_m, guide.damping_n_s_per_m),
        (1200.0, 3.0)
    );
    // A quarter turn about z.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
    let [w, x, y, z] = model.sensor.orientation_wxyz;
    assert!(
        near(w, half) && near(x, 0.0) && near(y, 0.0) && near(z, half),
        "{w} {z}"
    );
    assert_eq!(model.bodies.k.mass_kg, Some(500.0));
    // No tolerances are stated: nearly exact.
    let (usual, own) = (ToleranceModel::default(), &model.tolerance);
    assert!(near(own.tool_mass_kg, 0.2 * usual.tool_mass_kg), "{own:?}");
}

#[test]
fn each_column_has_its_place_in_the_recording() {
    let logs = import(&meta()).unwrap();
    assert_eq!(
        (logs.train.cycles.len(), logs.test.cycles.len()),
        (100, 120)
    );
    let cycle = &logs.train.cycles[50];
    assert_eq!(cycle.trace.mode, softdock_control::modes::Mode::Running);
    assert_eq!(cycle.trace.time_s, 0.1);
    assert_eq!(cycle.inputs.sensor.wrench, [2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    assert_eq!(
        cycle.trace.sent_velocity,
        [8.0, 9.0, 10.0, 11.0, 12.0, 13.0]
    );
    assert_eq!(
        cycle.trace.executed_velocity,
        [14.05, 15.0, 16.0, 17.0, 18.0, 19.0]
    );
    assert_eq!(cycle.trace.pose, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    assert_eq!(
        cycle.trace.model_velocity,
        [27.0, 28.0, 29.0, 30.0, 31.0, 32.0]
    );
}

#[test]
fn the_commented_text_is_the_model() {
    let mut meta = meta();
    meta["tolerance"] = json!({"contact.k_n_N_m": 45.0, "tool.inertia_kg_m2": 0.01});
    for meta in [self::meta(), meta] {
        let model = import(&meta).unwrap().model;
        let text = model_text::commented(&model, "a\ntest = 1");
        assert_eq!(
            Model::from_toml(&text, "model.toml").unwrap(),
            model,
            "{text}"
        );
    }
    let text = model_text::commented(&Model::default(), "nothing");
    assert_eq!(
        Model::from_toml(&text, "model.toml").unwrap(),
        Model::default()
    );
}

#[test]
fn a_tolerance_that_is_not_listed_is_zero() {
    let mut meta = meta();
    meta["tolerance"] = json!({
        "contact.k_n_N_m": 45.0, "tool.mass_kg": 0.01, "tool.com_m": [1e-4, 2e-4, 0.0],
        "ft_sensor.bias": [0.1, 0.2, 0.3, 0.01, 0.02, 0.03], "contact.x_front_m": 1e-5,
        "contact.delta_c_m": 1e-4,
    });
    let logs = import(&meta).unwrap();
    let t = &logs.model.tolerance;
    assert_eq!(t.wall_stiffness_n_per_m, Some(45.0));
    assert_eq!((t.tool_mass_kg, t.tool_com_m), (0.01, 2e-4));
    assert_eq!(t.bias, [0.1, 0.2, 0.3, 0.01, 0.02, 0.03]);
    assert_eq!((t.wall_position_m, t.transport_delay_s), (1e-5, 0.0));
    assert_eq!(
        (t.wall_damping_n_s_per_m, t.tool_inertia_kg_m2),
        (Some(0.0), Some(0.0))
    );
    let noted = |path: &str| logs.warnings.iter().any(|w| w.contains(path));
    assert!(
        noted("tool.com_m") && noted("contact.delta_c_m"),
        "{:?}",
        logs.warnings
    );
}

#[test]
fn what_is_not_known_is_told_and_does_no_harm() {
    let mut meta = meta();
    meta["operator"] = json!("somebody");
    meta["contact"]["preload_N"] = json!(3.0);
    let logs = import(&meta).unwrap();
    for field in ["`operator`", "`contact.preload_N`"] {
        assert!(
            logs.warnings.iter().any(|w| w.contains(field)),
            "{:?}",
            logs.warnings
        );
    }
}

/// Text that is replaced in `meta.json`, its replacement, and the expected error.
const META_MISTAKES: &[(&str, &str, &str)] = &[
    ("rig-log/1", "rig-log/9", "received `docking-rig-log/9`"),
    (",\"mass_kg\":3.0", "", "missing field `mass_kg`"),
    ("12000.0", "-1.0", "stiffness_n_per_m` is -1"),
    (
        "\"sample_time_s\":0.002",
        "\"sample_time_s\":0.004",
        "0.002000 s apart",
    ),
    ("[0,-1,0]", "[0,-2,0]", "not a rotation"),
    ("{", "", "not valid JSON"),
];

/// The same for both logs.
const LOG_MISTAKES: &[(&str, &str, &str)] = &[
    (",vmz,", ",vmZ,", "no column `vmz` (did you mean `vmZ`?)"),
    (
        "14.003",
        "n/a",
        "train.csv, line 5, column `vex`: expected a number",
    ),
    (
        "14.003",
        "",
        "line 5, column `vex`: expected a number, received an empty cell",
    ),
    (
        "14.003",
        "NaN",
        "line 5, column `vex`: expected a number, received `NaN`",
    ),
    ("14.003,", "", "line 5: expected 33 cells"),
    (
        "0.010,",
        "0.006,",
        "row 6: the time is 0.006 s after 0.008 s",
    ),
];

/// Numbers that look like millimetres: there is no mapping in which to say so.
#[test]
fn a_suspected_unit_is_a_matter_of_the_log() {
    const PX: usize = 20;
    let far = |line: &str| -> String {
        let cells = line.split(',').enumerate();
        let cells = cells.map(|(n, cell)| if n == PX && cell == "0" { "99" } else { cell });
        cells.collect::<Vec<_>>().join(",") + "\n"
    };
    let far: String = log(120).lines().map(far).collect();
    let logs = from_text(&meta().to_string(), &log(100), &far).unwrap();
    let told = logs.warnings.iter().find(|told| told.contains("in mm?"));
    let told = told.expect("a position of 99 m is told");
    assert!(
        told.ends_with("has no mapping and is in SI: change the log)"),
        "{told}"
    );
}

#[test]
fn errors_say_where_and_what() {
    let (json, log) = (meta().to_string(), log(100));
    let check = |json: &str, log: &str, expected: &str| {
        let Err(error) = from_text(json, log, log) else {
            panic!("not refused: {expected}");
        };
        let error = format!("{error:#}");
        assert!(error.contains(expected), "expected {expected} in {error}");
    };
    for (from, to, expected) in META_MISTAKES {
        check(&json.replacen(from, to, 1), &log, expected);
    }
    for (from, to, expected) in LOG_MISTAKES {
        check(&json, &log.replacen(from, to, 1), expected);
    }
    check(&json, HEADER, "received no row");
    let short: Vec<&str> = log.lines().take(50).collect();
    check(&json, &short.join("\n"), "49 rows, at least 100");
}

proptest! {
    /// Whatever is damaged, the answer is a recording or an error.
    #[test]
    fn damage_is_survived(
        in_meta: bool,
        at in 0.0..1.0_f64,
        length in 0_usize..40,
        by in "[-0-9eE+.,;\"{}\\[\\]\n\r a-z\u{0}ä]{0,12}",
    ) {
        let (mut json, mut log) = (meta().to_string(), log(100));
        let text = if in_meta { &mut json } else { &mut log };
        let from = (at * text.len() as f64) as usize;
        let to = (from + length).min(text.len());
        text.replace_range(from..to, &by);
        if let Ok(logs) = from_text(&json, &log, &log) {
            prop_assert!(logs.train.cycles.iter().all(|c| c.trace.time_s.is_finite()));
            prop_assert!(softdock_physics::model::prediction::predict(&logs.model, &logs.train).is_ok());
        }
    }
}

#[test]
fn a_foreign_log_is_compared() {
    let logs = import(&meta()).unwrap();
    let prediction =
        softdock_physics::model::prediction::predict(&logs.model, &logs.train).unwrap();
    assert!((prediction.cycle_s - 0.002).abs() < 1e-12);
    assert!(
        prediction
            .channel(Channel::Wrench)
            .predicted
            .iter()
            .all(Option::is_some)
    );
}
