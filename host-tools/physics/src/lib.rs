//! The physics of a docking rig as far as a log shows it.
//!
//! | module | |
//! |---|---|
//! | `effects` | the catalogue of physical effects, one file each |
//! | `model` | the model file, its effects, and what it predicts |
//! | `optimise` | minima of one number and of many |

pub mod effects;
pub mod model;
pub mod optimise;
