//! Setting up a rig before its first docking test: what does the sensor carry, and how does the
//! robot follow? The answers go into the board's settings.

pub mod calibrate;
pub mod doctor;
pub mod fragment;
pub mod identify;
pub mod input;
pub mod live;
pub mod parameters;
