//! `softdock check` against simulations with plants that share no code with it.

mod files;
mod grid;
