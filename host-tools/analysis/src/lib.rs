//! What recordings of docking tests and models of them say of each other.
//!
//! | module | |
//! |---|---|
//! | `import` | logs of other rigs |
//! | `compare`, `diagnose`, `fit` | how large the error is, what is missing, how large that is |

pub mod compare;
pub mod diagnose;
pub mod fit;
pub mod import;
