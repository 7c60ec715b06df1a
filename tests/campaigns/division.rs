//! One shard, many shards, stopped and resumed: the same bytes; and what merge refuses.

use super::{ROWS, merged, plan};
use softdock_tests::process::{Running, done, json, scratch, softdock, softdock_binary};
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

#[test]
fn the_table_does_not_depend_on_how_the_rows_are_divided() {
    let folder = scratch("campaign_divided");
    plan(&folder, "c");
    for number in 0..7 {
        let shard = format!("{number}/7");
        done(
            &folder,
            &["campaign", "run", "c", "--shard", &shard, "--threads", "2"],
        );
    }
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

/// Of a campaign that is planned at `place`, which keeps its files in `kept`: the missing shard is named, and gaps, rows
/// that stand twice, parts of other plans and half a part are refused.
pub(super) fn refuses(folder: &Path, place: &str, kept: &str) {
    let run = |shard: &str| {
        done(folder, &["campaign", "run", place, "--shard", shard]);
    };
    let merge = ["campaign", "merge", place, "-o", "t.parquet"];
    run("0/2");
    let status = json(folder, &["campaign", "status", place]);
    assert_eq!(status["missing_shards"], serde_json::json!([1]));
    assert_eq!(status["shards"], 2);
    softdock(folder, &merge).refused(&["12 of 24 rows are missing, the first is row 1"]);
    assert!(!folder.join("t.parquet").exists());
    run("0/4");
    run("1/2");
    softdock(folder, &merge).refused(&["row 0 stands in part 0/2 and in part 0/4"]);

    // A part of the same scenario under another campaign.
    let other = super::CAMPAIGN.replace("seed = 7", "seed = 8");
    fs::write(folder.join("campaign.toml"), other).unwrap();
    let other = format!("{place}-other");
    done(folder, &["campaign", "plan", "campaign.toml", "-o", &other]);
    let part = folder.join(kept).join("part-0-of-2.parquet");
    let copied = format!("{kept}-other/part-0-of-2.parquet");
    fs::copy(&part, folder.join(copied)).unwrap();
    for command in [&["run", "--shard", "0/2"][..], &["status"]] {
        let arguments = [&["campaign"], command, &[&other]].concat();
        softdock(folder, &arguments).refused(&["is of another plan"]);
    }
    // Half a part is no part.
    let bytes = fs::read(&part).unwrap();
    fs::write(&part, &bytes[..bytes.len() / 2]).unwrap();
    softdock(folder, &["campaign", "run", place, "--shard", "0/2"])
        .refused(&["is not a whole table"]);
}

#[test]
fn gaps_doubles_and_parts_of_another_plan_are_refused() {
    let folder = scratch("campaign_other_parts");
    plan(&folder, "c");
    let before = json(&folder, &["campaign", "status", "c"]);
    assert_eq!(
        (&before["rows"], &before["done"]),
        (&ROWS.into(), &0.into())
    );
    refuses(&folder, "c", "c");
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
