//! A benchmark as the base of a campaign: in shards, the same table.

use softdock_tests::process::{done, json, refused, scratch};
use std::fs;
use std::path::Path;

const DELAY: &str = r#"
bench = "delay"
cases = ["latency_0_unknown"]
laws = ["lead", "predictor"]

[[limits]]
outcome = "energy_error"
low = -0.05
high = 0.05
"#;

fn plan(folder: &Path, name: &str) {
    fs::write(folder.join("bench.toml"), DELAY).unwrap();
    done(folder, &["campaign", "plan", "bench.toml", "-o", name]);
}

#[test]
fn the_delay_benchmark_in_shards_is_the_same_table() {
    let folder = scratch("campaign_bench");
    let merged = |name: &str| {
        let file = format!("{name}.parquet");
        done(&folder, &["campaign", "merge", name, "-o", &file]);
        fs::read(folder.join(file)).unwrap()
    };
    plan(&folder, "whole");
    done(&folder, &["campaign", "run", "whole"]);
    plan(&folder, "shards");
    for shard in ["2/3", "0/3", "1/3"] {
        done(&folder, &["campaign", "run", "shards", "--shard", shard]);
    }
    assert!(merged("whole") == merged("shards"));
    let status = json(&folder, &["campaign", "status", "whole"]);
    assert_eq!((&status["rows"], &status["failed"]), (&6.into(), &0.into()));
    let said = refused(
        &folder,
        &["campaign", "rerun", "whole", "--index", "3", "-o", "x.mcap"],
    );
    assert!(
        said.contains("softdock bench delay --case latency_0_unknown --law predictor"),
        "{said}"
    );
}
