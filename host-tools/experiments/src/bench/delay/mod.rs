//! Every delay law on the same plants, through the board's own control cycle.
//!
//! The plants are those of `softdock-delay-plants`, which shares no code with the board. A case is data: a plant, and the
//! board's belief of it ([`cases`]). A row is a result: one law on one case at one speed, with the worst value over many
//! instants of the touch within a cycle. A new case is one more entry in a list.

pub mod case;
pub mod cases;
pub mod ideal;
pub mod limits;
mod marks;
pub mod measure;
pub mod page;
pub mod ranking;
pub mod row;
pub mod run;
pub mod scene;
pub mod tables;
pub mod trial;
