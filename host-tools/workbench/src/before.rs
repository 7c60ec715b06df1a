//! Texts of model files before they were changed, for undoing.

use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// For each model file the text before its last change by the page, and the fingerprint of the text after it.
#[derive(Default)]
pub(super) struct Before(Mutex<HashMap<String, [String; 2]>>);

impl Before {
    fn all(&self) -> MutexGuard<'_, HashMap<String, [String; 2]>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn keep(&self, id: &str, if_match: &str, text: &str) {
        let pair = [if_match, text].map(str::to_owned);
        self.all().insert(id.to_owned(), pair);
    }

    pub(super) fn text(&self, id: &str, if_match: &str) -> Option<String> {
        let all = self.all();
        let [after, text] = all.get(id)?;
        (after == if_match).then(|| text.clone())
    }
}
