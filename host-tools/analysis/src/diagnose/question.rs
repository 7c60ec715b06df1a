//! The options of a diagnosis, as the stages get them.

use super::catalogue::{has, is_of_the_tool};
use super::watch::Watch;
use super::wrench::{Smooth, TestedHypothesis};
use softdock_physics::model::{Model, WrenchMeaning};
use std::sync::Arc;

/// The options of a diagnosis.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Question<'a> {
    /// Only this effect is tried.
    pub only: Option<&'a str>,
    /// Take the best fit of it although it is not significant.
    pub forced: bool,
    /// Only these are tried.
    pub among: Option<&'a [String]>,
    /// The user asked for these effects, and gets them whatever else is missing.
    pub asked: bool,
    /// These are not tried.
    pub without: &'a [String],
    /// Curves that fit many mechanisms are tried, too.
    pub general_curves: bool,
    /// All are tried beside this remainder.
    pub beside: Option<&'a Arc<Smooth>>,
    /// Instead of a search: other effects are tried in the place of each effect of this answer.
    pub in_place_of: Option<&'a TestedHypothesis>,
    /// All logs are parts of one log, so it is not asked whether they are of different machines.
    pub of_one_log: bool,
    /// Receives each hypothesis when it is tried.
    pub watch: Watch<'a>,
}

impl Question<'_> {
    /// Whether curves that fit many mechanisms are tried.
    pub(super) fn tries_general_curves(&self) -> bool {
        self.general_curves || self.is_asked()
    }

    /// Effects that are not tried if further ones are not.
    pub(super) fn also_without(&self, ids: &[String]) -> Vec<String> {
        self.without.iter().chain(ids).cloned().collect()
    }

    /// Whether a user asked for the effects that are tried.
    pub(super) fn is_asked(&self) -> bool {
        self.only.is_some() || self.asked
    }

    /// Whether a user asked for this effect.
    pub(super) fn asks_for(&self, id: &str) -> bool {
        let among = self.among.filter(|_| self.asked).unwrap_or_default();
        self.only == Some(id) || among.iter().any(|one| one == id)
    }

    /// Whether an effect is tried for a model. In a free swing errors of mass and inertia are not tried: all forces are in
    /// proportion to those of the model.
    pub(super) fn tries(&self, model: &Model, id: &str) -> bool {
        let among = self
            .among
            .is_none_or(|among| among.iter().any(|one| one == id));
        let without = self.without.iter().any(|one| one == id);
        let of_unknown_size = model.sensor.wrench == WrenchMeaning::Free && is_of_the_tool(id);
        !has(model, id)
            && among
            && !without
            && !of_unknown_size
            && self.only.is_none_or(|only| only == id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A search that is repeated without some effects does not try those again that were left out before.
    #[test]
    fn what_is_left_out_stays_out() {
        let before = ["bearing_gravity".to_owned()];
        let question = Question {
            without: &before,
            ..Question::default()
        };
        let late = ["ft_latency".to_owned()];
        let both = question.also_without(&late);
        let again = Question {
            without: &both,
            ..question
        };
        let tries = |id: &str| again.tries(&Model::default(), id);
        assert!(!tries("bearing_gravity") && !tries("ft_latency") && tries("guide_coulomb"));
    }
}
