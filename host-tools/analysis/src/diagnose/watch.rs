//! A listener that follows the search for an answer.

use super::finding::Trial;

/// A listener for hypotheses. Searches run on several threads, and call it from each of them.
#[derive(Clone, Copy, Default)]
pub(crate) struct Watch<'a>(pub Option<&'a (dyn Fn(&Trial) + Sync)>);

impl Watch<'_> {
    /// Reports a hypothesis if there is a listener.
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
