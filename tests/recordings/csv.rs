//! Recordings as CSV with a JSON file beside it.

use super::sample::{Source, exact};
use proptest::prelude::*;
use softdock_io::recording::{export_csv, import_csv};
use std::path::{Path, PathBuf};

fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]
    #[test]
    fn everything_comes_back(seed: u64, cycles in 0..40_usize, truth: bool) {
        let mut recording = Source(seed).recording(cycles, truth);
        recording.cut = (cycles % 2 == 0).then(|| "half of it".to_owned());
        let path = path("proptest.csv");
        export_csv(&recording, &path).unwrap();
        prop_assert_eq!(exact(&import_csv(&path).unwrap()), exact(&recording));
    }
}

/// Writes a table of three cycles, changes its text, and reads it.
fn changed(name: &str, change: impl FnOnce(&Path, String) -> String) -> String {
    let recording = Source(8).recording(3, true);
    let path = path(name);
    export_csv(&recording, &path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, change(&path, text)).unwrap();
    format!("{:#}", import_csv(&path).unwrap_err())
}

/// The text with a cell replaced; rows count from 1.
fn with_cell(text: &str, row: usize, column: &str, cell: &str) -> String {
    let mut lines: Vec<_> = text.lines().map(str::to_owned).collect();
    let place = lines[0].split(',').position(|c| c == column).unwrap();
    let mut cells: Vec<_> = lines[row - 1].split(',').collect();
    cells[place] = cell;
    lines[row - 1] = cells.join(",");
    lines.join("\n") + "\n"
}

#[test]
fn a_wrong_cell_is_named_by_row_and_column() {
    let error = changed("cell.csv", |_, text| {
        with_cell(&text, 3, "motion_position_y_m", "far")
    });
    let expected =
        "row 3, column `motion_position_y_m`: expected a number (float64), received `far`";
    assert!(error.contains(expected), "{error}");

    let error = changed("word.csv", |_, text| {
        with_cell(&text, 2, "status_mode", "flying")
    });
    let expected = "row 2, column `status_mode`: expected one of idle, hold, armed, running, \
                    fault, jogging, received `flying`";
    assert!(error.contains(expected), "{error}");

    let error = changed("integer.csv", |_, text| {
        with_cell(&text, 4, "inputs_sensor_gauge_2_counts", "2147483648")
    });
    let expected = "row 4, column `inputs_sensor_gauge_2_counts`: expected a number (int32)";
    assert!(error.contains(expected), "{error}");
}

/// The time comes first; versions up to 0.1.0 had it elsewhere.
#[test]
fn columns_are_known_by_their_names() {
    let recording = Source(7).recording(3, false);
    let path = path("order.csv");
    export_csv(&recording, &path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.starts_with("status_time_s,inputs_robot_ipoc_ms,"));
    let last = |line: &str| {
        let (time, others) = line.split_once(',').unwrap();
        format!("{others},{time}\n")
    };
    std::fs::write(&path, text.lines().map(last).collect::<String>()).unwrap();
    assert_eq!(exact(&import_csv(&path).unwrap()), exact(&recording));
}

#[test]
fn other_columns_are_named() {
    let error = changed("name.csv", |_, text| {
        text.replacen("status_time_s", "time", 1)
    });
    let expected = "row 1: there is no column `status_time_s`";
    assert!(error.contains(expected), "{error}");

    let error = changed("short_row.csv", |_, text| text + "1,2,3\n");
    assert!(error.contains("line: 5"), "{error}");
}

#[test]
fn a_table_that_was_cut_off_is_refused() {
    let error = changed("cut_line.csv", |_, text| text[..text.len() - 2].to_owned());
    assert!(error.contains("the file was cut off"), "{error}");

    let error = changed("cut_rows.csv", |_, text| {
        let lines: Vec<_> = text.lines().take(3).collect();
        lines.join("\n") + "\n"
    });
    assert!(error.contains("holds 2 cycles, expected are 3"), "{error}");
}

#[test]
fn a_table_without_its_description_is_refused() {
    let error = changed("alone.csv", |path, text| {
        std::fs::remove_file(path.with_extension("json")).unwrap();
        text
    });
    assert!(error.contains("alone.json"), "{error}");

    let error = changed("version.csv", |path, text| {
        let json = path.with_extension("json");
        let description = std::fs::read_to_string(&json).unwrap();
        let newer = description.replacen("\"version\": 1", "\"version\": 2", 1);
        std::fs::write(&json, newer).unwrap();
        text
    });
    let expected = "expected format `softdock-csv` version 1, received `softdock-csv` version 2";
    assert!(error.contains(expected), "{error}");
}

#[test]
fn the_description_names_units() {
    let recording = Source(9).recording(1, false);
    let path = path("described.csv");
    export_csv(&recording, &path).unwrap();
    let text = std::fs::read_to_string(path.with_extension("json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["identity"], recording.header.identity);
    let table = std::fs::read_to_string(&path).unwrap();
    let names: Vec<_> = table.lines().next().unwrap().split(',').collect();
    let columns = json["columns"].as_array().unwrap();
    assert_eq!(columns.len(), names.len());
    for (column, name) in columns.iter().zip(names) {
        assert_eq!(column["name"], name);
        assert!(!column["meaning"].as_str().unwrap().is_empty());
        if name.ends_with("_m_s") && !name.ends_with("_n_m_s") {
            assert_eq!(column["unit"], "m/s");
        }
    }
}
