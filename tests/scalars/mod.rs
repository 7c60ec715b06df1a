//! The same control code in f64, f32 and fixed point, at the edges of every declared range.

mod agree;
mod corrections;
mod declared_ranges;
mod hour_of_corrections;
mod ranges;
