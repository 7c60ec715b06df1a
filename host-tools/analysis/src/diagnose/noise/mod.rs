//! Noise: its model, rounded readings, and tests that tell it from structure.

pub(crate) mod autoregressive;
pub(crate) mod rounding;
pub(crate) mod structure;
