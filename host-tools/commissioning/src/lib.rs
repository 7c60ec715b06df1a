//! Setting up a rig before its first docking test: what does the sensor carry, and how does the
//! robot follow? The answers go into the board's settings.
//!
//! | module | |
//! |---|---|
//! | `calibrate` | mass, centre and zero of what the sensor carries, from poses at rest |
//! | `identify` | delay, lag and pause of the robot, from jogs |
//! | `fragment` | what was found, as lines of a settings file |
//! | `parameters` | a board's settings over its serial port |
//! | `doctor` | whether a rig is ready: from its settings, a recording, or live |
//! | `live`, `input` | a running board with its recorder; a recording or a CSV file |

pub mod calibrate;
pub mod doctor;
pub mod fragment;
pub mod identify;
pub mod input;
pub mod live;
pub mod parameters;
