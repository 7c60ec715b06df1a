//! The simulated spacecraft as the rig computes it, and the clock that its cycle assumes.

pub mod clock_jitter;
pub mod clock_offset;
pub mod clock_rate;
pub mod sc_inertia_error;
pub mod sc_mass_error;
