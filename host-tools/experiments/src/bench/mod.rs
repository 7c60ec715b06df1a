//! Benchmarks that print a score.

pub mod delay;
pub mod diagnose;
