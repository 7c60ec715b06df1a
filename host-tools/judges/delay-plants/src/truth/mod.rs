//! The ideal test: what two free spacecraft would do, without a robot in between.

mod bodies;
mod bounce;

pub use bodies::{Body, FreeTest, Outcome, Twist};
pub use bounce::Bounce;
