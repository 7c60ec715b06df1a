//! Fuzzing without a fuzzer's tool chain, a minute for each target in the long run. See [`softdock_tests::fuzz`].

use softdock_tests::fuzz::TARGETS;
use softdock_tests::fuzz::driver::fuzz;
use std::time::Duration;

#[test]
fn every_target_holds_for_some_inputs() {
    for target in TARGETS {
        fuzz(target, |runs, _| runs < target.few);
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
