//! What a mapping makes of the columns of a table.

use super::tables::{imported, near, table};
use nalgebra::{Quaternion, UnitQuaternion};
use softdock_app::record::CycleRecord;
use softdock_control::modes::Mode;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

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

/// Nobody knows how much a milliampere pushes; that is said, once for all logs.
#[test]
fn amperes_that_count_as_newtons_are_said_to() {
    let mapping = r#"
        [files]
        train = [["log.csv"], ["log.csv"]]
        [time]
        column = "t"
        [position]
        x = "p"
        [wrench]
        fx = { column = "i", unit = "mA", scale = -1.0 }
    "#;
    let log = table("t,p,i", 120, |n| format!("{},{n},{}", 0.01 * n, n % 7.0));
    let logs = imported("mapping_amperes", mapping, &[("log.csv", log)]).unwrap();
    let said = "[wrench] fx: 1 mA counts as 0.001 N: amounts in N are those of the column at this rate, and no forces or torques";
    let times = logs.warnings.iter().filter(|warning| *warning == said);
    assert_eq!(times.count(), 1, "{:?}", logs.warnings);
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

/// Comments right above the numbers are a header, if they have a name for each column.
#[test]
fn names_of_columns_may_stand_behind_a_number_sign() {
    let mapping = r#"
        files = { train = "log.csv" }
        table = { delimiter = "blanks" }
        time = { column = "t" }
        position = { x = "p" }
    "#;
    let log = |above: &str| table(above, 200, |n| format!("{} {}", 0.01 * n, n * n));
    for above in ["# a title\n# t  p", "# t p\n# s m", "# t p\n# ----"] {
        let logs = imported("comment_header", mapping, &[("log.csv", log(above))]).unwrap();
        assert_eq!(logs.train[0].cycles.len(), 200, "{above}");
    }
    for above in ["# t p u", "# t p\n"] {
        let error = imported("comment_header", mapping, &[("log.csv", log(above))]);
        let error = error.unwrap_err();
        assert!(
            error.contains("say `header = false` in [table]"),
            "{above}: {error}"
        );
    }
}

/// A column of words, and a delimiter at the end of each line.
#[test]
fn not_all_cells_below_a_comment_need_be_numbers() {
    let mapping = "files = { train = \"log.csv\" }\ntime = { column = \"t\" }\nposition = { x = \"p\" }\n\
                   mode = { column = \"state\", running = [\"run\"] }";
    let log = table("# t,p,state,", 200, |n| {
        format!("{},{},idle,", 0.01 * n, n * n)
    });
    imported("comment_words", mapping, &[("log.csv", log)]).unwrap();
    let log = table("0,5;0,5;run", 200, |n| format!("{n},5;{n},5;run"));
    let mapping = format!("{mapping}\ntable = {{ delimiter = \";\", decimal_comma = true }}");
    let error = imported("comment_words", &mapping, &[("log.csv", log)]).unwrap_err();
    assert!(error.contains("say `header = false` in [table]"), "{error}");
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

    // What a vehicle has driven in an hour is not the position of an axis in mm.
    let log = table("v,w", 400, |n| format!("{},0", n * n));
    let logs = imported("mapping_integrate_far", mapping, &[("log.csv", log)]).unwrap();
    let far = logs.train[0].cycles.last().unwrap().trace.pose[0];
    assert!(far > 50.0, "{far}");
    let of_units = |told: &&String| told.contains("in mm?");
    assert_eq!(logs.warnings.iter().find(of_units), None);
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

/// A controller that pushes by the distance to its goal: the scale is that of the difference.
#[test]
fn what_is_subtracted_has_the_scale_of_the_column_unless_it_has_its_own() {
    let log = table("t,x,goal", 300, |n| {
        format!("{},{},{}", 0.01 * n, n.sin(), 5.0 + n)
    });
    let force = |other: &str| {
        let mapping = format!(
            "[files]\ntrain = \"log.csv\"\n[time]\ncolumn = \"t\"\n[position]\nx = {{ column = \"x\", unit = \"mm\" }}\n\
             [executed_velocity]\nderive = true\n[wrench]\nfx = {{ column = \"goal\", scale = -2.0, minus = {other} }}\n"
        );
        let logs = imported("minus", &mapping, &[("log.csv", log.clone())]).unwrap();
        logs.train[0].cycles[7].inputs.sensor.wrench[0]
    };
    let (goal, x) = (12.0, 7.0_f64.sin());
    for (other, expected) in [
        ("\"x\"", -2.0 * (goal - x)),
        ("{ column = \"x\", scale = 1.0 }", -2.0 * goal - x),
        (
            "{ column = \"x\", offset = 1.0 }",
            -2.0 * goal - (-2.0 * x + 1.0),
        ),
        (
            "{ column = \"x\", minus = \"goal\" }",
            -2.0 * (goal - (x - goal)),
        ),
    ] {
        let found = force(other);
        assert!(
            (found - expected).abs() < 1e-9,
            "{other}: {found} {expected}"
        );
    }
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
