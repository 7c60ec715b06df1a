//! Closed loops and laws with an answer that is known by calculation.

mod bench_delay;
mod bounce;
mod delay_energy;
mod docking;
mod free_flight;
mod rig_hidden;
mod rotating_q;
mod second_robot;
mod seed_formula;
mod seed_rig;
mod two_body;
mod wrench_cycle;
