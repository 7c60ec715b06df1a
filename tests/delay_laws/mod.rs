//! The delay laws in closed loop: the whole control cycle against plants that share no code with
//! it. Numbers to compare with come from the publications' laws in an earlier simulation with steps
//! of 0.5 ms; where a law here does better or worse, the test says why.

pub(crate) mod case;
mod energy;
mod pictures;
mod robustness;
mod running;
mod scenario_s;
mod space;
