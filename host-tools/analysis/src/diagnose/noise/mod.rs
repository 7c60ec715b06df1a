//! What is noise, and what is not: its model, readings that are rounded, and the tests for structure.

pub(crate) mod autoregressive;
pub(crate) mod rounding;
pub(crate) mod structure;
