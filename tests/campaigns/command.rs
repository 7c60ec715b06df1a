//! Rows against `softdock run`, rows that cannot be, and what is said before anything runs.

use super::{CAMPAIGN, ROWS, plan, scenario};
use serde_json::{Value, json as value};
use softdock_io::data_table::{DataTable, Values};
use softdock_io::recording::Recording;
use softdock_tests::process::{done, json, refused, scratch, softdock, words};
use std::fs;

fn numbers(table: &DataTable, name: &str) -> Vec<Option<f64>> {
    match table.values(name).unwrap() {
        Values::Number(values) => values.clone(),
        other => panic!("{name}: {other:?}"),
    }
}

/// The row, its recording, and `softdock run` of the scenario in the recording: the same bits.
#[test]
fn a_row_is_a_run_bit_for_bit() {
    let folder = scratch("campaign_row");
    let planned = plan(&folder, "c");
    assert_eq!(planned["rows"], ROWS);
    assert_eq!(planned["hash"].as_str().unwrap().len(), 16);
    done(&folder, &["campaign", "run", "c"]);
    done(&folder, &words("campaign merge c -o t.parquet --csv"));
    let table = DataTable::read_parquet(&folder.join("t.parquet")).unwrap();
    assert_eq!(table.rows() as u64, ROWS);
    let again = json(&folder, &words("campaign rerun c --index 5 -o r.mcap"));
    assert_eq!(again["same_as"], "part 0/1");
    let recording = Recording::open(&folder.join("r.mcap")).unwrap();
    fs::write(
        folder.join("row.toml"),
        recording.header.scenario_toml.unwrap(),
    )
    .unwrap();
    let run = json(&folder, &words("run row.toml -o run.mcap"));
    let same = Recording::open(&folder.join("run.mcap")).unwrap();
    assert!(same.cycles == recording.cycles && same.truth == recording.truth);
    for (name, in_run, scale) in [
        ("restitution", "restitution", 1.0),
        ("energy_error", "energy_error", 1.0),
        ("peak_force_error", "peak_force_error", 1.0),
        ("contact_time_error", "contact_time_error", 1.0),
        ("speed_in_m_s", "speed_in_mm_s", 1e-3),
    ] {
        let row = numbers(&table, name)[5].unwrap();
        let read = |number: &Value| number.as_f64().unwrap();
        let others = [
            read(&again["outcome"][name]),
            read(&run["impacts"][0][in_run]) * scale,
        ];
        // JSON's numbers are read to the last bit but one.
        for other in others {
            assert!(
                (row - other).abs() <= 4.0 * f64::EPSILON * row.abs(),
                "{name}: {row} {other}"
            );
        }
    }
    let text = fs::read_to_string(folder.join("t.csv")).unwrap();
    assert_eq!(text.lines().count() as u64, ROWS + 1);
    assert!(
        text.starts_with("index,seed,speed_m_s,tip_m,law,status"),
        "{text}"
    );
}

/// What was not carried out is not compared; a stored row is, in every column.
#[test]
fn a_rerun_is_held_against_the_stored_row() {
    let folder = scratch("campaign_rerun");
    plan(&folder, "c");
    let rerun = [
        "campaign", "rerun", "c", "--index", "5", "-o", "r.mcap", "--force",
    ];
    let said = done(&folder, &rerun);
    assert!(said.contains("not carried out before"), "{said}");
    done(&folder, &["campaign", "run", "c", "--shard", "1/4"]);
    let said = done(&folder, &rerun);
    assert!(said.contains("bit for bit the row in part 1/4"), "{said}");
    for column in [
        "success = true",
        "fault = none",
        "final_mode = Running",
        "speed_m_s = ",
    ] {
        assert!(said.contains(column), "{said}");
    }
    let part = folder.join("c/part-1-of-4.parquet");
    let mut table = DataTable::read_parquet(&part).unwrap();
    let columns = &mut table.columns;
    let column = columns
        .iter_mut()
        .find(|c| c.name == "peak_force_n")
        .unwrap();
    let Values::Number(forces) = &mut column.values else {
        panic!("`peak_force_n` holds numbers");
    };
    // Row 5 is the second of 1, 5, 9, ..
    forces[1] = forces[1].map(f64::next_up);
    table.write(&part).unwrap();
    let error = refused(&folder, &rerun);
    assert!(
        error.contains("differs from the one in part 1/4 of c: `peak_force_n`: stored"),
        "{error}"
    );
}

#[test]
fn conditions_that_cannot_be_are_rows_with_their_reason() {
    let folder = scratch("campaign_refused");
    fs::write(folder.join("scenario.toml"), scenario()).unwrap();
    // Each alone is fine; without any noise the board would take the sensor for frozen.
    let factor = |name: &str, value: f64| {
        format!("[[factors]]\nsetting = \"rig.sensor.{name}\"\nlist = [0.0, {value}]\n")
    };
    let factors = factor("noise_force_n", 0.03) + &factor("noise_torque_nm", 0.001);
    let campaign = format!("scenario = \"scenario.toml\"\n{factors}");
    fs::write(folder.join("campaign.toml"), campaign).unwrap();
    done(&folder, &["campaign", "plan", "campaign.toml", "-o", "c"]);
    let run = json(&folder, &["campaign", "run", "c"]);
    assert_eq!((&run["rows"], &run["failed"]), (&4.into(), &1.into()));
    assert_eq!(json(&folder, &["campaign", "status", "c"])["failed"], 1);
    let merged = json(&folder, &words("campaign merge c -o t.parquet --csv"));
    assert_eq!(merged["files"], value!(["t.parquet", "t.csv", "t.json"]));
    let failures = merged["summary"]["failures"].as_object().unwrap();
    let (reason, count) = failures.iter().next().unwrap();
    assert!(
        reason.starts_with("refused: the simulated sensor has no noise"),
        "{reason}"
    );
    assert_eq!((failures.len(), count), (1, &1.into()));
    // One of four is a finding, also where it is a shard of its own, which no cluster has to try again; nothing but such rows is a
    // mistake, and a script stops.
    let alone = json(&folder, &words("campaign run c --shard 0/4"));
    assert_eq!((&alone["rows"], &alone["failed"]), (&1.into(), &1.into()));
    let none = factors.replace("0.03", "0.0").replace("0.001", "0.0");
    let campaign = format!("scenario = \"scenario.toml\"\n{none}");
    fs::write(folder.join("none.toml"), campaign).unwrap();
    done(&folder, &words("campaign plan none.toml -o none"));
    let none = softdock(&folder, &words("campaign run none --json"));
    assert_eq!(none.code, Some(1));
    assert!(none.stdout.contains("\"failed\": 4"), "{}", none.stdout);
    let says = "none of the 4 rows was carried out to its end";
    assert!(none.stderr.contains(says), "{}", none.stderr);
    let error = refused(
        &folder,
        &["campaign", "rerun", "c", "--index", "0", "-o", "r.mcap"],
    );
    assert!(error.contains("no noise"), "{error}");
}

#[test]
fn mistakes_are_named_before_anything_runs() {
    let folder = scratch("campaign_mistakes");
    fs::write(folder.join("scenario.toml"), scenario()).unwrap();
    for (from, to, expected) in [
        (
            "velocity_m_s[0]",
            "velocity_ms[0]",
            "did you mean `board.control.body_k.velocity_m_s[0]`",
        ),
        (
            "uniform = [0.005, 0.02]",
            "uniform = [0.02, 0.005]",
            "expected low < high",
        ),
        (
            "uniform = [0.005, 0.02]",
            "uniform = [0.005, inf]",
            "expected finite numbers, received inf",
        ),
        (
            "list = [\"none\", \"predictor\"]",
            "list = [\"none\", nan]",
            "stands for one that is nan or inf",
        ),
        (
            "high = 1.1",
            "high = 0.8",
            "the limit of `restitution` has `low = 0.9` above `high = 0.8`",
        ),
        (
            "setting = \"rig.mechanism.walls[0].tip_m[1]\"",
            "setting = \"board.control.body_k.velocity_m_s[0]\"",
            "expected one factor for each setting",
        ),
        (
            "design = \"latin",
            "desing = \"latin",
            "did you mean `design`",
        ),
        (
            "scenario = \"scenario.toml\"",
            "scenario = \"scenari.toml\"",
            "did you mean",
        ),
    ] {
        fs::write(folder.join("campaign.toml"), CAMPAIGN.replace(from, to)).unwrap();
        let error = refused(&folder, &["campaign", "plan", "campaign.toml", "-o", "c"]);
        assert!(error.contains(expected), "{error}");
        assert!(!folder.join("c").exists());
    }
    plan(&folder, "c");
    let error = refused(&folder, &["campaign", "plan", "campaign.toml", "-o", "c"]);
    assert!(
        error.contains("give another folder with -o, or remove this one"),
        "{error}"
    );
    assert!(!error.contains("--force"), "{error}");
    let error = refused(
        &folder,
        &["campaign", "rerun", "c", "--index", "24", "-o", "r.mcap"],
    );
    assert!(error.contains("the last is 23"), "{error}");
    let error = refused(&folder, &["campaign", "run", "nowhere"]);
    assert!(error.contains("campaign plan"), "{error}");
}

#[test]
fn lines_for_a_cluster_are_printed() {
    let folder = scratch("campaign_lines");
    plan(&folder, "c");
    let line = done(&folder, &words("campaign slurm c --shards 40 --threads 4"));
    assert!(
        line.starts_with("sbatch ") && line.contains("--array 0-39"),
        "{line}"
    );
    assert!(
        line.contains("--shard $SLURM_ARRAY_TASK_ID/40 --threads 4"),
        "{line}"
    );
    let line = done(&folder, &["campaign", "hq", "c", "--shards", "40"]);
    assert!(
        line.starts_with("hq submit ") && line.contains("--array 0-39"),
        "{line}"
    );
}

#[test]
fn commands_to_copy_keep_a_folder_with_a_space_one_word() {
    let folder = scratch("campaign_space");
    fs::write(folder.join("scenario.toml"), scenario()).unwrap();
    fs::write(folder.join("campaign.toml"), CAMPAIGN).unwrap();
    let named = ["campaign", "plan", "campaign.toml", "-o", "my campaign"];
    let planned = done(&folder, &named);
    let status = done(&folder, &["campaign", "status", "my campaign"]);
    for text in [planned, status] {
        assert!(text.contains("campaign run 'my campaign'"), "{text}");
    }
}
