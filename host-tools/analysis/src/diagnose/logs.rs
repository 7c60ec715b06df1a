//! One value for each log, those of the fit and the unseen ones kept apart.

use softdock_physics::model::log::{Log, is_same_wrench};

/// Something for each log. The first ones are those of the fit, the others are unseen.
#[derive(Clone, Debug)]
pub struct Logs<T> {
    /// One entry per log.
    pub all: Vec<T>,
    /// Number of logs of the fit.
    pub fitted: usize,
}

impl<T> Logs<T> {
    /// From the values of the logs of the fit and of the unseen ones.
    pub fn new(fitted: Vec<T>, unseen: Vec<T>) -> Self {
        let count = fitted.len();
        let mut all = fitted;
        all.extend(unseen);
        Self { all, fitted: count }
    }

    /// Values of the logs of the fit.
    pub fn train(&self) -> &[T] {
        &self.all[..self.fitted]
    }

    /// Values of the unseen logs; of all logs where none is unseen.
    pub fn test(&self) -> &[T] {
        match &self.all[self.fitted..] {
            [] => &self.all,
            unseen => unseen,
        }
    }

    /// The value of the log that is drawn: the first unseen one, or the first one where none is unseen.
    pub fn shown(&self) -> &T {
        &self.test()[0]
    }

    /// Index of that log.
    pub(super) fn shown_number(&self) -> usize {
        self.fitted % self.all.len().max(1)
    }

    /// References to the values.
    pub(super) fn map_refs(&self) -> Logs<&T> {
        Logs {
            all: self.all.iter().collect(),
            fitted: self.fitted,
        }
    }

    /// Applies a function to each value.
    pub(super) fn map<U>(&self, of: impl FnMut(&T) -> U) -> Logs<U> {
        Logs {
            all: self.all.iter().map(of).collect(),
            fitted: self.fitted,
        }
    }

    /// Applies a function to all values in parallel.
    pub(super) fn map_at_once<U: Send>(&self, of: impl Fn(&T) -> U + Sync + Send) -> Logs<U>
    where
        T: Sync,
    {
        use rayon::prelude::*;
        Logs {
            all: self.all.par_iter().map(of).collect(),
            fitted: self.fitted,
        }
    }
}

impl<T> Logs<anyhow::Result<T>> {
    /// All values, or the first error.
    pub(super) fn transpose(self) -> anyhow::Result<Logs<T>> {
        Ok(Logs {
            all: self.all.into_iter().collect::<anyhow::Result<Vec<T>>>()?,
            fitted: self.fitted,
        })
    }
}

impl Logs<Log> {
    /// Whether all logs have the same load, which never changes. Then anything that predicts a constant from the motion has a
    /// small error, above all effects that are too small and cancel each other.
    pub(super) fn have_one_load(&self) -> bool {
        let each: Option<Vec<[f64; 6]>> = self.all.iter().map(Log::constant_wrench).collect();
        each.is_some_and(|each| each.iter().all(|one| is_same_wrench(each[0], *one)))
    }

    /// Whether a model of spacecraft ran in any.
    pub(super) fn have_spacecraft(&self) -> bool {
        self.all.iter().any(|log| log.has_spacecraft)
    }

    /// Whether the load changes in no log, though it may differ from log to log.
    pub(super) fn have_constant_loads(&self) -> bool {
        !self.all.iter().any(|log| log.wrench_changes)
    }

    /// Whether each log has an origin of its own, so that effects that act by position have other amounts in each.
    pub(super) fn have_own_origins(&self) -> bool {
        self.all.len() > 1 && self.all.iter().all(Log::has_own_origin)
    }
}
