//! Fuzzing without a fuzzer's tool chain: each target of `targets` takes any bytes and must not panic, hang or break
//! what it promises. The bytes come of the corpus, mutated; a minute each in the long run.
//!
//! A coverage-guided fuzzer calls the same functions: they take a slice and answer nothing. What was ever found stays in
//! the corpus, which every run begins with.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a target that finds something fails the test"
)]

mod driver;
mod service;
mod session;
mod targets;

use driver::fuzz;
use std::time::Duration;
use targets::TARGETS;

/// So many inputs of each: a second or two.
const FEW: u64 = 2_000;

#[test]
fn every_target_holds_for_some_inputs() {
    for target in TARGETS {
        fuzz(target, |runs, _| runs < FEW);
    }
}

#[test]
#[ignore = "long: a minute of fuzzing for each target"]
fn every_target_holds_for_a_minute() {
    for target in TARGETS {
        let runs = fuzz(target, |_, took| took < Duration::from_secs(60));
        println!("{}: {runs} inputs", target.name);
    }
}
