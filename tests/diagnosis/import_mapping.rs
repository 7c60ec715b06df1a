//! Tables of other programs, imported through a mapping file.

use nalgebra::{Quaternion, UnitQuaternion};
use softdock_analysis::import::mapping::{MappedLogs, import};
use softdock_app::record::CycleRecord;
use softdock_control::modes::Mode;
use softdock_io::recording::Recording;
use softdock_physics::model::{Axis, Model};
use softdock_tests::process::{scratch, softdock};
use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::fs;

/// Imports the files of a table through a mapping, in a folder of its own.
pub(super) fn imported(
    test: &str,
    mapping: &str,
    files: &[(&str, String)],
) -> Result<MappedLogs, String> {
    let folder = scratch(test);
    for (name, text) in files {
        fs::write(folder.join(name), text).unwrap();
    }
    fs::write(folder.join("mapping.toml"), mapping).unwrap();
    import(&folder, &folder.join("mapping.toml")).map_err(|error| format!("{error:#}"))
}

/// A table with a header; each row is made of its number.
pub(super) fn table(header: &str, rows: usize, row: impl Fn(f64) -> String) -> String {
    let rows = (0..rows).map(|n| row(n as f64) + "\n");
    format!("{header}\n{}", rows.collect::<String>())
}

pub(super) fn near(received: &[f64], expected: &[f64]) -> bool {
    received.len() == expected.len()
        && received
            .iter()
            .zip(expected)
            .all(|(r, e)| (r - e).abs() < 1e-9)
}

/// A model for measurements at rest.
const AT_REST: &str = "[rig]\nactive_axes = []\n[sensor]\nat_rest = true\n";

#[test]
fn units_scales_and_offsets_become_si() {
    let mapping = r#"
        [files]
        train = "log.csv"
        [table]
        delimiter = ";"
        decimal_comma = true
        skip_lines = 1
        [time]
        column = { column = "t", unit = "ms" }
        [mode]
        column = "state"
        running = ["auto"]
        [position]
        x = { column = "p", unit = "mm", scale = -2.0, offset = 1.0 }
        [sent_velocity]
        y = { column = "p", unit = "mm/s" }
        rz = { column = 3, unit = "deg/s" }
        [executed_velocity]
        x = "v"
        [wrench]
        fx = { column = "u", unit = "V", scale = 35.0 }
        tz = { column = "u", unit = "N·mm" }
    "#;
    let log = table("a title\nt;state;p;v;u", 120, |n| {
        let state = if n < 10.0 { "hand" } else { "auto" };
        format!("{n};{state};{n};-2,0;1,5").replace('.', ",")
    });
    let logs = imported("mapping_units", mapping, &[("log.csv", log)]).unwrap();
    assert_eq!(logs.warnings, Vec::<String>::new());
    assert!(logs.test.is_empty() && logs.model.is_none());
    let cycles = &logs.train[0].cycles;
    assert_eq!(
        (cycles[9].trace.mode, cycles[10].trace.mode),
        (Mode::Hold, Mode::Running)
    );
    let CycleRecord { trace, inputs, .. } = &cycles[20];
    assert_eq!((trace.cycle, trace.time_s), (20, 0.02));
    assert!(
        near(&trace.pose, &[-0.039, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
        "{:?}",
        trace.pose
    );
    assert!(near(
        &trace.sent_velocity,
        &[0.0, 0.02, 0.0, 0.0, 0.0, PI / 9.0]
    ));
    assert!(near(
        &trace.executed_velocity,
        &[-2.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    ));
    assert!(near(
        &inputs.sensor.wrench,
        &[52.5, 0.0, 0.0, 0.0, 0.0, 0.0015]
    ));
}

#[test]
fn a_wrench_of_the_base_is_turned_with_the_pose_of_its_row_and_files_stand_side_by_side() {
    let mapping = r#"
        model = "model.toml"
        [files]
        train = ["pose.txt", "wrench.txt"]
        [table]
        header = false
        delimiter = "blanks"
        [time]
        sample_time_s = 1.0
        [orientation]
        quaternion = [1, 2, 3, 4]
        order = "xyzw"
        [wrench]
        frame = "base"
        fx = 5
        fz = 7
        ty = 9
        [split]
        test_every = 3
    "#;
    // A quarter turn about x: z of the base is y of the sensor, y of the base is -z.
    let half = FRAC_1_SQRT_2;
    let pose = (0..36).map(|_| format!("  {half} 0 0\t{half}\n")).collect();
    let wrench = (0..36).map(|n| format!("{n} 0 3   0 5 0\n")).collect();
    let files = [
        ("pose.txt", pose),
        ("wrench.txt", wrench),
        ("model.toml", AT_REST.to_owned()),
    ];
    let logs = imported("mapping_base", mapping, &files).unwrap();
    let [train, test] = [&logs.train[0].cycles, &logs.test[0].cycles];
    assert_eq!((train.len(), test.len()), (24, 12));
    let wrench = |cycle: &CycleRecord| cycle.inputs.sensor.wrench;
    assert!(
        near(&wrench(&train[2]), &[3.0, 3.0, 0.0, 0.0, 0.0, -5.0]),
        "{:?}",
        wrench(&train[2])
    );
    assert!(near(&wrench(&test[1])[..1], &[5.0]));
    assert_eq!(logs.model.unwrap().1, AT_REST, "the user's own text");
}

#[test]
fn a_derived_velocity_is_the_difference_of_filtered_positions() {
    let mapping = r#"
        [files]
        train = "log.csv"
        [time]
        column = "t"
        [position]
        x = "p"
        [executed_velocity]
        derive = true
        [wrench]
        fx = "f"
        [filter]
        cutoff_hz = 50.0
        decimate = 4
        [split]
        train_share = 0.75
    "#;
    // 1 Hz passes, 200 Hz does not.
    let angle = |n: f64| 2.0 * PI * n * 1e-3;
    let log = table("t,p,f", 4000, |n| {
        let hum = 1e-3 * (200.0 * angle(n)).sin();
        format!(
            "{},{},{}",
            n * 1e-3,
            angle(n).sin() + hum,
            10.0 * angle(n).cos() + hum
        )
    });
    let logs = imported("mapping_derive", mapping, &[("log.csv", log)]).unwrap();
    let [train, test] = [&logs.train[0].cycles, &logs.test[0].cycles];
    assert_eq!((train.len(), test.len()), (750, 250));
    for n in 50..700 {
        let (cycle, before) = (&train[n], &train[n - 1]);
        let at = angle(4.0 * n as f64);
        assert!((cycle.trace.pose[0] - at.sin()).abs() < 1e-6, "{n}");
        assert!(
            (cycle.inputs.sensor.wrench[0] - 10.0 * at.cos()).abs() < 1e-5,
            "{n}"
        );
        let moved = cycle.trace.pose[0] - before.trace.pose[0];
        let velocity = cycle.trace.executed_velocity[0];
        assert!(
            (velocity * 0.004 - moved).abs() < 1e-12,
            "{n}: {velocity} {moved}"
        );
    }
    assert_eq!(test[0].trace.cycle, 0);
    assert!((test[0].trace.time_s - 3.0).abs() < 1e-9);
}

#[test]
fn a_pose_that_is_not_in_the_table_is_the_way_of_the_velocity_and_no_sensor_is_not_zero_force() {
    let mapping = r#"
        [files]
        train = "log.csv"
        [time]
        sample_time_s = 0.01
        [executed_velocity]
        x = { column = "v", unit = "mm/s" }
        rz = { column = "w", unit = "deg/s" }
        [rows]
        first = 11
        to_s = 3.0
    "#;
    let log = table("v,w", 400, |n| format!("{n},90"));
    let logs = imported("mapping_integrate", mapping, &[("log.csv", log)]).unwrap();
    let cycles = &logs.train[0].cycles;
    assert_eq!(cycles.len(), 291);
    let last = cycles.last().unwrap();
    // From 0.01 to 0.3 m/s within 2.9 s; 90 deg/s for 2.9 s.
    assert!(
        (last.trace.pose[0] - 0.155 * 2.9).abs() < 1e-9,
        "{:?}",
        last.trace.pose
    );
    let half = (90.0_f64.to_radians() * 2.9 / 2.0).sin();
    assert!(
        (last.trace.pose[6] - half).abs() < 1e-9,
        "{:?}",
        last.trace.pose
    );
    assert!(last.inputs.sensor.wrench.iter().all(|f| f.is_nan()));
}

/// KUKA's A, B, C: about z, then the new y, then the new x, in degrees.
#[test]
fn angles_of_turns_one_after_the_other_are_orientations() {
    let mapping = r#"
        [files]
        train = "log.csv"
        [time]
        column = "t"
        [orientation]
        euler = "zyx"
        rz = { column = "A", unit = "deg" }
        ry = { column = "B", unit = "deg" }
        rx = { column = "C", unit = "deg" }
        [wrench]
        fx = "f"
    "#;
    let log = table("t,A,B,C,f", 200, |n| {
        format!("{},{},{},{},{n}", n * 0.01, 0.5 * n, 30.0, -0.2 * n)
    });
    let files = [("log.csv", log)];
    let logs = imported("mapping_euler", mapping, &files).unwrap();
    let [.., w, x, y, z] = logs.train[0].cycles[180].trace.pose;
    let turned = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    let expected = UnitQuaternion::from_euler_angles(
        -36.0_f64.to_radians(),
        30.0_f64.to_radians(),
        90.0_f64.to_radians(),
    );
    assert!(turned.angle_to(&expected) < 1e-9, "{turned} {expected}");
    for (wrong, said) in [
        ("\"zyz\"", "x, y and z in the order of the turns"),
        ("\"zy\"", "found \"zy\""),
    ] {
        let mapping = mapping.replace("\"zyx\"", wrong);
        let error = imported("mapping_euler", &mapping, &files).unwrap_err();
        assert!(error.contains(said), "{error}");
    }
}

/// A log of positions and forces: its velocity is derived, and a model to start from comes with it.
#[test]
fn an_import_says_what_it_read_and_gives_a_model_to_start_from() {
    let folder = scratch("mapping_starter");
    let log = table("t,p,f", 1000, |n| {
        let angle = 2.0 * PI * n * 4e-3;
        format!("{},{},{}", n * 4e-3, 0.1 * angle.sin(), 4.0 * angle.sin())
    });
    let mapping = "[time]\ncolumn = \"t\"\n[position]\nx = \"p\"\n[wrench]\nfx = \"f\"\n";
    fs::write(folder.join("log.csv"), log).unwrap();
    fs::write(folder.join("mapping.toml"), mapping).unwrap();
    let arguments = [
        "import",
        "log.csv",
        "--mapping",
        "mapping.toml",
        "-o",
        "out",
    ];
    let run = softdock(&folder, &arguments);
    // A sine of all digits is no sensor's.
    let guessed = "warning: [noise] force_n = 2.3e-3 N is a guess";
    assert!(
        run.code == Some(0) && run.stderr.lines().count() == 1 && run.stderr.starts_with(guessed),
        "{}",
        run.stderr
    );
    for says in [
        "train.mcap: 1000 rows, 3.996 s, a cycle of 0.004000 s",
        "central differences of the poses",
        "Not in the log, or zero throughout: sent velocity, model velocity.",
    ] {
        assert!(run.stdout.contains(says), "`{says}`: {}", run.stdout);
    }
    let text = fs::read_to_string(folder.join("out/model.toml")).unwrap();
    assert!(text.contains("active_axes = [\"x\"]"), "{text}");
    let run = softdock(&folder, &["compare", "out/model.toml", "out/train.mcap"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
}

#[test]
fn rows_that_are_not_selected_may_hold_anything() {
    let log = good_log().replace("\n1.5,150,150\n", "\n1.5,off\n1.6,,nan,what\n");
    for rows in ["last = 150", "to_s = 1.495"] {
        let mapping = format!("{GOOD}\n[rows]\n{rows}");
        let logs = imported("mapping_selected", &mapping, &[("log.csv", log.clone())]).unwrap();
        assert_eq!(logs.train[0].cycles.len(), 150, "{rows}");
    }
    let error = imported("mapping_selected", GOOD, &[("log.csv", log)]).unwrap_err();
    assert!(error.contains("line 152: expected 3 cells"), "{error}");
}

/// A cylinder: force is the difference of two pressures on areas of their own, stamps are dates, and both logs are of
/// one table.
#[test]
fn one_table_has_dates_two_pressures_and_both_logs() {
    let mapping = |rows: &str| {
        format!(
            "[files]\ntrain = \"log.csv\"\n[time]\ncolumn = {{ column = \"t\", unit = \"date\" }}\n\
             [position]\nx = {{ column = \"x\", unit = \"mm\" }}\n[executed_velocity]\nderive = true\n\
             [wrench]\nfx = {{ column = \"a\", unit = \"bar\", scale = 2e-3, \
             minus = {{ column = \"b\", unit = \"bar\", scale = 1e-3 }} }}\n{rows}"
        )
    };
    let log = || {
        let stamp = |n: f64| {
            let (minute, second) = (59 + (n as u32) / 6000, 0.01 * (n % 6000.0));
            let (hour, minute) = (23, minute);
            match minute < 60 {
                true => format!("2026-03-01 {hour}:{minute:02}:{second:06.3}"),
                false => format!("2026-03-02 00:{:02}:{second:06.3}", minute - 60),
            }
        };
        let row = |n: f64| format!("{},{},{},{}", stamp(n), (0.01 * n).sin(), 3.0, 1.0 + n);
        vec![("log.csv", table("t,x,a,b", 8000, row))]
    };
    let rows = "[rows.train]\nto_s = 50.0\n[rows.test]\nfrom_s = 55\nto_s = 70\n";
    let logs = imported("mapping_dates", &mapping(rows), &log()).unwrap();
    let test = &logs.test[0];
    let lengths = (logs.train[0].cycles.len(), test.cycles.len());
    assert_eq!(lengths, (5001, 1501));
    let CycleRecord { trace, inputs, .. } = &test.cycles[1000];
    assert!((trace.time_s - 65.0).abs() < 1e-9, "{}", trace.time_s);
    let force = 1e5 * (2e-3 * 3.0 - 1e-3 * 6501.0);
    assert!((inputs.sensor.wrench[0] - force).abs() < 1e-6);

    let refused = |rows: &str, files: Vec<(&str, String)>| {
        let result = imported("mapping_dates_wrong", &mapping(rows), &files);
        result.map(|_| ()).unwrap_err()
    };
    let said = refused("[rows.train]\nto_s = 60\n[rows.test]\nfrom_s = 55\n", log());
    assert!(said.contains("55.000 s to 60.000 s in common"), "{said}");
    let said = refused(
        "[rows.test]\nfrom_s = 55\n[split]\ntrain_share = 0.5\n",
        log(),
    );
    assert!(said.contains("[split] and [rows.test]"), "{said}");
    let mut wrong = log();
    wrong[0].1 = wrong[0]
        .1
        .replacen("2026-03-01 23:59:00.020", "yesterday", 1);
    let said = refused("", wrong);
    assert!(
        said.contains("line 4") && said.contains("`yesterday`"),
        "{said}"
    );
    let plain = mapping("").replace(", unit = \"date\"", "");
    let said = imported("mapping_dates_plain", &plain, &log()).map(|_| ());
    let said = said.unwrap_err();
    assert!(said.contains("unit = \"date\""), "{said}");
}

#[test]
fn incomplete_rows_are_refused_or_left_out() {
    let (pos, fx) = ("\n0.5,50,50\n", "\n0.8,80,80\n");
    let log = good_log()
        .replace(pos, "\n0.5,,50\n")
        .replace(fx, "\n0.8,80,NaN\n");
    assert_ne!(log, good_log());
    let files = [("log.csv", log)];
    let error = imported("mapping_incomplete", GOOD, &files).unwrap_err();
    assert!(
        error.contains("an empty cell") && error.contains("leave_out"),
        "{error}"
    );
    let mapping = format!("{GOOD}\n[rows]\nincomplete = \"leave_out\"");
    let logs = imported("mapping_incomplete", &mapping, &files).unwrap();
    assert_eq!(logs.train[0].cycles.len(), 198);
    let told = logs.warnings.concat();
    assert!(told.contains("2 of 200 rows are left out"), "{told}");
    let bridged = mapping.replace("[time]", "[time]\ngaps = \"bridge\"");
    let logs = imported("mapping_incomplete", &bridged, &files).unwrap();
    assert_eq!(logs.train[0].cycles.len(), 200);
    let nothing = table("time,pos_x,fx", 200, |n| format!("{},{n},NA", n * 0.01));
    let error = imported("mapping_incomplete", &mapping, &[("log.csv", nothing)]).unwrap_err();
    assert!(error.contains("in each of 200 rows"), "{error}");
}

/// A mapping that works with [`good_log`].
const GOOD: &str = r#"
    [files]
    train = "log.csv"
    [time]
    column = "time"
    [position]
    x = { column = "pos_x", unit = "mm" }
    [executed_velocity]
    derive = true
    [wrench]
    fx = "fx"
"#;

fn good_log() -> String {
    table("time,pos_x,fx", 200, |n| format!("{},{n},{n}", n * 0.01))
}

/// What is replaced in [`GOOD`], by what, and what is then said.
const MISTAKES: &[(&str, &str, &str)] = &[
    (
        "\"pos_x\"",
        "\"posx\"",
        "no column `posx` (did you mean `pos_x`?) for [position] x",
    ),
    (
        "\"fx\"",
        "9",
        "no column 9 for [wrench] fx; the columns are time, pos_x, fx",
    ),
    ("\"fx\"", "0", "columns are counted from 1, found 0"),
    (
        "\"mm\"",
        "\"N\"",
        "[position] x: expected a length (in m, cm, mm, um), received the unit `N`",
    ),
    ("\"mm\"", "\"inch\"", "unknown unit `inch`; known are s, ms"),
    (
        "\"mm\"",
        "\"V\"",
        "[position] x: `V` is a converter's unit; say with `scale`",
    ),
    ("derive = true", "derives = true", "did you mean `derive`?"),
    ("column = \"time\"", "", "needs [time] `column`"),
    ("log.csv", "lag.csv", "lag.csv"),
    (
        "fx = \"fx\"",
        "[filter]\ncutoff_hz = 60",
        "[filter] cutoff_hz is 60; allowed is above 0 and below 50.0 Hz",
    ),
    (
        "fx = \"fx\"",
        "[filter]\ncutoff_hz = 30\ndecimate = 2",
        "below 25.0 Hz",
    ),
    (
        "fx = \"fx\"",
        "[filter]\ncutoff_hz = 30\ndecimate = 0",
        "decimate is 0; allowed is 1 to 199",
    ),
    (
        "fx = \"fx\"",
        "[filter]\ncutoff_hz = 30\ntrim_s = 1",
        "trim_s is 1; allowed is 0 to 0.990 s",
    ),
    (
        "fx = \"fx\"",
        "[filter]\ncutoff_hz = 30\norder = 99",
        "order is 99; allowed is 1 to 12",
    ),
    (
        "fx = \"fx\"",
        "[rows]\nfirst = 300",
        "[rows] leaves nothing: the table has 200 rows",
    ),
    (
        "fx = \"fx\"",
        "[rows]\nlast = 50",
        "log.csv: 50 rows, at least 100 are needed",
    ),
    (
        "fx = \"fx\"",
        "[split]\ntest_every = 2",
        "test_every tears a motion apart",
    ),
    (
        "fx = \"fx\"",
        "[split]\ntrain_share = 1.5",
        "train_share is 1.5",
    ),
    (
        "fx = \"fx\"",
        "fx = \"fx\"\nframe = \"base\"",
        "map [orientation]",
    ),
    (
        "derive = true",
        "derive = true\nx = \"fx\"",
        "no column of the velocity itself",
    ),
    (
        "[wrench]",
        "[mode]\nrunning = [\"1\"]\n[wrench]",
        "say `column`, too",
    ),
    (
        "[wrench]",
        "[orientation]\norder = \"xyzw\"\n[wrench]",
        "either `quaternion` with four columns",
    ),
];

#[test]
fn mistakes_in_a_mapping_are_named() {
    imported("mapping_good", GOOD, &[("log.csv", good_log())]).unwrap();
    for (from, to, expected) in MISTAKES {
        assert!(GOOD.contains(from), "{from}");
        let mapping = GOOD.replace(from, to);
        match imported("mapping_mistakes", &mapping, &[("log.csv", good_log())]) {
            Err(error) => assert!(
                error.contains(expected),
                "{to}: expected {expected} in {error}"
            ),
            Ok(_) => panic!("{to} was not refused: {expected}"),
        }
    }
}

#[test]
fn mistakes_in_a_table_are_named_with_their_place() {
    let broken = [
        ("0.05,5", "log.csv, line 7: expected 3 cells"),
        (
            "0.05,,5",
            "log.csv, line 7, column `pos_x`: expected a number, received an empty cell",
        ),
        (
            "0.05,nan,5",
            "line 7, column `pos_x`: expected a number, received `nan`",
        ),
        ("\"0,05\",5,5", "decimal_comma"),
        ("0.03,5,5", "row 6: the time is 0.03 s after 0.04 s"),
    ];
    for (row, expected) in broken {
        let log = good_log().replace("\n0.05,5,5\n", &format!("\n{row}\n"));
        let result = imported("mapping_broken", GOOD, &[("log.csv", log)]);
        let error = result.map(|_| ()).unwrap_err();
        assert!(error.contains(expected), "expected {expected} in {error}");
    }
}

#[test]
fn the_commented_mapping_works_with_a_table_of_its_columns() {
    let mapping = include_str!("../../examples/mapping.toml");
    let header = "time,state,x,y,z,qw,qx,qy,qz,vx_cmd,vx_model,Fx,Fy,Fz,Tx,Ty,Tz";
    let log = table(header, 400, |n| {
        let state = if n < 100.0 { "jog" } else { "auto" };
        format!(
            "{},{state},{n},0,0,1,0,0,0,0,0,{},0,0,0,0,0",
            n * 4.0,
            n.sin()
        )
    });
    let logs = imported("mapping_commented", mapping, &[("log.csv", log)]).unwrap();
    assert_eq!(logs.warnings, Vec::<String>::new());
    let lengths = (logs.train[0].cycles.len(), logs.test[0].cycles.len());
    assert_eq!(lengths, (280, 120));
}

#[test]
fn the_command_takes_one_file_in_place_of_the_mappings_and_tells_what_looks_wrong() {
    let folder = scratch("mapping_command");
    let mapping = "model = \"model.toml\"\n[files]\ntrain = \"other.csv\"\ntest = \"other2.csv\"\n\
                   [time]\ncolumn = \"t\"\n[position]\nx = \"p\"\n\
                   [executed_velocity]\nderive = true\n";
    let log = table("t,p", 150, |n| format!("{},{}", n * 0.01, n * n));
    fs::write(folder.join("mapping.toml"), mapping).unwrap();
    fs::write(folder.join("model.toml"), "# mine\n").unwrap();
    fs::write(folder.join("log.csv"), log).unwrap();
    let arguments = [
        "import",
        "log.csv",
        "--mapping",
        "mapping.toml",
        "-o",
        "out",
        "--json",
    ];
    let run = softdock(&folder, &arguments);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let report: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(report["cycles"], 150);
    let warnings = report["warnings"].as_array().unwrap();
    assert!(
        warnings[0]
            .as_str()
            .unwrap()
            .contains("are the positions in mm?"),
        "{warnings:?}"
    );
    assert!(
        run.stderr
            .contains("warning: log.csv: a position of 22200 m"),
        "{}",
        run.stderr
    );
    let files: Vec<_> = ["model.toml", "train.mcap"]
        .map(|f| format!("out/{f}"))
        .into();
    assert_eq!(report["files"], serde_json::json!(files));
    assert_eq!(
        fs::read_to_string(folder.join("out/model.toml")).unwrap(),
        "# mine\n"
    );

    let again = softdock(&folder, &arguments);
    assert!(
        again.code == Some(1) && again.stderr.contains("not overwritten"),
        "{}",
        again.stderr
    );
    let recording = softdock(&folder, &["import", "out/train.mcap", "-o", "copy"]);
    assert!(
        recording.stderr.contains("is a recording already"),
        "{}",
        recording.stderr
    );
    assert!(recording.code == Some(1) && !folder.join("copy").exists());
}

/// Three runs of a carriage, two to fit on, each of two tables side by side; one moves along y, too. One model is written for all.
#[test]
fn several_logs_of_a_machine_need_one_mapping() {
    let mapping = r#"
        [files]
        train = [["slow.csv", "slow-force.csv"], ["fast.csv", "fast-force.csv"]]
        test = [["unseen.csv", "unseen-force.csv"]]
        [time]
        column = "t"
        [position]
        x = "x"
        y = "y"
        [executed_velocity]
        derive = true
        [wrench]
        fx = "f"
    "#;
    let folder = scratch("mapping_several_logs");
    let write = |name: &str, text: String| fs::write(folder.join(name), text).unwrap();
    write("mapping.toml", mapping.to_owned());
    for (name, rate, aside, noise) in [
        ("slow", 1.0, 0.0, 1e-2),
        ("fast", 5.0, 0.01, 3e-2),
        ("unseen", 3.0, 0.0, 1e-1),
    ] {
        let along = |n: f64| 0.1 * (rate * 0.01 * n).sin();
        let row = |n: f64| format!("{:.3},{:.6},{:.6}", 0.01 * n, along(n), aside * along(n));
        write(&format!("{name}.csv"), table("t,x,y", 300, row));
        // Uniform: 0 to 1 from the golden ratio.
        let scatter = |n: f64| noise * (12.0_f64.sqrt() * ((0.618_034 * n).fract() - 0.5));
        let row = |n: f64| format!("{:.4}", 2.0 * along(n) + scatter(n * n));
        write(&format!("{name}-force.csv"), table("f", 300, row));
    }
    let import = |path: &str| {
        softdock(
            &folder,
            &[
                "import",
                path,
                "--mapping",
                "mapping.toml",
                "-o",
                "out",
                "--force",
            ],
        )
    };
    let run = import(".");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    for (name, origin) in [
        ("train1.mcap", "slow.csv + slow-force.csv"),
        ("train2.mcap", "fast.csv + fast-force.csv"),
        ("test.mcap", "unseen.csv + unseen-force.csv"),
    ] {
        let recording = Recording::open(&folder.join("out").join(name)).unwrap();
        assert_eq!(recording.header.identity, format!("imported from {origin}"));
        let mut lines = run.stdout.lines();
        let said = |line: &str| line.contains(name) && line.ends_with(origin);
        assert!(lines.any(said), "{}", run.stdout);
    }
    let model = fs::read_to_string(folder.join("out/model.toml")).unwrap();
    let model = Model::from_toml(&model, "model.toml").unwrap();
    assert_eq!(model.rig.active_axes, [Axis::X, Axis::Y]);
    // Not that of the unseen log, nor the larger one of the two.
    assert!(
        (0.008..0.013).contains(&model.noise.force_n),
        "{:?}",
        model.noise
    );

    let one = import("slow.csv");
    assert!(
        one.code == Some(1) && one.stderr.contains("names 2 training logs"),
        "{}",
        one.stderr
    );
    write("fast-force.csv", "f\n1.0\n".to_owned());
    let torn = import(".");
    assert!(
        torn.code == Some(1) && torn.stderr.contains("a list of lists"),
        "{}",
        torn.stderr
    );
}
