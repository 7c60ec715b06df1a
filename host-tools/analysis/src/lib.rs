//! What recordings of docking tests and models of them say of each other.
//!
//! | module | |
//! |---|---|
//! | `import` | logs of other rigs |
//! | `compare`, `levels` | where the error is, and how large |
//! | `fit` | parameters of a model |
//! | `diagnose` | what is missing |
//! | `add` | writes effects that were found into the model |

pub mod add;
pub mod compare;
pub mod diagnose;
pub mod fit;
mod held_back;
pub mod import;
pub mod levels;
