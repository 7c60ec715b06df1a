//! Recordings of docking tests, models of them, and what the one says of the other.
//!
//! | module | |
//! |---|---|
//! | `recording`, `telemetry`, `replay` | cycles on disk and over the network, recomputed bit for bit |
//! | `import` | logs of other rigs |
//! | `effects` | the catalogue of physical effects, one file each |
//! | `model` | the model file, its effects, and what it predicts |
//! | `compare`, `diagnose`, `fit` | how large the error is, what is missing, how large that is |
//! | `data_table` | tables that other programs read: CSV and Parquet |
//! | `input`, `output`, `identity`, `optimise` | what they share |

pub mod compare;
pub mod data_table;
pub mod diagnose;
pub mod effects;
pub mod fit;
pub mod identity;
pub mod import;
pub mod input;
pub mod model;
pub mod optimise;
pub mod output;
pub mod recording;
pub mod replay;
pub mod telemetry;
