//! RSI telegrams: known ones, arbitrary layouts, damaged ones, and an independent parser.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a helper of a test fails the test"
)]

mod answer;
mod damage;
mod known;
mod layout;
mod reference;
