//! The result of the search on the reading, over all rounds, and the questions that can be asked of it.

use super::left::{self, RemainingStructure};
use super::remainder;
use super::{
    Fitted, Joint, NominalEstimate, PreparedLog, Remainder, SearchResult, Smooth, Standing,
    TestedHypothesis, smooth,
};
use crate::diagnose::catalogue::{is_general_curve, simplest};
use crate::diagnose::evidence::{FORETELLS, Support, UNLIKELY};
use softdock_physics::effects::{Kind, by_id};
use softdock_physics::model::load::effects::LoadEffect;
use softdock_physics::model::{Axis, Model};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The unmodelled wrench.
pub(crate) struct WrenchFinding {
    /// Result of the last search.
    pub found: SearchResult,
    /// All logs, ready for further questions.
    pub prepared: Joint,
    /// Effects that earlier rounds accepted, and the support of each.
    pub earlier: (Vec<Fitted>, Vec<Support>),
    /// The remainder beside which this search was done, if any.
    pub beside: Option<Arc<Smooth>>,
    /// How the effects stand beside a smooth remainder; `None` if no structure is left or this was not tested.
    pub beside_remainder: Option<BesideRemainder>,
}

/// Which effects stand beside a smooth remainder, and which do not.
#[derive(Default)]
pub(crate) struct BesideRemainder {
    /// Effects that the remainder would explain as well, and that are therefore left out.
    pub imitated: Vec<Imitated>,
    /// The remainder beside what is accepted.
    pub remainder: Remainder,
}

/// An effect that a smooth remainder would explain as well.
#[derive(Clone)]
pub(crate) struct Imitated {
    /// The effect.
    pub id: String,
    /// Evidence for it beside the remainder.
    pub evidence: f64,
    /// Whether the interval of one of its coefficients leaves out 0.
    pub determined: bool,
}

impl WrenchFinding {
    /// Ids of all effects, the earlier ones first.
    pub(crate) fn ids(&self) -> Vec<String> {
        let earlier = self.earlier.0.iter().map(|e| e.id.to_owned());
        let accepted = self.found.accepted.iter().flat_map(TestedHypothesis::ids);
        earlier.chain(accepted).collect()
    }

    /// One hypothesis of all effects, of this and of earlier rounds.
    pub(crate) fn whole_hypothesis(&self) -> TestedHypothesis {
        let accepted = self.found.accepted.iter().flat_map(|t| &t.effects);
        let effects: Vec<Fitted> = self.earlier.0.iter().chain(accepted).cloned().collect();
        let parameters = effects.iter().flat_map(|e| e.parameters.values());
        TestedHypothesis {
            parameters: parameters.filter(|p| p.sigma > 0.0).count(),
            effects,
            ..TestedHypothesis::default()
        }
    }

    /// The likeliest hypothesis that was tried and has an effect of which `is_it` is true.
    pub(crate) fn likeliest_with(&self, is_it: impl Fn(&str) -> bool) -> Option<&TestedHypothesis> {
        let has_it = |tested: &&TestedHypothesis| tested.effects.iter().any(|one| is_it(one.id));
        let with_it = self.found.ranked.iter().filter(has_it);
        with_it.max_by(|a, b| a.evidence.total_cmp(&b.evidence))
    }

    /// What the accepted effects leave.
    pub(crate) fn remaining_structure(&self) -> RemainingStructure {
        left::of_wrench(&self.prepared, self.found.accepted.as_ref(), &[])
    }

    /// Axes on which structure is left.
    pub(crate) fn structured_axes(&self) -> Vec<Axis> {
        let left = self.remaining_structure();
        left.structured().map(|(_, axis, _)| *axis).collect()
    }

    /// Evidence less the χ² that is left after the fit. It compares searches that have held different nominal parameters at their
    /// values.
    fn score(&self) -> f64 {
        let accepted = self.found.accepted.as_ref();
        let (evidence, gain) = accepted.map_or((0.0, 0.0), |t| (t.evidence, t.gain));
        evidence - gain - self.prepared.remaining_chi2(gain)
    }

    /// What the accepted effects may owe to errors of a law's form, plus the evidence needed to be named.
    fn form(&self) -> f64 {
        let accepted = self.found.accepted.as_ref();
        self.prepared.threshold(accepted.map_or(0.0, |t| t.gain))
    }

    /// The answer of a search that may use general curves, if it has such a curve and its score is better by [`Self::form`]. With
    /// `in_place_of_late` it is enough that it is not worse by as much.
    pub(crate) fn better_curve(
        &self,
        other: &Self,
        in_place_of_late: bool,
    ) -> Option<TestedHypothesis> {
        let form = if in_place_of_late {
            -self.form()
        } else {
            self.form()
        };
        let curve = other.found.accepted.clone()?;
        let is_better = other.score() > self.score() + form;
        let is_curve = curve.effects.iter().any(|e| is_general_curve(e.id));
        (is_better && is_curve).then(|| curve.beside_noise(self.chi2_as_tried()))
    }

    /// χ² of all there was to explain, with the noise model under which the accepted hypothesis was tried. Under another noise
    /// model χ² has another scale, but the share that is explained is the same.
    fn chi2_as_tried(&self) -> f64 {
        let accepted = self.found.accepted.as_ref();
        let as_tried = accepted.and_then(|now| self.found.ranked.iter().find(|t| t.is_same(now)));
        as_tried.map_or(self.prepared.problem.chi2, |t| t.to_explain)
    }

    /// Nominal parameters beside the accepted effects. Where structure is left, they are estimated beside a smooth remainder: the price of white noise would claim more certainty
    /// than the logs give, as it does for effects.
    pub(crate) fn nominal(&mut self) -> Vec<NominalEstimate> {
        let axes = self.structured_axes();
        let accepted = self.found.accepted.as_ref();
        if axes.is_empty() {
            return self.prepared.nominal(&self.earlier.0, accepted);
        }
        let nothing = TestedHypothesis::default();
        let smooth = smooth(&self.prepared, accepted.unwrap_or(&nothing), &axes);
        self.prepared.add_remainder(&smooth);
        let nominal = self.prepared.nominal(&self.earlier.0, accepted);
        self.prepared.remove_remainder(&smooth);
        nominal
    }

    /// Whether this search leaves as little as the other one, up to errors of a law's form.
    pub(crate) fn is_as_good_as(&self, other: &Self) -> bool {
        self.score() > other.score() - other.form()
    }

    /// Keeps what an earlier search tried that could choose among more effects: this search has not seen the rivals among those.
    pub(crate) fn remember(&mut self, earlier: &Self) {
        let mut tried = earlier.found.ranked.clone();
        // A parameter that only one of the searches holds at its value adds to what there is to explain in that search alone.
        let is_plain = self.beside.is_none() && earlier.beside.is_none();
        let more = self.prepared.more_to_explain_than(&earlier.prepared);
        if let Some(more) = more.filter(|_| is_plain) {
            let chi2 = earlier.prepared.problem.chi2;
            let of_it = tried.iter_mut().filter(|t| t.is_beside_noise_of(chi2));
            of_it.for_each(|t| *t = t.clone().with_more_to_explain(&more));
        }
        if let Some(accepted) = &self.found.accepted {
            let ids = accepted.ids();
            // The evidence of the answer is taken from the same search, as evidence is comparable only under one noise model.
            let same = tried.iter().filter(|t| t.is_same(accepted));
            let own = same.map(|t| t.evidence);
            let own = own.reduce(f64::max).unwrap_or(accepted.evidence);
            let support = ids.iter().zip(&mut self.found.support);
            for (id, support) in support {
                let others = |t: &&TestedHypothesis| {
                    let kept = t.ids().iter().filter(|other| ids.contains(other)).count();
                    let lacks_it = t.effects.iter().all(|effect| effect.id != id);
                    let one_exchanged = t.effects.len() == ids.len() && kept + 1 == ids.len();
                    lacks_it && one_exchanged && t.wrong.is_empty()
                };
                let rivals = tried.iter().filter(others).map(|t| t.evidence);
                let best = rivals.fold(f64::NEG_INFINITY, f64::max);
                *support = support.with_rival(own - best);
            }
        }
        self.found.ranked.extend(tried);
    }

    /// Whether an accepted effect may be called by its name. It may not if it is a detail of another effect (a matter of form),
    /// or if a simpler effect of its kind exists and the logs do not determine its coefficients.
    pub(crate) fn is_a_law(&self, id: &str) -> bool {
        let model = self.prepared.logs.first().map(|log| &log.scene.model);
        let accepted = self.found.accepted.iter().flat_map(|t| &t.effects);
        let mut all = self.earlier.0.iter().chain(accepted);
        let fitted = all.find(|effect| effect.id == id).zip(model);
        fitted.is_some_and(|(fitted, model)| {
            let effect = LoadEffect::find(model, id);
            let effect = effect.filter(|effect| !effect.effect.is_detail());
            effect.is_some() && (simplest(model, id).is_none() || fitted.is_determined(model))
        })
    }

    /// Rms error of the accepted effects on logs that no fit has seen, in units of the noise.
    pub(crate) fn error_on_unseen(&self) -> f64 {
        let accepted = self.found.accepted.clone().unwrap_or_default();
        self.prepared.error_on_unseen(&accepted)
    }

    /// Ratio of this error on unseen logs to `error`, that of a finding with more effects. `None` if the ratio is at most
    /// [`FORETELLS`] or the error decides nothing.
    pub(crate) fn foretells_worse_by(&self, error: f64) -> Option<f64> {
        let worse = self.error_on_unseen() / error;
        (self.can_foretell() && worse > FORETELLS).then_some(worse)
    }

    /// Whether the error on unseen logs may decide. It may not where all logs were fitted, nor where something touches: an
    /// imitation of a contact's law foretells as well as that law.
    pub(crate) fn can_foretell(&self) -> bool {
        let Joint { logs, fitted, .. } = &self.prepared;
        let touches = |log: &PreparedLog| log.scene.touches_anything();
        *fitted < logs.len() && !logs.iter().any(touches)
    }

    /// Widens the intervals of the accepted effects so that they include the values of another answer.
    pub(crate) fn hold(&mut self, other: &TestedHypothesis) {
        let accepted = self.found.accepted.iter_mut().flat_map(|t| &mut t.effects);
        for effect in accepted.chain(&mut self.earlier.0) {
            let same = other.effects.iter().find(|other| other.id == effect.id);
            same.into_iter().for_each(|same| effect.hold(same));
        }
    }

    /// Limits the intervals of effects to values with which unseen data are not foretold much worse. `each`: by what factor the
    /// error rises without the effect.
    pub(crate) fn foretell(&mut self, each: &BTreeMap<String, f64>) {
        let accepted = self.found.accepted.iter_mut().flat_map(|t| &mut t.effects);
        for effect in accepted.chain(&mut self.earlier.0) {
            let worse = each.get(effect.id).copied();
            worse.into_iter().for_each(|worse| effect.foretells(worse));
        }
    }

    /// The first accepted effect, but those in `but`, that the logs do not determine, or without which another hypothesis is
    /// likelier by far. The latter happens as the search had ended with it.
    pub(crate) fn unsure(&self, but: &BTreeMap<String, f64>) -> Option<String> {
        let model = &self.prepared.logs.first()?.scene.model;
        let accepted = self.found.accepted.iter().flat_map(|t| &t.effects);
        let each = accepted.zip(&self.found.support);
        let unsure = each
            .filter(|(effect, _)| !but.contains_key(effect.id))
            .find(|(effect, support)| support.against < -UNLIKELY || !effect.is_determined(model));
        unsure.map(|(effect, _)| effect.id.to_owned())
    }

    /// Effects whose intervals exclude that they are absent.
    pub(crate) fn significant_ids(&self) -> Vec<String> {
        let model = self.prepared.logs.first().map(|log| &log.scene.model);
        let accepted = self.found.accepted.iter().flat_map(|t| &t.effects);
        let all = self.earlier.0.iter().chain(accepted);
        let significant =
            all.filter(|effect| model.is_some_and(|model| effect.is_significant(model)));
        significant.map(|effect| effect.id.to_owned()).collect()
    }

    /// Accepted effects that move the reading in time.
    pub(crate) fn late_ids(&self) -> Vec<String> {
        self.accepted_ids_that(LoadEffect::is_late)
    }

    /// Effects about which the logs disagree.
    pub(crate) fn disagreeing_ids(&self) -> Vec<String> {
        let all = self.found.disagreeing.iter();
        all.map(|one| one.id.to_owned()).collect()
    }

    /// Accepted effects that follow the time and nothing else.
    pub(crate) fn drift_ids(&self) -> Vec<String> {
        self.accepted_ids_that(LoadEffect::is_a_drift)
    }

    fn accepted_ids_that(&self, is: impl Fn(&LoadEffect) -> bool) -> Vec<String> {
        let model = self.prepared.logs.first().map(|log| &log.scene.model);
        let is_one = |id: &String| {
            let effect = model.and_then(|model| LoadEffect::find(model, id));
            effect.is_some_and(&is)
        };
        self.ids().into_iter().filter(is_one).collect()
    }

    /// Whether a dry friction is among the accepted effects, or the effects of the model.
    pub(crate) fn has_dry_friction(&self, model: &Model) -> bool {
        let is_dry = |id: &str| by_id(id).is_some_and(|e| e.kind == Some(Kind::DryFriction));
        let mut known = model.effects.iter();
        known.any(|effect| is_dry(&effect.id)) || self.ids().iter().any(|id| is_dry(id))
    }

    /// Ids for another search without the effects in `gone`. If a late effect is among these, the effects return that were left
    /// out for its sake.
    pub(crate) fn ids_without(&self, gone: &[String]) -> Vec<String> {
        let mut ids = self.ids();
        if self.late_ids().iter().any(|late| gone.contains(late)) {
            let before = self.found.before_late.iter();
            let more: Vec<String> = before.filter(|id| !ids.contains(id)).cloned().collect();
            ids.extend(more);
        }
        ids.retain(|id| !gone.contains(id));
        ids
    }

    /// Records the remainder that stands beside the effects of the model alone, where structure is left.
    pub(crate) fn record_remainder_of_model(&mut self) {
        let axes = self.structured_axes();
        if !axes.is_empty() {
            let nothing = TestedHypothesis::default();
            let remainder = remainder(&self.prepared, &[], &nothing, &axes);
            self.record_standings(&[], remainder, &BTreeMap::new());
        }
    }

    /// Sets evidence and intervals to those that each effect, earlier ones first, has beside the remainder. Evidence against
    /// rivals at the price of white noise is dropped, as it says nothing there. An effect in `foretelling` keeps its own.
    pub(crate) fn record_standings(
        &mut self,
        each: &[Standing],
        remainder: Remainder,
        foretelling: &BTreeMap<String, f64>,
    ) {
        self.beside_remainder = Some(BesideRemainder {
            imitated: Vec::new(),
            remainder,
        });
        let accepted = self.found.accepted.iter_mut().flat_map(|t| &mut t.effects);
        let effects = self.earlier.0.iter_mut().chain(accepted);
        let support = self.earlier.1.iter_mut().chain(&mut self.found.support);
        let each = effects.zip(support).zip(each);
        for ((effect, support), standing) in each {
            if foretelling.contains_key(effect.id) {
                continue;
            }
            *support = match self.beside {
                Some(_) => support.at_most(standing.evidence),
                None => Support::without_rival(standing.evidence),
            };
            effect.record_amount_ratio(standing.amount);
        }
    }
}
