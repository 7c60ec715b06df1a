//! From what the stages found to an answer: verdict, rivals, probabilities, and what is said of them.

pub(crate) mod closest_rival;
pub(crate) mod equivalent;
pub(crate) mod notes;
pub(crate) mod outcome;
pub(crate) mod ranking;
pub(crate) mod regions;
pub(crate) mod sentence;
mod smoothing;
pub(crate) mod unaccounted;
pub(crate) mod verdict;
mod weight;
