//! The unmodelled wrench, by regression on physical columns.

mod autoregressive;
mod fits;
mod fitted;
mod gram;
mod joint;
mod model_selection;
mod motions;
mod nuisance;
mod other_sign;
mod prepared_log;
mod problem;
mod refined;
mod remainder;
mod saturated;
mod search;
mod shaped;
mod stage;
mod stiction;
mod tested;
mod variants;

pub(crate) use fits::Fits;
pub(crate) use fitted::Fitted;
pub(crate) use motions::scene;
pub(crate) use problem::{Problem, Segment, Solution, subtract};

pub(crate) use joint::{Joint, Rest};
pub(crate) use other_sign::{OtherSign, other_sign};
pub(crate) use prepared_log::{PreparedLog, sheet_sigma};
pub(crate) use remainder::{
    Remainder, Ripple, Smooth, Standing, remainder, ripples, smooth, standings, worths,
};
pub(crate) use stage::{Ask, Disagreement, Found, exchanged, search};
pub(crate) use tested::Tested;

/// White noise of a standard deviation.
pub(crate) fn white(sigma: f64) -> autoregressive::AutoregressiveNoise {
    autoregressive::AutoregressiveNoise::white(sigma)
}
