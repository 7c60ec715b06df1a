//! Effects that a user has added to the model, and the history of the error.

mod allowed;
mod check;
mod error;

pub use allowed::{Allowed, allowed_parameters};
pub use error::EffectError;

use super::Axis;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// One `[[effect]]` of `model.toml`: a physical effect of the catalogue with its parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectModel {
    /// Its id in the catalogue.
    pub id: String,
    /// Axes that have it; empty: all on which it can act.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub axes: Vec<Axis>,
    /// Its parameters by name; the unit stands in the name.
    pub parameters: BTreeMap<String, f64>,
    /// 95 % interval of each fitted parameter: low, high.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub interval_95: BTreeMap<String, [f64; 2]>,
    /// The recording that the parameters were fitted on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fitted_on: Option<String>,
}

impl EffectModel {
    /// Whether its parameters come from a fit, not from a person.
    pub fn was_fitted(&self) -> bool {
        !self.interval_95.is_empty()
    }
}

/// One `[[history]]` of `model.toml`: the error after a step, in units of the noise.
///
/// The error is the root of the sum of squares over the four channels, each in units of the data
/// sheet's noise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HistoryStep {
    /// What was done: the id of the effect that was added, [`Self::NOMINAL`], [`Self::REFIT`] or
    /// [`Self::EDITED`].
    pub effect: String,
    /// The recording that the step was fitted on.
    pub train: String,
    /// Error on it, relative to the noise.
    pub train_error: f64,
    /// The recording that the fit has not seen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub test: Option<String>,
    /// Error on it, relative to the noise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub test_error: Option<f64>,
}

impl HistoryStep {
    /// The model before the first step on these recordings.
    pub const NOMINAL: &str = "nominal";
    /// All parameters were fitted together.
    pub const REFIT: &str = "refit";
    /// The file was changed by hand since the step before.
    pub const EDITED: &str = "edited";
}
