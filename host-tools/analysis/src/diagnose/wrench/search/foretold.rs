//! The last steps of a search: keeps effects that are worth their price beside each other and that foretell logs which no fit has
//! seen.

use super::model_selection::with_forms_reselected;
use super::{SearchState, TRIED, without};
use crate::diagnose::evidence::{FORETELLS, NAMED, TOLD_APART};
use crate::diagnose::wrench::regression::fit::fitted_to;
use crate::diagnose::wrench::regression::hypothesis::{Hypothesis, Part, evaluate, with_one_more};
use crate::diagnose::wrench::regression::shaped::Care;
use crate::diagnose::wrench::regression::tested::TestedHypothesis;
use rayon::prelude::*;
use softdock_physics::model::load::Column;
use std::collections::BTreeSet;
use std::sync::{MutexGuard, PoisonError};

impl SearchState<'_> {
    /// Removes effects that are not worth their price beside the others, one at a time. If there are several, as the others
    /// nearly imitate each, that one goes without which a fit to the logs of the fit foretells the unseen logs best. `None` if
    /// nothing is left.
    fn pruned(&self, found: TestedHypothesis) -> Option<TestedHypothesis> {
        let mut now = found;
        loop {
            let each = self.evidence_of_each(&now);
            let worthless = |place: &usize| {
                let others = now.gain - now.gain.min(each[*place].max(0.0));
                each[*place] < self.joint.threshold_of(now.effects[*place].id, others)
            };
            let worthless: Vec<usize> = (0..each.len()).filter(worthless).collect();
            let parts = self.parts(&now);
            let worth = |place: usize| match worthless.len() {
                1 => None,
                _ => self.foretold(without(&parts, place)),
            };
            let mut order: Vec<(f64, usize)> = worthless
                .iter()
                .map(|&place| (worth(place).unwrap_or(-each[place]), place))
                .collect();
            order.sort_by(|a, b| b.0.total_cmp(&a.0));
            if !order.is_empty() && parts.len() < 2 {
                return None;
            }
            let rest = |(_, place): (f64, usize)| {
                let rest = evaluate(self.library, without(&parts, place), self.price)?;
                Some(self.test(&rest)).filter(|rest| self.is_possible(rest))
            };
            match order.into_iter().find_map(rest) {
                Some(rest) => now = rest,
                // Either all are worth their price, or the rest would be impossible without any of those that are not.
                None => return Some(now),
            }
        }
    }

    /// Climbs from a start to a hypothesis that foretells the unseen logs. Forms that do not are excluded and the search goes on
    /// without them; after some such replacements nothing is added any more. The flag says whether all climbs came to their ends.
    pub(crate) fn settled(&self, start: TestedHypothesis) -> (Option<TestedHypothesis>, bool) {
        /// Replacements after which the search adds nothing more.
        const REPLACED: usize = 3;
        let mut starts = vec![start];
        let mut ended = true;
        let mut replaced = 0;
        loop {
            let ends = starts.into_iter().map(|start| match replaced <= REPLACED {
                true => self.climbed(start),
                false => (start, true),
            });
            let ends: Vec<(TestedHypothesis, bool)> = ends.collect();
            ended &= ends.iter().all(|(_, came_to_end)| *came_to_end);
            let ends = ends.into_iter().filter_map(|(end, _)| self.possible(end));
            let end = ends.max_by(|a, b| a.evidence.total_cmp(&b.evidence));
            let Some(accepted) = end.and_then(|end| self.pruned(end)) else {
                return (None, ended);
            };
            let gone = self.misleading(&accepted);
            let Some((rest, forms)) = gone.or_else(|| self.contradicted(&accepted)) else {
                let accepted = match replaced <= REPLACED {
                    true => self.with_small(accepted),
                    false => accepted,
                };
                if !self.is_forbidden_when_estimated(&accepted) {
                    return (Some(accepted), ended);
                }
                let ids = accepted.effects_in_order();
                self.forbidden().insert(ids);
                replaced += 1;
                starts = self.possible(accepted).into_iter().collect();
                continue;
            };
            self.misled().extend(forms);
            replaced += 1;
            let rest = evaluate(self.library, rest, self.price);
            let Some(rest) = rest.filter(|rest| !rest.parts.is_empty()) else {
                return (None, ended);
            };
            // A sign that physics forbids may become right beside one more effect.
            let rest = self.test(&rest);
            starts = match self.is_possible(&rest) {
                true => vec![rest],
                false => self
                    .possible(rest.clone())
                    .into_iter()
                    .chain([rest])
                    .collect(),
            };
        }
    }

    /// The answer itself, or of the hypotheses that were tried the likeliest one that is better in every respect: it has no more
    /// parameters, more evidence by odds of [`TOLD_APART`], and foretells the unseen logs better. The replacements of
    /// [`Self::settled`] go from one answer to the next and may end beside such a hypothesis.
    pub(crate) fn undominated(
        &self,
        accepted: TestedHypothesis,
        tried: &[TestedHypothesis],
    ) -> TestedHypothesis {
        let Some(gain) = self.foretold(self.parts(&accepted)) else {
            return accepted;
        };
        let mut better: Vec<&TestedHypothesis> = tried
            .iter()
            .filter(|t| t.parameters <= accepted.parameters && self.is_possible(t))
            .filter(|t| t.evidence > accepted.evidence + TOLD_APART)
            .collect();
        better.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        let foretells = |t: &&&TestedHypothesis| {
            let foretold = self.foretold(self.parts(t));
            foretold.is_some_and(|foretold| foretold > gain + TOLD_APART)
                && !self.is_forbidden_when_estimated(t)
        };
        let best = better.iter().find(foretells);
        best.map_or(accepted, |best| (*best).clone())
    }

    /// The hypothesis itself if it is possible. Else the best possible one of the same effects in other forms, or without one of
    /// them.
    fn possible(&self, now: TestedHypothesis) -> Option<TestedHypothesis> {
        if self.is_possible(&now) {
            return Some(now);
        }
        let same = with_forms_reselected(self.library, self.parts(&now), self.price);
        let others: Vec<Hypothesis> = same.into_iter().chain(self.fewer(&now)).collect();
        let others = self.tested(&others, others.len()).into_iter();
        let possible = others.filter(|other| self.is_possible(other));
        possible.max_by(|a, b| a.evidence.total_cmp(&b.evidence))
    }

    pub(crate) fn misled(&self) -> MutexGuard<'_, BTreeSet<usize>> {
        self.misled.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The effect whose removal improves the error on the unseen logs most, if by more than would name an effect. Returns the
    /// parts without it, and those of its forms that are no better. `None` if there is no such effect, or no unseen log.
    fn misleading(&self, accepted: &TestedHypothesis) -> Option<(Vec<Part>, Vec<usize>)> {
        let parts = self.parts(accepted);
        let with = self.foretold(parts.clone())?;
        let rest = |place: usize| match parts.len() {
            1 => Some(0.0),
            _ => self.foretold(without(&parts, place)),
        };
        let worse = (0..parts.len()).filter_map(|place| Some((rest(place)?, place)));
        let (rest, place) = worse.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let worse = |gain: f64| rest - gain > self.joint.threshold(0.0);
        if !worse(with) {
            return None;
        }
        let own = self.library.variants[parts[place].variant].effect.id;
        let misleads = |variant: &usize| {
            let mut other = parts.clone();
            other[place].variant = *variant;
            self.foretold(other).is_none_or(worse)
        };
        let same = (0..self.library.variants.len())
            .into_par_iter()
            .filter(|k| self.library.variants[*k].effect.id == own);
        Some((without(&parts, place), same.filter(misleads).collect()))
    }

    /// Whether physics forbids the parameters of a hypothesis when they are estimated, both from the logs of the fit and from all
    /// logs. Screening may allow it, as it leaves some parameters close to the values that they have alone.
    fn is_forbidden_when_estimated(&self, accepted: &TestedHypothesis) -> bool {
        let hypothesis = evaluate(self.library, self.parts(accepted), self.price);
        let is_forbidden = |hypothesis: &Hypothesis| {
            let mut problems = [self.of_fit, &self.joint.problem].into_iter();
            problems.all(|problem| !self.estimated(problem, hypothesis).wrong.is_empty())
        };
        hypothesis.as_ref().is_some_and(is_forbidden)
    }

    /// Sets of effects that are not possible together, ids in alphabetical order.
    pub(crate) fn forbidden(&self) -> MutexGuard<'_, BTreeSet<Vec<&'static str>>> {
        let forbidden = self.forbidden.lock();
        forbidden.unwrap_or_else(PoisonError::into_inner)
    }

    /// A detail that is at fault when the logs of the fit alone give parameters that physics forbids: without it they do not.
    /// Each of several logs has to show a detail. Returns the parts without it and all its forms.
    fn contradicted(&self, accepted: &TestedHypothesis) -> Option<(Vec<Part>, Vec<usize>)> {
        let parts = self.parts(accepted);
        let effect = |variant: usize| self.library.variants[variant].effect;
        let is_forbidden = |parts: Vec<Part>| Some(!self.of_the_fit(parts)?.wrong.is_empty());
        if !is_forbidden(parts.clone())? {
            return None;
        }
        let is_at_fault = |place: &usize| {
            let is_detail = effect(parts[*place].variant).effect.is_detail();
            is_detail && is_forbidden(without(&parts, *place)) == Some(false)
        };
        let place = (0..parts.len()).find(is_at_fault)?;
        let own = effect(parts[place].variant).id;
        let same = (0..self.library.variants.len()).filter(|k| effect(*k).id == own);
        Some((without(&parts, place), same.collect()))
    }

    /// Adds effects that explain no more than errors of form of the others could, but without which the unseen logs are foretold
    /// much worse: an error of form would differ in another motion.
    pub(crate) fn with_small(&self, accepted: TestedHypothesis) -> TestedHypothesis {
        /// Most effects, those included.
        const MOST_IN_ALL: usize = 8;
        let mut now = accepted;
        // Beside a remainder, which covers errors of form, the climb has accepted such effects already.
        while now.effects.len() < MOST_IN_ALL && self.joint.explained(now.gain) > 0.0 {
            let parts = self.parts(&now);
            let Some(alone) = evaluate(self.library, parts.clone(), self.price) else {
                break;
            };
            let mut more = with_one_more(self.library, &parts, self.price);
            more.retain(|more| more.evidence > alone.evidence);
            let more = self.tested(&more, TRIED).into_iter();
            let mut more: Vec<TestedHypothesis> = more
                .filter(|t| self.is_possible(t) && t.evidence > now.evidence + NAMED)
                .collect();
            more.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
            let Some(next) = more.into_iter().find(|more| self.foretells(&now, more)) else {
                break;
            };
            now = next;
        }
        now
    }

    /// Whether more effects reduce the error on the unseen logs by the factor [`FORETELLS`]. Where more than noise is left, which
    /// includes errors of form, the error on the logs of the fit has to fall as much.
    fn foretells(&self, less: &TestedHypothesis, more: &TestedHypothesis) -> bool {
        let errors =
            |t: &TestedHypothesis| Some(self.joint.errors(&self.of_the_fit(self.parts(t))?));
        let much = self.joint.has_much_left(more.gain);
        errors(less).zip(errors(more)).is_some_and(|(less, more)| {
            let falls = |k: usize| more[k] * FORETELLS < less[k];
            falls(1) && (!much || falls(0))
        })
    }

    /// A hypothesis fitted to the logs of the fit; `None` if these are all logs, or the parts have no solution.
    fn of_the_fit(&self, parts: Vec<Part>) -> Option<TestedHypothesis> {
        if self.joint.fitted >= self.joint.logs.len() {
            return None;
        }
        let hypothesis = evaluate(self.library, parts, self.price)?;
        Some(fitted_to(
            self.of_fit,
            self.library,
            &hypothesis,
            self.joint,
            Care::Screening,
        ))
    }

    /// Fall of χ² on the unseen logs by a hypothesis that is fitted to the others; `None` if there are no unseen logs.
    fn foretold(&self, parts: Vec<Part>) -> Option<f64> {
        let fitted = self.joint.fitted;
        let of_fit = self.of_the_fit(parts)?;
        let all: Vec<Column> = self
            .joint
            .logs
            .iter()
            .map(|log| of_fit.contribution(&log.scene))
            .collect();
        let white = self.joint.problem.whitened(&all.iter().collect::<Vec<_>>());
        let gains = self.joint.problem.gains(&white);
        Some(gains.iter().skip(fitted).sum())
    }
}
