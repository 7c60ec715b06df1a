//! Fuzzing without a fuzzer's tool chain, a minute for each target in the long run. See [`softdock_tests::fuzz`].

use softdock_tests::fuzz::TARGETS;
use softdock_tests::fuzz::driver::fuzz;
use std::hash::{BuildHasher, Hasher, RandomState};
use std::time::Duration;

#[test]
fn every_target_holds_for_some_inputs() {
    for target in TARGETS {
        fuzz(target, 17, |runs, _| runs < target.few);
    }
}

#[test]
#[ignore = "long: a minute of fuzzing for each target"]
fn every_target_holds_for_a_minute() {
    // Other inputs each time; what fails is kept, and does not need the seed.
    let seed = RandomState::new().build_hasher().finish();
    for target in TARGETS {
        let runs = fuzz(target, seed, |_, took| took < Duration::from_secs(60));
        println!("{}: {runs} inputs", target.name);
    }
}
