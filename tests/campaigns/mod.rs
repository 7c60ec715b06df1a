//! Campaigns: the same table however the rows were divided, stopped and carried out.

mod bench;
mod cluster;
mod command;
mod division;
mod store;
mod story;

use serde_json::Value;
use softdock_tests::process::{done, json};
use std::fs;
use std::path::Path;

/// Twelve draws, two laws each.
const CAMPAIGN: &str = r#"
title = "Twelve draws"
scenario = "scenario.toml"
samples = 12
seed = 7
design = "latin_hypercube"
outcomes = ["restitution", "peak_force_n"]

[[factors]]
name = "speed_m_s"
setting = "board.control.body_k.velocity_m_s[0]"
uniform = [0.005, 0.02]

[[factors]]
name = "tip_m"
setting = "rig.mechanism.walls[0].tip_m[1]"
normal = { mean = 0.0, sigma = 0.02 }

[[factors]]
name = "law"
setting = "board.control.delay.law"
list = ["none", "predictor"]

[[limits]]
outcome = "restitution"
low = 0.9
high = 1.1
"#;
/// Rows of it.
const ROWS: u64 = 24;

/// The scenario, shorter and nearer.
fn scenario() -> String {
    let spring_rod = include_str!("../../host-tools/scenarios/spring-rod.toml");
    let near = spring_rod.replace("[1.2045, 0.1, 0.9]", "[1.2010, 0.1, 0.9]");
    near.replace("duration_s = 3.0", "duration_s = 0.8")
}

/// Plans the campaign as `name` in a folder.
fn plan(folder: &Path, name: &str) -> Value {
    fs::write(folder.join("scenario.toml"), scenario()).unwrap();
    fs::write(folder.join("campaign.toml"), CAMPAIGN).unwrap();
    json(folder, &["campaign", "plan", "campaign.toml", "-o", name])
}

/// The merged table of a campaign, byte by byte.
fn merged(folder: &Path, name: &str) -> Vec<u8> {
    let table = format!("{name}.parquet");
    done(
        folder,
        &["campaign", "merge", name, "-o", &table, "--force"],
    );
    fs::read(folder.join(table)).unwrap()
}
