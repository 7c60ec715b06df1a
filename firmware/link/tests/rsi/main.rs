//! RSI telegrams: known ones, any layout of them, damaged ones, and an independent reader.
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
