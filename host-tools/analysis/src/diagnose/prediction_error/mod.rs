//! What is left of an error on data that no fit has seen, and the parameters that leave least of it.

pub(crate) mod error_reduction;
pub(crate) mod for_prediction;
pub(crate) mod foresight;
pub(crate) mod late_by_foretelling;
pub(crate) mod left_over;
pub(crate) mod log_to_log;
pub(crate) mod reversal;
