//! The unmodelled wrench: what the sensor felt, which effects explain it, and what they leave.

pub(crate) mod beside;
pub(crate) mod felt_motion;
pub(crate) mod finding;
pub(crate) mod left;
pub(crate) mod regression;
pub(crate) mod remainder;
pub(crate) mod rounds;
pub(crate) mod sampling;
pub(crate) mod search;

pub(crate) use regression::fitted::{Fitted, FittedParameter};
pub(crate) use regression::joint::{Joint, NominalEstimate, Smooth};
pub(crate) use regression::memo::Memo;
pub(crate) use regression::motions::scene;
pub(crate) use regression::prepared_log::{PreparedLog, sheet_sigma};
pub(crate) use regression::problem::{Problem, Segment, Solution, subtract};
pub(crate) use regression::tested::TestedHypothesis;
pub(crate) use remainder::{
    Remainder, Ripple, Standing, remainder, ripples, smooth, standings, worths,
};
pub(crate) use search::other_sign::{AfterMotion, OtherSign, after_motion, other_sign};
pub(crate) use search::{AmountByLog, Ask, Disagreement, SearchResult, exchanged, search};
