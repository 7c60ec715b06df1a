//! What is wrong in a mapping or a table, and what may be left out of it.

use super::tables::{imported, table};

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

/// The import fails and says so.
fn refused(test: &str, mapping: &str, log: String, expected: &str) {
    let error = imported(test, mapping, &[("log.csv", log)]).unwrap_err();
    assert!(error.contains(expected), "{expected} is not in {error}");
}

/// What is replaced in [`GOOD`] | by what, with \n for a new line | and what is then said.
const MISTAKES: &str = r#"
"pos_x" | "posx" | no column `posx` (did you mean `pos_x`?) for [position] x
"fx" | 9 | no column 9 for [wrench] fx; the columns are time, pos_x, fx
"fx" | 0 | columns are counted from 1, found 0
"mm" | "N" | [position] x: expected a length (in m, cm, mm, um), received the unit `N`
"mm" | "inch" | unknown unit `inch`; known are s, ms
"mm" | "V" | [position] x: `V` is a converter's unit; say with `scale`
derive = true | derives = true | did you mean `derive`?
column = "time" |  | needs [time] `column`
log.csv | lag.csv | lag.csv
fx = "fx" | [filter]\ncutoff_hz = 60 | [filter] cutoff_hz is 60; allowed is above 0 and below 50.0 Hz
fx = "fx" | [filter]\ncutoff_hz = 30\ndecimate = 2 | below 25.0 Hz
fx = "fx" | [filter]\ncutoff_hz = 30\ndecimate = 0 | decimate is 0; allowed is 1 to 199
fx = "fx" | [filter]\ncutoff_hz = 30\ntrim_s = 1 | trim_s is 1; allowed is 0 to 0.990 s
fx = "fx" | [filter]\ncutoff_hz = 30\norder = 99 | order is 99; allowed is 1 to 12
fx = "fx" | [rows]\nfirst = 300 | [rows] leaves nothing: the table has 200 rows
fx = "fx" | [rows]\nlast = 50 | log.csv: 50 rows, at least 100 are needed
fx = "fx" | [split]\ntest_every = 2 | test_every tears a motion apart
fx = "fx" | [split]\ntrain_share = 1.5 | train_share is 1.5
fx = "fx" | fx = "fx"\nframe = "base" | map [orientation]
derive = true | derive = true\nx = "fx" | no column of the velocity itself
[wrench] | [mode]\nrunning = ["1"]\n[wrench] | say `column`, too
[wrench] | [orientation]\norder = "xyzw"\n[wrench] | either `quaternion` with four columns
"#;

#[test]
fn rows_that_are_not_selected_may_hold_anything() {
    let log = good_log().replace("\n1.5,150,150\n", "\n1.5,off\n1.6,,nan,what\n");
    for rows in ["last = 150", "to_s = 1.495"] {
        let mapping = format!("{GOOD}\n[rows]\n{rows}");
        let logs = imported("mapping_selected", &mapping, &[("log.csv", log.clone())]).unwrap();
        assert_eq!(logs.train[0].cycles.len(), 150, "{rows}");
    }
    refused("mapping_selected", GOOD, log, "line 152: expected 3 cells");
}

/// A pendulum that has come to rest where the test part begins.
#[test]
fn the_part_of_a_table_that_stands_still_is_named() {
    let log = table("time,pos_x,fx", 300, |n| {
        format!("{},{},0", n * 0.01, n.min(150.0))
    });
    let mapping = format!("{GOOD}\n[split]\ntrain_share = 0.6");
    let expected = "log.csv, test part: no velocity, pose or wrench changes in its 120 rows, 1.8 s";
    refused("mapping_still", &mapping, log, expected);
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
    refused(
        "mapping_incomplete",
        &mapping,
        nothing,
        "in each of 200 rows",
    );
}

/// As a program writes them that puts topics of 250 Hz and of 100 Hz side by side.
#[test]
fn channels_of_several_rates_are_interpolated_each_through_its_own_rows() {
    let position = (0..500).map(|n| (0.004 * f64::from(n), true));
    let force = (0..200).map(|n| (0.0013 + 0.01 * f64::from(n), false));
    let mut rows: Vec<(f64, bool)> = position.chain(force).collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let row = |(t, is_position): &(f64, bool)| match is_position {
        // A quaternion and its negative are one orientation.
        true => {
            let q = if t.fract() < 0.3 { 0.5 } else { -0.5 };
            format!("{t},{},,{q},{q},{q},{q}\n", 100.0 * t.sin())
        }
        false => format!("{t},,{},,,,\n", (3.0 * t).sin()),
    };
    let rows: String = rows.iter().map(row).collect();
    let log = format!("time,pos_x,fx,w,x,y,z\n{rows}");
    let orientation = "[orientation]\nquaternion = [\"w\", \"x\", \"y\", \"z\"]";
    let mapping = GOOD.replace(
        "[time]",
        &format!("{orientation}\n[time]\nresample_hz = 250"),
    );
    let left_out = format!("{mapping}\n[rows]\nincomplete = \"leave_out\"");
    let expected = "say `incomplete = \"interpolate\"` in [rows]";
    refused("mapping_merged", &left_out, log.clone(), expected);
    let mapping = left_out.replace("leave_out", "interpolate");
    let as_they_are = mapping.replace("resample_hz = 250", "");
    refused(
        "mapping_merged",
        &as_they_are,
        log.clone(),
        "say `resample_hz` in [time]",
    );
    let logs = imported("mapping_merged", &mapping, &[("log.csv", log)]).unwrap();
    let told = logs.warnings.concat();
    for filled in ["position x 200, ", ", wrench fx 497"] {
        assert!(told.contains(filled), "{told}");
    }
    for cycle in &logs.train[0].cycles {
        let t = cycle.trace.time_s;
        let off = [
            cycle.trace.pose[0] - 0.1 * t.sin(),
            cycle.inputs.sensor.wrench[0] - (3.0 * t).sin(),
            cycle.trace.pose[3..].iter().sum::<f64>().abs() - 2.0,
        ];
        assert!(off.iter().all(|off| off.abs() < 1e-3), "{t}: {off:?}");
    }
}

#[test]
fn rows_of_variables_are_told_and_turned_round() {
    let columns = [("time", 0.01, 0.0), ("pos_x", 1.0, 0.0), ("fx", 1.0, 1.0)];
    let row = |(name, scale, offset): &(&str, f64, f64)| {
        let cells = (0..200).map(|n| format!(",{}", scale * f64::from(n) + offset));
        format!("{name}{}\n", cells.collect::<String>())
    };
    let log: String = columns.iter().map(row).collect();
    let expected = "2 rows of 201 cells; expected a row for each instant";
    refused("mapping_transposed", GOOD, log.clone(), expected);
    let mapping = format!("{GOOD}\n[table]\ntransposed = true");
    let logs = imported("mapping_transposed", &mapping, &[("log.csv", log.clone())]).unwrap();
    let last = &logs.train[0].cycles[199];
    assert_eq!(
        (last.trace.pose[0], last.inputs.sensor.wrench[0]),
        (0.199, 200.0)
    );
    let broken = log.replace(",50,", ",fifty,");
    refused(
        "mapping_transposed",
        &mapping,
        broken,
        "line 52, column `pos_x`",
    );
}

#[test]
fn a_wrench_alone_is_told_to_show_nothing_that_moves() {
    let log = table("time,fx", 200, |n| format!("{},{}", 0.01 * n, n.sin()));
    let mapping =
        "files = { train = \"log.csv\" }\ntime = { column = \"time\" }\nwrench = { fx = \"fx\" }";
    let logs = imported("mapping_wrench", mapping, &[("log.csv", log)]).unwrap();
    assert!(logs.warnings[0].contains("no motion is mapped"));
}

#[test]
fn mistakes_in_a_mapping_are_named() {
    imported("mapping_good", GOOD, &[("log.csv", good_log())]).unwrap();
    for line in MISTAKES.trim().lines() {
        let [from, to, expected] = *line.split(" | ").collect::<Vec<_>>() else {
            panic!("{line}");
        };
        assert!(GOOD.contains(from), "{from}");
        let mapping = GOOD.replace(from, &to.replace("\\n", "\n"));
        refused("mapping_mistakes", &mapping, good_log(), expected);
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
        ("0.03,5,5", "which [rows] of a mapping takes one"),
    ];
    for (row, expected) in broken {
        let log = good_log().replace("\n0.05,5,5\n", &format!("\n{row}\n"));
        refused("mapping_broken", GOOD, log, expected);
    }
}
