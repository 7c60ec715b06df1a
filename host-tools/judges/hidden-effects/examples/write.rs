//! Writes cases as folders (`meta.json`, `train.csv`, `test.csv`) plus one `truth.json`:
//! `cargo run --release -p softdock-hidden-effects --example write -- DIR [SEED] [COUNT|ladder|nulls]`.
//! Prints one line per case: level, size, effects, z on the test log with and without them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use softdock_hidden_effects::{
    Case, CaseSpec, Truth, nothing_hidden, size_sweep, suite, truth_json,
};

/// Cases with nothing hidden that are written.
const NULLS: usize = 300;

fn main() -> ExitCode {
    match write(std::env::args().skip(1)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(what) => {
            eprintln!("{what}");
            ExitCode::FAILURE
        }
    }
}

fn write(mut arguments: impl Iterator<Item = String>) -> Result<(), String> {
    let usage = "usage: write DIR [SEED] [COUNT|ladder|nulls]";
    let directory = PathBuf::from(arguments.next().ok_or(usage)?);
    let seed = match arguments.next() {
        Some(text) => number(&text, "SEED")?,
        None => 1,
    };
    let specs: Vec<CaseSpec> = match arguments.next().as_deref() {
        Some("ladder") => size_sweep(seed),
        Some("nulls") => nothing_hidden(seed, NULLS),
        Some(text) => {
            let count = usize::try_from(number(text, "COUNT")?).unwrap_or(usize::MAX);
            suite(seed).into_iter().take(count).collect()
        }
        None => suite(seed),
    };
    let mut truths: Vec<(String, Truth)> = Vec::with_capacity(specs.len());
    for spec in &specs {
        let case = spec.generate();
        write_case(&directory, &case)?;
        print_case(&case);
        truths.push((case.name, case.truth));
    }
    let text = truth_json(truths.iter().map(|(name, truth)| (name.as_str(), truth)));
    save(&directory.join("truth.json"), &text)
}

fn number(text: &str, what: &str) -> Result<u64, String> {
    text.parse()
        .map_err(|_| format!("{what}: expected a whole number, found `{text}`"))
}

fn write_case(directory: &Path, case: &Case) -> Result<(), String> {
    let folder = directory.join(&case.name);
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    save(&folder.join("meta.json"), &case.meta_json)?;
    save(&folder.join("train.csv"), &case.train_csv)?;
    save(&folder.join("test.csv"), &case.test_csv)
}

fn save(path: &Path, text: &str) -> Result<(), String> {
    fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))
}

fn print_case(case: &Case) {
    let truth = &case.truth;
    let z = |z: &[f64; 4]| z.map(|v| format!("{v:8.3}")).join("");
    println!(
        "{:28} {:22} {:5.2} {} |{}  {}",
        case.name,
        format!("{:?}", truth.level),
        truth.size,
        z(&truth.z_nominal_test),
        z(&truth.z_oracle_test),
        truth.effects.join(" + "),
    );
}
