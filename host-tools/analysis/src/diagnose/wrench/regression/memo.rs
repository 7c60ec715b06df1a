//! What the searches of one diagnosis have computed before: they come upon the same hypotheses, and the same columns, again and again.

use super::problem::Projected;
use super::tested::TestedHypothesis;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Values that one generation of columns holds at most, 16 MB. A column that is needed again is needed soon.
const MOST_VALUES: usize = 2 << 20;

/// All on which a result depends. The logs enter by the bits of what is left of them, which no other problem shares.
pub(crate) type Key = Vec<u64>;

/// Whitened columns of an effect; `None` where it has nothing to act on.
pub(crate) type Built = Option<Arc<[Projected]>>;

/// The memo of one diagnosis.
#[derive(Default)]
pub(crate) struct Memo {
    fits: Mutex<HashMap<Key, TestedHypothesis>>,
    columns: Mutex<Generations>,
}

/// Columns that were asked for lately (`young`), and those of the generation before (`old`), which are dropped when `young` is
/// full.
#[derive(Default)]
struct Generations {
    young: HashMap<Key, Built>,
    old: HashMap<Key, Built>,
    values: usize,
}

impl Memo {
    /// A fit that was made before, or is made now.
    pub(crate) fn fit(&self, key: Key, fit: impl FnOnce() -> TestedHypothesis) -> TestedHypothesis {
        let known = locked(&self.fits).get(&key).cloned();
        known.unwrap_or_else(|| {
            let fit = fit();
            locked(&self.fits).insert(key, fit.clone());
            fit
        })
    }

    /// Columns that were evaluated before, or are now.
    pub(crate) fn columns(&self, key: Key, evaluate: impl FnOnce() -> Built) -> Built {
        let known = locked(&self.columns).find(&key);
        known.unwrap_or_else(|| {
            let built = evaluate();
            locked(&self.columns).keep(key, built.clone());
            built
        })
    }
}

impl Generations {
    fn find(&mut self, key: &Key) -> Option<Built> {
        if let Some(built) = self.young.get(key) {
            return Some(built.clone());
        }
        let (key, built) = self.old.remove_entry(key)?;
        self.keep(key, built.clone());
        Some(built)
    }

    fn keep(&mut self, key: Key, built: Built) {
        let values = |built: &Built| -> usize {
            let columns = built.iter().flat_map(|columns| columns.iter());
            columns.flat_map(|c| &c.column.0).map(Vec::len).sum()
        };
        self.values += values(&built);
        if self.values > MOST_VALUES {
            self.values = values(&built);
            self.old = std::mem::take(&mut self.young);
        }
        self.young.insert(key, built);
    }
}

fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}
