//! Who follows the search for an answer.

use super::finding::Trial;

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
