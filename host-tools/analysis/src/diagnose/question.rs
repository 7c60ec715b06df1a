//! What is asked of the stages, and who follows the search for an answer.

use super::engine::has;
use super::finding::Trial;
use super::wrench;
use softdock_physics::model::Model;
use std::sync::Arc;

/// What is asked of the stages.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Question<'a> {
    /// Only this effect is tried.
    pub only: Option<&'a str>,
    /// Take the best fit of it although it is not significant.
    pub forced: bool,
    /// Only these are tried.
    pub among: Option<&'a [String]>,
    /// A user asked for these, and gets them whatever else there is.
    pub asked: bool,
    /// These are not tried.
    pub without: &'a [String],
    /// Curves that fit many mechanisms are tried, too.
    pub shapes: bool,
    /// All are tried beside this remainder.
    pub beside: Option<&'a Arc<wrench::Smooth>>,
    /// Nothing is searched: others are tried in the place of each effect of this answer.
    pub in_place_of: Option<&'a wrench::Tested>,
    /// All logs are parts of one, of which it makes no sense to say that they are of different machines.
    pub of_one_log: bool,
    /// Is told each hypothesis that was tried.
    pub watch: Watch<'a>,
}

/// Somebody who follows a search. Searches run on several threads, and tell from each of them.
#[derive(Clone, Copy, Default)]
pub(crate) struct Watch<'a>(pub Option<&'a (dyn Fn(&Trial) + Sync)>);

impl Watch<'_> {
    /// Tells a hypothesis, if somebody listens.
    pub(super) fn tell(self, trial: impl FnOnce() -> Trial) {
        if let Some(told) = self.0 {
            told(&trial());
        }
    }
}

impl std::fmt::Debug for Watch<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Watch({})", self.0.is_some())
    }
}

impl Question<'_> {
    /// Whether curves that fit many mechanisms are tried.
    pub(super) fn tries_shapes(&self) -> bool {
        self.shapes || self.is_asked()
    }

    /// Whether a user asked for what is tried.
    pub(super) fn is_asked(&self) -> bool {
        self.only.is_some() || self.asked
    }

    /// Whether a user asked for this effect.
    pub(super) fn asks_for(&self, id: &str) -> bool {
        let among = self.among.filter(|_| self.asked).unwrap_or_default();
        self.only == Some(id) || among.iter().any(|one| one == id)
    }

    /// Whether an effect is tried for a model.
    pub(super) fn tries(&self, model: &Model, id: &str) -> bool {
        let among = self
            .among
            .is_none_or(|among| among.iter().any(|one| one == id));
        let without = self.without.iter().any(|one| one == id);
        !has(model, id) && among && !without && self.only.is_none_or(|only| only == id)
    }
}
