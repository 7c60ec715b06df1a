//! Benchmarks that print a score.

pub mod diagnose;
