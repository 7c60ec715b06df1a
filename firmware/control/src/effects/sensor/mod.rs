//! What the force/torque sensor adds to the contact wrench, and how it reads it.
//!
//! The sensor reads the **load's reaction**: `reading = contact + m g − m a_com`, everything in the
//! sensor's frame S, torques about its origin.

pub mod bias_drift;
pub mod gauge_quantisation;
pub mod low_pass;
pub mod tool_gravity;
pub mod tool_inertia;
