//! The regression: hypotheses as whitened columns of all logs, their coefficients, shapes and tolerances.

pub(crate) mod fit;
pub(crate) mod fitted;
pub(crate) mod gauss_newton;
pub(crate) mod gram;
pub(crate) mod hypothesis;
pub(crate) mod joint;
pub(crate) mod memo;
pub(crate) mod motions;
pub(crate) mod nuisance;
pub(crate) mod prepared_log;
pub(crate) mod problem;
pub(crate) mod refined;
pub(crate) mod saturated;
pub(crate) mod shaped;
pub(crate) mod stiction;
pub(crate) mod tested;
pub(crate) mod variants;
