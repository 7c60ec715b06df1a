//! The targets of [`softdock_tests::fuzz`] for libFuzzer, which is guided by coverage; `fuzz/run` builds and runs it.
//! One program for all of them: what it links is what takes the time.
#![no_main]

use libfuzzer_sys::fuzz_target;
use softdock_tests::fuzz::{TARGETS, Target};
use std::sync::LazyLock;

static TARGET: LazyLock<Target> = LazyLock::new(|| {
    let name = std::env::var("SOFTDOCK_FUZZ").unwrap_or_default();
    let found = TARGETS.into_iter().find(|target| target.name == name);
    let known = TARGETS.map(|target| target.name);
    found.unwrap_or_else(|| panic!("SOFTDOCK_FUZZ: expected one of {known:?}, received {name:?}"))
});

fuzz_target!(|input: &[u8]| (TARGET.run)(input));
