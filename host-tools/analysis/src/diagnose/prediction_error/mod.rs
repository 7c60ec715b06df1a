//! The error on unseen data: by how much named effects reduce it, and with which parameters most.

pub(crate) mod brakes;
pub(crate) mod error_reduction;
pub(crate) mod for_prediction;
pub(crate) mod foresight;
pub(crate) mod late_by_foretelling;
pub(crate) mod left_over;
pub(crate) mod log_to_log;
mod misleading_amounts;
pub(crate) mod noise_of_motion;
pub(crate) mod reversal;
