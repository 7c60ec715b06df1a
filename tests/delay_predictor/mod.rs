//! The predictor in the real control cycle, in closed loop with plants that share no code with it.
//!
//! The bounds are those that the law is built for, not what it happens to reach; the measured
//! numbers stand in `docs/delay/predictor.md`, and `-- --nocapture` prints them.

mod actuators;
mod case;
mod confidence;
mod damping;
mod delay_tracking;
mod feedback;
mod invariants;
mod repeated;
mod run;
mod scenario_s;
pub(crate) mod space;
