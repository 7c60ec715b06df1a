//! What else may stand in the place of what was found.

use super::model_selection::{Rival, rivals};
use super::{SearchState, TRIED_LATER, without};
use crate::diagnose::wrench::regression::hypothesis::{Hypothesis, Part, with_one_more};
use crate::diagnose::wrench::regression::tested::TestedHypothesis;
use std::collections::BTreeSet;
use std::sync::PoisonError;

impl SearchState<'_> {
    /// The best rivals with as many effects, if there are more than two. (Hypotheses of one or two effects are all listed from
    /// the beginning of a search.) The climb may not have tried others in the place of each effect.
    pub(crate) fn alike(&self, accepted: &TestedHypothesis) -> Vec<TestedHypothesis> {
        match accepted.effects.len() < 3 {
            true => Vec::new(),
            false => self.exchanges(accepted, TRIED_LATER),
        }
    }

    /// The best hypotheses with as many effects as the accepted one, after trying some others in each place.
    pub(crate) fn exchanges(
        &self,
        accepted: &TestedHypothesis,
        others_each: usize,
    ) -> Vec<TestedHypothesis> {
        let count = accepted.effects.len();
        let parts = self.parts(accepted);
        for place in 0..count {
            let others = with_one_more(self.library, &without(&parts, place), self.price);
            self.tested(&others, others_each);
        }
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let alike = known.values().filter(|t| t.effects.len() == count);
        let mut alike: Vec<TestedHypothesis> =
            alike.filter(|t| self.is_possible(t)).cloned().collect();
        alike.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        let mut seen = BTreeSet::new();
        alike.retain(|t| seen.insert(t.effects_in_order()));
        alike.truncate(1 + 2 * others_each);
        alike
    }

    /// Replaces an effect of several amounts by two that it is confused with, chosen one after the other: over a small angle the
    /// weight of a link is a spring and an offset.
    pub(crate) fn in_twos(&self, accepted: &TestedHypothesis) -> Vec<TestedHypothesis> {
        let parts = self.parts(accepted);
        let in_twos = |place: usize| -> Option<Hypothesis> {
            let effect = self.library.variants[parts[place].variant].effect;
            let is_confused = |hypothesis: &Hypothesis| {
                let last = hypothesis.parts.last();
                let id = last.map(|part| self.library.variants[part.variant].effect.id);
                id.is_some_and(|id| effect.effect.confused_with.contains(&id))
            };
            let one_more = |beside: &[Part]| {
                let more = with_one_more(self.library, beside, self.price);
                more.into_iter().find(is_confused)
            };
            let asked = effect.coefficients.len() > 1;
            let one = asked.then(|| one_more(&without(&parts, place))).flatten()?;
            one_more(&one.parts)
        };
        let both: Vec<Hypothesis> = (0..parts.len()).filter_map(in_twos).collect();
        let tested = self.tested(&both, both.len()).into_iter();
        tested.filter(|t| self.is_possible(t)).collect()
    }

    pub(crate) fn rivals(&self, accepted: &TestedHypothesis) -> Vec<Rival> {
        rivals(self.library, accepted, self.price, &|h| {
            self.tested(h, TRIED_LATER)
        })
    }
}
