//! Campaigns in an object store, here a file system: what the page says, the same bytes as in a folder, an upload that is
//! killed, and what merge refuses.

use super::{ROWS, division, plan};
use softdock_tests::process::{Running, done, json, refused, scratch, softdock_binary};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const PAGE: &str = include_str!("../../docs/campaigns.md");

/// A folder with the campaign's file, and the address of a store in it.
fn store(test: &str) -> (PathBuf, String) {
    let folder = scratch(test);
    plan(&folder, "folder");
    let address = format!("file://{}/store", folder.display());
    (folder, address)
}

fn planned(folder: &Path, address: &str) {
    done(
        folder,
        &["campaign", "plan", "campaign.toml", "-o", address],
    );
}

/// A run whose journals have a folder of their own; it dies where it writes a file of more than `blocks`.
fn limited(folder: &Path, address: &str, blocks: u32) -> Command {
    let mut command = Command::new("sh");
    command.current_dir(folder).env("XDG_CACHE_HOME", folder);
    let line =
        format!("ulimit -c 0; ulimit -f {blocks}; exec \"$0\" campaign run {address} --json");
    command.args(["-c", &line]).arg(softdock_binary());
    command
}

/// The commands of the page, with a file system in place of the bucket, and three machines in place of four hundred.
#[test]
fn the_recipe_of_the_page_leads_to_the_same_table() {
    let (folder, address) = store("campaign_store_page");
    let recipe = PAGE.split("```sh\n").find(|text| text.contains("-o s3://"));
    let recipe = recipe.and_then(|text| text.split("```").next()).unwrap();
    for line in recipe.lines() {
        let command = line.split('#').next().unwrap().trim();
        let command = command.strip_prefix("softdock ").unwrap();
        let command = command.replace("s3://bucket/campaign", &address);
        let shards = match command.contains("3/400") {
            true => vec!["2/3", "0/3", "1/3"],
            false => vec![""],
        };
        for shard in shards {
            let command = command.replace("3/400", shard);
            done(&folder, &command.split(' ').collect::<Vec<_>>());
        }
    }
    assert!(fs::read(folder.join("results.parquet")).unwrap() == division::whole());
}

/// Plan and parts alone are in the store, and each shard is carried out once.
#[test]
fn one_shard_in_a_store_gives_the_same_table() {
    let (folder, address) = store("campaign_store_whole");
    planned(&folder, &address);
    done(&folder, &["campaign", "run", &address, "--shard", "0/1"]);
    let names = fs::read_dir(folder.join("store")).unwrap();
    let mut names: Vec<_> = names.map(|file| file.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["part-0-of-1.parquet", "plan.json"]);
    let again = json(&folder, &["campaign", "run", &address]);
    assert_eq!(
        (&again["rows"], &again["carried_out"]),
        (&ROWS.into(), &0.into())
    );
    let merge = ["campaign", "merge", &address, "-o", "t.parquet"];
    let said = done(&folder, &merge);
    assert!(
        said.contains(&format!("campaign rerun {address} --index")),
        "{said}"
    );
    assert!(fs::read(folder.join("t.parquet")).unwrap() == division::whole());
    // A row is compared with the one in the store.
    let rerun = [
        "campaign", "rerun", &address, "--index", "5", "-o", "r.mcap",
    ];
    let said = done(&folder, &rerun);
    assert!(said.contains("bit for bit the row in part 0/1"), "{said}");
    // Not even with --force.
    let part = folder.join("store/part-0-of-1.parquet");
    let merge = [
        "campaign",
        "merge",
        &address,
        "--force",
        "-o",
        part.to_str().unwrap(),
    ];
    let error = refused(&folder, &merge);
    assert!(error.contains("is read by this command"), "{error}");
}

/// The system kills it in the middle of the upload: then there is no part, and the rows are not computed again.
#[test]
fn an_upload_that_is_killed_leaves_no_part() {
    let (folder, address) = store("campaign_store_killed");
    planned(&folder, &address);
    // A journal is shorter than that, a part longer.
    let killed = Running::start("campaign", &mut limited(&folder, &address, 16));
    let (status, log) = killed.finish();
    assert!(!status.success(), "{log}");
    let status = json(&folder, &["campaign", "status", &address]);
    assert_eq!((&status["done"], &status["shards"]), (&0.into(), &1.into()));
    let error = refused(&folder, &["campaign", "merge", &address, "-o", "t.parquet"]);
    assert!(error.contains("rows are missing"), "{error}");

    let again = Running::start("campaign", &mut limited(&folder, &address, 10_000));
    let (status, log) = again.finish();
    assert!(status.success(), "{log}");
    assert!(log.contains("\"carried_out\": 0"), "{log}");
    done(&folder, &["campaign", "merge", &address, "-o", "t.parquet"]);
    assert!(fs::read(folder.join("t.parquet")).unwrap() == division::whole());
}

#[test]
fn gaps_doubles_and_parts_of_another_plan_are_refused() {
    let (folder, address) = store("campaign_store_refused");
    planned(&folder, &address);
    // Nobody plans over it.
    let error = refused(
        &folder,
        &["campaign", "plan", "campaign.toml", "-o", &address],
    );
    assert!(error.contains("exists already"), "{error}");
    division::refuses(&folder, &address, "store");
}

#[test]
fn an_address_without_a_campaign_says_how_to_plan_one() {
    let (folder, address) = store("campaign_store_empty");
    let error = refused(&folder, &["campaign", "status", &address]);
    assert!(
        error.contains(&format!("plan CAMPAIGN.toml -o {address}")),
        "{error}"
    );
    let line = {
        planned(&folder, &address);
        done(&folder, &["campaign", "slurm", &address, "--shards", "4"])
    };
    assert!(
        line.contains(&format!("campaign run {address} --shard")),
        "{line}"
    );
}
