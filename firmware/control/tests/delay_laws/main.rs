//! The delay laws in closed loop: the whole control cycle against plants that share no code with
//! it. Numbers to compare with come from the publications' laws in an earlier simulation with steps
//! of 0.5 ms; where a law here does better or worse, the test says why.

#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "that is how a test fails"
)]

#[path = "../closed_loop/mod.rs"]
mod closed_loop;

mod case;
mod pictures;
mod robustness;
mod running;
mod scenario_s;
mod space;
