//! Which effects keep enough evidence of their own when a smooth remainder is fitted beside them.
//!
//! Where structure is left, evidence at the price of white noise is misleading: errors of a law's form are worth more than whole
//! effects, and of several effects that imitate each other that one wins whose error of form happens to fit. So the search is
//! repeated beside the smooth remainder that its own answer leaves, until an answer repeats. From the answer without and the
//! answer with a remainder, those effects are dropped that a remainder would explain as well; then the better of the two is
//! taken.

use super::finding::{Imitated, WrenchFinding};
use super::remainder;
use super::{Joint, Smooth, TestedHypothesis, smooth, standings, worths};
use crate::diagnose::catalogue::simplest;
use crate::diagnose::evidence::{NAMED, RISES};
use crate::diagnose::question::Question;
use softdock_physics::effects::by_id;
use softdock_physics::model::load::effects::LoadEffect;
use softdock_physics::model::{Axis, Model};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Most searches beside a remainder. Each one uses the remainder that the previous answer leaves.
const ROUNDS: usize = 4;

/// Asks for searches on the reading.
pub(crate) struct Asking<'a> {
    /// The model as it is.
    pub model: &'a Model,
    /// The question, passed on to each search unless it is replaced.
    pub question: &'a Question<'a>,
    /// Runs a search on the reading beside the effects of the given model.
    pub search: &'a mut dyn FnMut(&Model, &Question<'_>) -> Option<WrenchFinding>,
}

impl Asking<'_> {
    /// The finding for another question about the same model.
    pub(crate) fn ask(&mut self, question: &Question<'_>) -> Option<WrenchFinding> {
        (self.search)(self.model, question)
    }

    /// The finding if the search may choose among these effects only.
    pub(crate) fn among(&mut self, ids: &[String]) -> Option<WrenchFinding> {
        self.among_beside(ids, None)
    }

    /// The same beside a remainder.
    fn among_beside(
        &mut self,
        ids: &[String],
        beside: Option<&Arc<Smooth>>,
    ) -> Option<WrenchFinding> {
        self.ask(&Question {
            among: Some(ids),
            beside,
            ..*self.question
        })
    }
}

/// What a search beside a smooth remainder finds.
pub(crate) struct RepeatedSearch {
    pub finding: WrenchFinding,
    /// The logs as prepared with no effect accepted: the common baseline on which answers are compared.
    pub nothing: Joint,
    /// Axes of the remainder.
    pub axes: Vec<Axis>,
}

/// Repeats the search beside a smooth remainder: first that of `first`, then that of each new answer, until an answer repeats or
/// [`ROUNDS`] is reached. `None` if no structure is left, or a search finds nothing to work on.
pub(crate) fn anew(first: &WrenchFinding, asking: &mut Asking<'_>) -> Option<RepeatedSearch> {
    let axes = first.structured_axes();
    if axes.is_empty() {
        return None;
    }
    let nothing = asking.among(&[])?.prepared;
    let mut now = first.whole_hypothesis();
    let mut seen = vec![now.effects_in_order()];
    let mut finding = None;
    for _ in 0..ROUNDS {
        let smooth = Arc::new(smooth(&nothing, &now, &axes));
        let found = asking.ask(&Question {
            beside: Some(&smooth),
            ..*asking.question
        })?;
        let next = found.whole_hypothesis();
        finding = Some(found);
        // The same answer would leave the same remainder, and the searches would cycle.
        if seen.contains(&next.effects_in_order()) {
            break;
        }
        seen.push(next.effects_in_order());
        now = next;
    }
    Some(RepeatedSearch {
        finding: finding?,
        nothing,
        axes,
    })
}

/// Of two answers the one with the smaller error on unseen data. If they name different effects and their errors differ by less
/// than [`RISES`], the likelier one.
pub(crate) fn better(
    first: WrenchFinding,
    anew: WrenchFinding,
    nothing: &Joint,
    axes: &[Axis],
) -> WrenchFinding {
    let both = [&first, &anew].map(WrenchFinding::whole_hypothesis);
    let [error, of_anew] = both.each_ref().map(|of| nothing.error_on_unseen(of));
    // Where both name the same effects only their form differs, and the error decides between forms.
    let same = both[0].is_same(&both[1]);
    let alike = if same { 1.0 } else { RISES };
    let is_better = if error.max(of_anew) > alike * error.min(of_anew) {
        of_anew < error
    } else {
        let worths = worths(nothing, &both.each_ref(), axes);
        worths[1] > worths[0]
    };
    if is_better { anew } else { first }
}

/// Adds a general curve (a hysteresis, which fits many mechanisms) to the ranked hypotheses if it leaves less than the answer
/// does. A friction that builds up after each reversal looks like a delay of all that loads the sensor. So where such a curve
/// does as well as effects that are late, and these stand beside others, the late effects are removed from the answer.
pub(crate) fn beside_curves(first: WrenchFinding, asking: &mut Asking<'_>) -> WrenchFinding {
    let mut finding = first;
    let beside_others =
        !finding.found.before_late.is_empty() || finding.has_dry_friction(asking.model);
    let late = match beside_others {
        true => finding.late_ids(),
        false => Vec::new(),
    };
    let asks = !late.is_empty() || finding.remaining_structure().is_structured();
    if !asks || asking.question.tries_general_curves() {
        return finding;
    }
    let beside = finding.beside.clone();
    let curves = asking.ask(&Question {
        general_curves: true,
        without: &asking.question.also_without(&late),
        beside: beside.as_ref(),
        ..*asking.question
    });
    let Some((curves, curve)) = curves.and_then(|curves| {
        let curve = finding.better_curve(&curves, !late.is_empty())?;
        Some((curves, curve))
    }) else {
        return finding;
    };
    if !late.is_empty() {
        // If laws that are not late do as well, the curve has explained nothing that they do not.
        let laws = asking.ask(&Question {
            without: &asking.question.also_without(&late),
            beside: beside.as_ref(),
            ..*asking.question
        });
        if laws.is_some_and(|laws| laws.is_as_good_as(&finding) && laws.is_as_good_as(&curves)) {
            return finding;
        }
        if let Some(fewer) = asking.among_beside(&finding.ids_without(&late), beside.as_ref()) {
            finding = beside_remainder(fewer, asking);
            finding.found.curve_in_place_of = late;
        }
    }
    finding.found.ranked.push(curve);
    finding
}

/// Whether logs that disagree about delays alone agree on one general curve, with the same amounts in all logs, that leaves less
/// than the delays do. A friction that builds up over a distance looks like a delay that is longer the slower the axis moves.
pub(crate) fn agree_on_a_curve(finding: &WrenchFinding, asking: &mut Asking<'_>) -> bool {
    let delays: Vec<String> = finding.late_ids();
    let about: Vec<String> = finding.disagreeing_ids();
    let is_late = |id: &String| LoadEffect::find(asking.model, id).is_some_and(LoadEffect::is_late);
    if asking.question.tries_general_curves() || !about.iter().all(is_late) {
        return false;
    }
    let without: Vec<String> = delays.into_iter().chain(about).collect();
    let curves = asking.ask(&Question {
        general_curves: true,
        without: &asking.question.also_without(&without),
        ..*asking.question
    });
    curves.is_some_and(|curves| {
        let is_better = finding.better_curve(&curves, false).is_some();
        is_better && curves.found.disagreeing.is_empty()
    })
}

/// Keeps only those effects that a smooth remainder would not explain as well, where structure is left. The weakest is dropped
/// first, one at a time, and the others get the parameters and intervals that they have beside the remainder. An effect without
/// which unseen data are foretold much worse stays, as no remainder foretells. An effect that was dropped while others were still
/// there is tried once more at the end.
pub(crate) fn beside_remainder(first: WrenchFinding, asking: &mut Asking<'_>) -> WrenchFinding {
    let beside = first.beside.clone();
    let mut finding = first;
    let mut imitated = Vec::new();
    let mut foretelling = BTreeMap::new();
    let mut least = finding.error_on_unseen();
    while let Some((place, one)) = weakest(&mut finding, &foretelling) {
        let gone = finding.ids().swap_remove(place);
        let mut ids = finding.ids_without(std::slice::from_ref(&gone));
        ids.extend(in_place_of_detail(&gone, &ids));
        let is_law = finding.is_a_law(&gone);
        if !is_law {
            ids.extend(simplest(asking.model, &gone).map(str::to_owned));
        }
        let Some(mut fewer) = asking.among_beside(&ids, beside.as_ref()) else {
            imitated.push(one);
            break;
        };
        if let Some(worse) = fewer.foretells_worse_by(least).filter(|_| is_law) {
            foretelling.insert(gone, worse * least / finding.error_on_unseen());
            continue;
        }
        imitated.push(one);
        fewer.remember(&finding);
        fewer.found.before_late.extend(finding.found.before_late);
        finding = fewer;
        least = least.min(finding.error_on_unseen());
    }
    // An effect that was dropped may have returned, as what a dropped detail is taken for.
    imitated.retain(|one| !finding.ids().contains(&one.id));
    let unrefuted = second_chance(&mut finding, &mut foretelling, &mut imitated, asking);
    // The amounts may differ if an effect is present that has evidence, but too little to be named: the intervals include that
    // answer.
    unrefuted.iter().for_each(|other| finding.hold(other));
    finding.foretell(&foretelling);
    if finding.found.accepted.is_none() && finding.prepared.known > 0.0 {
        finding.record_remainder_of_model();
    }
    if !imitated.is_empty() {
        finding.beside_remainder.get_or_insert_default().imitated = imitated;
    }
    finding
}

/// The effects to offer when a detail is dropped: what it is a detail of, and what it is confused with. A friction that differs
/// by direction, for example, contains a constant force as well. Empty if `id` is no detail; without the effects in `there`.
fn in_place_of_detail(id: &str, there: &[String]) -> Vec<String> {
    let Some(detail) = by_id(id).filter(|effect| effect.is_detail()) else {
        return Vec::new();
    };
    let plain = detail.detail_of.iter().map(|(id, _)| id);
    let plain = plain.chain(detail.confused_with);
    let mut ids: Vec<String> = plain.map(|id| (*id).to_owned()).collect();
    ids.sort();
    ids.dedup();
    ids.retain(|id| !there.contains(id));
    ids
}

/// Offers each dropped effect once more beside those that are left, and takes it back if now all stand beside the remainder.
/// Returns the answers that contain a dropped effect which has evidence, but still does not stand.
fn second_chance(
    finding: &mut WrenchFinding,
    foretelling: &mut BTreeMap<String, f64>,
    imitated: &mut Vec<Imitated>,
    asking: &mut Asking<'_>,
) -> Vec<TestedHypothesis> {
    let mut unrefuted = Vec::new();
    for Imitated { id, evidence, .. } in imitated.clone() {
        let mut ids = finding.ids();
        ids.push(id.clone());
        let Some(mut more) = asking.among_beside(&ids, finding.beside.as_ref()) else {
            continue;
        };
        if !more.ids().contains(&id) {
            // The same effects are found again, but this search has found better shapes or forms of them.
            let same = more.whole_hypothesis().is_same(&finding.whole_hypothesis());
            if same && more.error_on_unseen() * RISES < finding.error_on_unseen() {
                *finding = more;
            }
            continue;
        }
        let worse = finding.foretells_worse_by(more.error_on_unseen());
        let worse = worse.filter(|_| more.is_a_law(&id));
        let mut with_it = foretelling.clone();
        with_it.extend(worse.map(|worse| (id.clone(), worse)));
        if weakest(&mut more, &with_it).is_none() {
            (*finding, *foretelling) = (more, with_it);
            imitated.retain(|other| other.id != id);
        } else if evidence > 0.0 {
            unrefuted.push(more.whole_hypothesis());
        }
    }
    unrefuted
}

/// Replaces an effect that has several amounts by one of the same kind that has one (a dry friction for a Stribeck curve), if
/// that foretells unseen data as well: where structure is left, a form with more amounts wins because these happen to fit. A
/// detail is replaced by what it is confused with, if the error rises by less than [`RISES`]: a motor's sensor has a zero more
/// often than a joint brakes more in one direction.
pub(crate) fn simpler(first: WrenchFinding, asking: &mut Asking<'_>) -> WrenchFinding {
    let mut finding = first;
    for id in finding.ids() {
        // An earlier pass of this loop may have taken an answer without this effect.
        if !finding.ids().contains(&id) {
            continue;
        }
        let others = finding.ids_without(std::slice::from_ref(&id));
        let (in_place, alike) = match simplest(asking.model, &id) {
            Some(simple) => (vec![simple.to_owned()], 1.0),
            None => (in_place_of_detail(&id, &others), RISES),
        };
        if in_place.is_empty() {
            continue;
        }
        let ids = [&others[..], &in_place].concat();
        let beside = finding.beside.clone();
        let Some(other) = asking.among_beside(&ids, beside.as_ref()) else {
            continue;
        };
        let other = beside_remainder(other, asking);
        let stands = other.ids().iter().any(|id| in_place.contains(id));
        if stands && other.error_on_unseen() <= alike * finding.error_on_unseen() {
            finding = other;
        }
    }
    finding
}

/// The effect that stands weakest beside a smooth remainder: its place among all effects, earlier ones first, and its evidence.
/// `None` if all effects stand, which is then recorded in `finding`, or if no structure is left. Effects in `foretelling` are not
/// tested.
fn weakest(
    finding: &mut WrenchFinding,
    foretelling: &BTreeMap<String, f64>,
) -> Option<(usize, Imitated)> {
    let accepted = finding.found.accepted.as_ref()?;
    let axes = finding.structured_axes();
    if axes.is_empty() {
        return None;
    }
    let each = standings(&finding.prepared, &finding.earlier.0, accepted, &axes);
    let model = &finding.prepared.logs.first()?.scene.model;
    let effects = finding.earlier.0.iter().chain(&accepted.effects);
    let places = each.iter().zip(effects).map(|(one, effect)| Imitated {
        id: effect.id.to_owned(),
        evidence: one.evidence,
        determined: one.determines(effect, model),
    });
    let least = |these: Vec<(usize, Imitated)>| {
        let these = these.into_iter();
        these.min_by(|a, b| a.1.evidence.total_cmp(&b.1.evidence))
    };
    // An effect may be undetermined only because weaker ones imitate it, so those with too little evidence go first.
    let asked = places.enumerate();
    let asked = asked.filter(|(_, one)| !foretelling.contains_key(&one.id));
    let (weak, strong): (Vec<_>, Vec<_>) = asked.partition(|(_, one)| one.evidence < NAMED);
    let undetermined = strong.into_iter().filter(|(_, one)| !one.determined);
    let fails = least(weak).or_else(|| least(undetermined.collect()));
    if fails.is_none() {
        let (earlier, _) = &finding.earlier;
        let remainder = remainder(&finding.prepared, earlier, accepted, &axes);
        finding.record_standings(&each, remainder, foretelling);
    }
    fails
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_friction_by_direction_holds_an_offset() {
        let there = ["guide_coulomb", "bearing_inertia"].map(str::to_owned);
        let others = in_place_of_detail("guide_asymmetry", &there);
        assert_eq!(others, ["ft_bias", "guide_offset", "guide_viscous"]);
        assert!(in_place_of_detail("guide_coulomb", &[]).is_empty());
    }
}
