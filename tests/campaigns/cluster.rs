//! Campaigns on HyperQueue and on Slurm, by the lines that the program prints: a node is killed in the middle, the rest is
//! done by the same line, and the table is that of one process.

use super::{merged, plan};
use softdock_tests::peers::python::peer;
use softdock_tests::process::{Running, done, forbidden, scratch};
use std::fs;
use std::path::Path;
use std::time::Duration;

/// Shards of the campaign.
const SHARDS: &str = "8";

/// Plans a campaign twice, carries one out in one process, and gives its table.
fn planned(folder: &Path) -> Vec<u8> {
    plan(folder, "whole");
    plan(folder, "c");
    done(folder, &["campaign", "run", "whole"]);
    merged(folder, "whole")
}

fn parts(campaign: &Path) -> usize {
    let files = fs::read_dir(campaign).unwrap().flatten();
    files
        .filter(|file| file.file_name().to_string_lossy().starts_with("part-"))
        .count()
}

#[test]
#[ignore = "long: campaigns on HyperQueue and Slurm, with a node killed on the way"]
fn hyperqueue_killed_and_called_again_gives_the_same_table() {
    let folder = scratch("campaign_hyperqueue");
    let whole = planned(&folder);
    let line = done(&folder, &["campaign", "hq", "c", "--shards", SHARDS]);
    let start = || {
        let mut command = peer("hyperqueue_campaign.py", &folder);
        Running::start("HyperQueue", command.arg(line.trim()))
    };
    let mut first = start();
    first.wait_for("submitted");
    while parts(&folder.join("c")) < 2 && first.heard("finished").is_none() {
        std::thread::sleep(Duration::from_millis(5));
    }
    // Server and workers are one process.
    first.signal("KILL");
    first.finish();
    let before = parts(&folder.join("c"));
    assert!(before >= 2);

    let mut second = start();
    second.wait_for("finished");
    let (status, log) = second.finish();
    assert!(status.success(), "{log}");
    assert_eq!(parts(&folder.join("c")), 8);
    assert!(merged(&folder, "c") == whole);
}

#[test]
#[ignore = "long: campaigns on HyperQueue and Slurm, with a node killed on the way"]
fn slurm_that_loses_a_node_gives_the_same_table() {
    let folder = scratch("campaign_slurm");
    let whole = planned(&folder);
    let line = done(&folder, &["campaign", "slurm", "c", "--shards", SHARDS]);
    let mut command = peer("slurm_campaign.py", &folder);
    command
        .arg(folder.join("slurm"))
        .arg(folder.join("c"))
        .arg(line.trim());
    let mut slurm = Running::start("Slurm", &mut command);
    let first = slurm.wait_for("");
    if let Some((_, what)) = first.split_once("FORBIDDEN ") {
        forbidden(what);
        slurm.finish_or_kill();
        return;
    }
    assert!(first.contains("Submitted batch job"), "{first}");
    slurm.wait_for("node n2 lost");
    slurm.wait_for("finished");
    let (status, log) = slurm.finish();
    assert!(status.success(), "{log}");
    assert!(merged(&folder, "c") == whole);
}
