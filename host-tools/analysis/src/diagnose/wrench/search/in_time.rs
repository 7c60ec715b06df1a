//! Late effects (those that move the reading in time), tested beside sharper forms of the effects that they move.

use super::model_selection::{away, other_forms};
use super::{MOST, SearchState};
use crate::diagnose::wrench::regression::hypothesis::{Hypothesis, Part, evaluate};
use crate::diagnose::wrench::regression::shaped::Shaped;
use crate::diagnose::wrench::regression::tested::TestedHypothesis;
use crate::diagnose::wrench::regression::variants::Variant;
use rayon::prelude::*;
use softdock_physics::model::load::effects::Shape;
use std::collections::BTreeMap;

impl SearchState<'_> {
    /// The best hypothesis that combines a late effect with the sharpest form of an effect that was found. A late reading makes a
    /// reversal look round, and beside the round form it does not look late: neither is found without the other. `None` if the
    /// answer has a late effect already, has no room for one, or leaves little.
    pub(crate) fn late_beside_sharp_forms(
        &self,
        accepted: &TestedHypothesis,
    ) -> Option<TestedHypothesis> {
        let is_full = accepted.effects.len() >= MOST;
        if is_full || self.is_late(accepted) || !self.joint.has_much_left(accepted.gain) {
            return None;
        }
        let parts = self.parts(accepted);
        let sharp = (0..parts.len()).filter_map(|place| self.with_sharp_form(&parts, place));
        let late = |variant: &usize| self.library.variants[*variant].effect.is_late();
        let late: Vec<usize> = (0..self.library.variants.len()).filter(late).collect();
        let both: Vec<(Vec<Part>, usize)> = sharp
            .flat_map(|parts| late.iter().map(move |late| (parts.clone(), *late)))
            .collect();
        let both = both.into_par_iter();
        let all: Vec<Hypothesis> = both
            .filter_map(|(parts, late)| self.with_late(parts, late))
            .collect();
        let mut best: BTreeMap<&str, Hypothesis> = BTreeMap::new();
        for hypothesis in all {
            let last = hypothesis.parts.last()?;
            let id = self.library.variants[last.variant].effect.id;
            let known = best.get(id).map_or(f64::NEG_INFINITY, |h| h.evidence);
            if hypothesis.evidence > known {
                best.insert(id, hypothesis);
            }
        }
        let mut best: Vec<Hypothesis> = best.into_values().collect();
        let others = best.iter().filter_map(|best| self.with_other_forms(best));
        best.extend(others.collect::<Vec<_>>());
        let tested = self.tested(&best, best.len()).into_iter();
        tested
            .filter(|t| self.is_possible(t))
            .max_by(|a, b| a.evidence.total_cmp(&b.evidence))
    }

    /// The parts, with one of them in its sharpest form; `None` if it has that already.
    fn with_sharp_form(&self, parts: &[Part], place: usize) -> Option<Vec<Part>> {
        let now = &self.library.variants[parts[place].variant];
        let shapes = || now.effect.shapes.iter().enumerate();
        let is_size = |shape: &Shape| shape.choice && shape.continuous;
        let sharpest = |(k, shape): (usize, &Shape)| {
            let tried = now.effect.tried_values(shape, self.joint.pace());
            is_size(shape).then(|| (k, tried.into_iter().fold(f64::INFINITY, f64::min)))
        };
        let sharpest: Vec<(usize, f64)> = shapes().filter_map(sharpest).collect();
        let is_sharp = |v: &Variant| sharpest.iter().all(|(k, least)| v.shapes[*k] == *least);
        let others: Vec<usize> = shapes().filter(|s| !is_size(s.1)).map(|s| s.0).collect();
        let away = |v: &Variant| -> f64 {
            let of = |k: &usize| away(v.shapes[*k], now.shapes[*k]);
            others.iter().map(of).sum()
        };
        let same = self.library.variants.iter().enumerate();
        let same = same.filter(|(_, v)| v.effect.id == now.effect.id && is_sharp(v));
        let (variant, _) = same.min_by(|a, b| away(a.1).total_cmp(&away(b.1)))?;
        let mut other = parts.to_vec();
        other[place].variant = variant;
        (!is_sharp(now)).then_some(other)
    }

    /// The best other form of one of the loads beside the same late effect; `None` if none is better.
    fn with_other_forms(&self, late: &Hypothesis) -> Option<Hypothesis> {
        let (last, rest) = late.parts.split_last()?;
        let forms = (0..rest.len()).flat_map(|place| other_forms(self.library, rest, place));
        let forms: Vec<Vec<Part>> = forms.collect();
        let all = forms.into_par_iter();
        let all = all.filter_map(|parts| self.with_late(parts, last.variant));
        let best = all.max_by(|a, b| a.evidence.total_cmp(&b.evidence))?;
        (best.evidence > late.evidence).then_some(best)
    }

    /// Adds a late variant, whose column is computed around the load of the other parts.
    fn with_late(&self, mut parts: Vec<Part>, late: usize) -> Option<Hypothesis> {
        let used = (0..self.library.variants[late].columns.len()).collect();
        parts.push(Part {
            variant: late,
            used,
        });
        let screened = evaluate(self.library, parts, self.price)?;
        let shaped = Shaped::new(
            self.joint,
            &self.joint.problem,
            self.library,
            &screened.parts,
        );
        let solution = shaped.solution()?;
        Some(Hypothesis {
            evidence: screened.evidence + (solution.gain - screened.solution.gain),
            solution,
            ..screened
        })
    }
}
