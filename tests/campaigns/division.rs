//! One shard, many shards, stopped and resumed: the same bytes; and what merge refuses.

use super::{ROWS, merged, plan};
use softdock_tests::process::{Running, done, json, refused, scratch, softdock_binary, words};
use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// The table of one shard.
pub(super) fn whole() -> &'static [u8] {
    static WHOLE: OnceLock<Vec<u8>> = OnceLock::new();
    WHOLE.get_or_init(|| {
        let folder = scratch("campaign_whole");
        plan(&folder, "c");
        done(&folder, &["campaign", "run", "c"]);
        merged(&folder, "c")
    })
}

/// Carries all shards of `of` out, but those that are left out.
fn shards(folder: &Path, of: u64, left_out: &[u64]) {
    for number in (0..of).filter(|number| !left_out.contains(number)) {
        let shard = format!("{number}/{of}");
        done(
            folder,
            &["campaign", "run", "c", "--shard", &shard, "--threads", "2"],
        );
    }
}

#[test]
fn the_table_does_not_depend_on_how_the_rows_are_divided() {
    let folder = scratch("campaign_divided");
    plan(&folder, "c");
    shards(&folder, 7, &[]);
    assert!(merged(&folder, "c") == whole());
}

/// Machines without a shared folder: each has the plan, and the parts are copied together.
#[test]
fn parts_that_were_copied_together_make_the_same_table() {
    let folder = scratch("campaign_copied");
    plan(&folder, "c");
    for number in 0..3 {
        let machine = format!("machine-{number}");
        let (own, part) = (folder.join(&machine), format!("part-{number}-of-3.parquet"));
        fs::create_dir(&own).unwrap();
        fs::copy(folder.join("c/plan.json"), own.join("plan.json")).unwrap();
        let shard = format!("{number}/3");
        done(&folder, &["campaign", "run", &machine, "--shard", &shard]);
        fs::copy(own.join(&part), folder.join("c").join(&part)).unwrap();
    }
    assert!(merged(&folder, "c") == whole());
}

#[test]
fn a_missing_shard_is_named_and_merge_refuses_the_gap() {
    let folder = scratch("campaign_gap");
    plan(&folder, "c");
    let before = json(&folder, &["campaign", "status", "c"]);
    assert_eq!(
        (&before["rows"], &before["done"]),
        (&ROWS.into(), &0.into())
    );
    shards(&folder, 5, &[1, 3]);
    let status = json(&folder, &["campaign", "status", "c"]);
    assert_eq!(status["missing_shards"], serde_json::json!([1, 3]));
    assert_eq!(status["shards"], 5);
    let error = refused(&folder, &["campaign", "merge", "c", "-o", "t.parquet"]);
    assert!(
        error.contains("of 24 rows are missing, the first is row 1"),
        "{error}"
    );
    assert!(!folder.join("t.parquet").exists());
}

#[test]
fn merge_refuses_rows_that_stand_twice_and_parts_of_other_plans() {
    let folder = scratch("campaign_twice");
    plan(&folder, "c");
    shards(&folder, 1, &[]);
    shards(&folder, 4, &[0, 1, 2]);
    let error = refused(&folder, &["campaign", "merge", "c", "-o", "t.parquet"]);
    assert!(error.contains("stands in part"), "{error}");

    // A part of the same scenario under another campaign.
    let other = super::CAMPAIGN.replace("seed = 7", "seed = 8");
    fs::write(folder.join("campaign.toml"), other).unwrap();
    done(&folder, &words("campaign plan campaign.toml -o other"));
    fs::copy(
        folder.join("c/part-0-of-1.parquet"),
        folder.join("other/part-0-of-1.parquet"),
    )
    .unwrap();
    for command in ["run", "status"] {
        let error = refused(&folder, &["campaign", command, "other"]);
        assert!(error.contains("is of another plan"), "{error}");
    }
    // Half a part is no part.
    let part = folder.join("c/part-0-of-1.parquet");
    let bytes = fs::read(&part).unwrap();
    fs::write(&part, &bytes[..bytes.len() / 2]).unwrap();
    let error = refused(&folder, &["campaign", "run", "c"]);
    assert!(error.contains("is not a whole table"), "{error}");
}

/// Waits until a journal of the campaign has rows.
fn wait_for_rows(campaign: &Path) {
    let give_up = Instant::now() + Duration::from_secs(240);
    let rows = || {
        let files = fs::read_dir(campaign).unwrap().flatten();
        let journals = files.filter(|f| f.file_name().to_string_lossy().ends_with(".journal"));
        journals
            .map(|f| {
                fs::read_to_string(f.path())
                    .unwrap_or_default()
                    .lines()
                    .count()
            })
            .sum::<usize>()
    };
    // The first line says which plan it is.
    while rows() < 4 {
        assert!(Instant::now() < give_up, "no rows were written");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn start(folder: &Path) -> Running {
    let mut command = Command::new(softdock_binary());
    command
        .current_dir(folder)
        .args(["campaign", "run", "c", "--threads", "1"]);
    Running::start("campaign", &mut command)
}

#[test]
fn after_ctrl_c_the_same_command_goes_on() {
    let folder = scratch("campaign_interrupted");
    plan(&folder, "c");
    let running = start(&folder);
    wait_for_rows(&folder.join("c"));
    running.interrupt();
    let (status, log) = running.finish();
    // On a fast machine it may have been over before.
    if !status.success() {
        assert!(log.contains("the same command goes on"), "{log}");
        assert!(!folder.join("c/part-0-of-1.parquet").exists());
        let rest = json(&folder, &["campaign", "run", "c"]);
        assert!(rest["carried_out"].as_u64().unwrap() < ROWS - 2, "{rest}");
    }
    assert!(merged(&folder, "c") == whole());
    let again = json(&folder, &["campaign", "run", "c"]);
    assert_eq!(again["carried_out"], 0);
}

#[test]
fn after_a_kill_the_same_command_goes_on() {
    let folder = scratch("campaign_killed");
    plan(&folder, "c");
    let running = start(&folder);
    wait_for_rows(&folder.join("c"));
    running.signal("KILL");
    running.finish();
    // And a line that was cut off.
    let journal = fs::read_dir(folder.join("c")).unwrap().flatten();
    let journal = journal
        .map(|f| f.path())
        .find(|p| p.extension().is_some_and(|e| e == "journal"));
    if let Some(journal) = journal {
        let text = fs::read_to_string(&journal).unwrap();
        fs::write(&journal, format!("{text}23,completed,,200,1,,0.0")).unwrap();
    }
    let rest = json(&folder, &["campaign", "run", "c"]);
    assert_eq!(rest["rows"], ROWS);
    assert!(rest["carried_out"].as_u64().unwrap() <= ROWS - 3, "{rest}");
    assert!(merged(&folder, "c") == whole());
    // Nothing but plan and part is left.
    assert_eq!(fs::read_dir(folder.join("c")).unwrap().count(), 2);
}
