//! The reports of what the analysis found: pages to look at and to send to a colleague.

pub mod calibration;
pub mod comparison;
pub mod diagnosis;
pub mod identification;
