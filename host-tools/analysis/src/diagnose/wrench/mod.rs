//! What the reading of the sensor lacks, by regression on physical columns.

mod colour;
mod motions;
mod nuisance;
mod problem;
mod saturated;
mod search;
mod settle;
mod side;
mod stage;
mod sticking;
mod tested;
mod variants;

pub(crate) use motions::scene;
pub(crate) use problem::{Problem, Solution, subtract};

pub(crate) use side::{Side, sheet_sigma};
pub(crate) use stage::{Found, is_much, search};
pub(crate) use tested::{Fitted, Tested};

/// White noise of a standard deviation.
pub(crate) fn white(sigma: f64) -> colour::Colour {
    colour::Colour::white(sigma)
}
